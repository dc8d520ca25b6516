// A rendered drawing that moves by fractions of a pixel under an image, and the least-squares
// estimate of where it lies.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/imaging/image.h"

namespace orient {

using FloatPlane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// An image in which the drawing is looked for: zero where it has no data.
struct SeenPlane {
  explicit SeenPlane(const Image& image);
  FloatPlane values, valid;
};

struct DrawingMatch {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // of the drawing, pixels of the image
  double gain = 0;
  double correlation = 0;
};

class MovingDrawing {
 public:
  // `drawing`: an odd number of pixels on a side, its centre in the middle, smooth enough for an
  // interpolating cubic spline and without NaN. `part`: 1 for the pixels that take part, else 0.
  MovingDrawing(const FloatPlane& drawing, const FloatPlane& part);

  // Empty where it does not converge within `max_shift_px` of `start`, leaves the image, or is flat
  // or singular there.
  std::optional<DrawingMatch> Match(const SeenPlane& seen, const Eigen::Vector2d& start,
                                    double max_shift_px) const;

 private:
  struct Moved;
  Moved MoveBy(const Eigen::Vector2d& fraction) const;

  FloatPlane coefficients_;  // of the spline
  FloatPlane part_;          // its border of two pixels is never used
  double part_count_ = 0;
};

}  // namespace orient

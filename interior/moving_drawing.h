// A rendered drawing that moves by fractions of a pixel under an image, and the least-squares
// estimate of where it lies.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/imaging/float_sums.h"
#include "core/imaging/image.h"

namespace orient {

// An image in which the drawing is looked for: zero where it has no data.
struct SeenPlane {
  explicit SeenPlane(const Image& image);
  Eigen::Index width = 0, height = 0;
  FloatPlane values, valid;  // with some zeros behind every row
};

struct DrawingMatch {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // of the drawing, pixels of the image
  double gain = 0;
  double correlation = 0;
};

// Which of a drawing's pixels take part.
class DrawingPart {
 public:
  // 1 for the pixels that take part, else 0; an odd number of pixels on a side.
  explicit DrawingPart(const FloatPlane& part);

 private:
  friend class MovingDrawing;
  Eigen::Index inner_ = 0;  // side without its border of two pixels, which is never used
  std::pair<Eigen::Index, Eigen::Index> cols_;  // first and stop of all rows, read four at a time
  FloatPlane weight_;  // of the inner pixels, with some zeros behind every row
  double count_ = 0;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> spans_;  // first and stop of a row's part
};

class MovingDrawing {
 public:
  // `drawing`: as large as its part, its centre in the middle, without NaN; to be moved it must be
  // smooth enough for an interpolating cubic spline.
  MovingDrawing(const FloatPlane& drawing, std::shared_ptr<const DrawingPart> part);

  // The same seen through a Gaussian blur: much less work than blurring the drawing first.
  MovingDrawing Blurred(double sigma_px) const;

  // Until a step is shorter than `converged_px`. Empty where it does not converge within
  // `max_shift_px` of `start`, leaves the image, or is flat or singular there.
  std::optional<DrawingMatch> Match(const SeenPlane& seen, const Eigen::Vector2d& start,
                                    double max_shift_px, double converged_px = 1e-3) const;

 private:
  MovingDrawing(FloatPlane coefficients, const MovingDrawing& like);

  struct Sums;
  // With the drawing's inner upper-left pixel `fraction` beyond the image's pixel (col, row).
  // `across` is memory to work in.
  struct Across {
    FloatPlane value, slope;
  };
  Sums SumUp(const SeenPlane& seen, Eigen::Index col, Eigen::Index row,
             const Eigen::Vector2d& fraction, Across* across) const;

  FloatPlane coefficients_;  // of the spline, with some zeros behind every row
  std::shared_ptr<const DrawingPart> part_;
};

}  // namespace orient

// A rendered drawing that moves by fractions of a pixel under an image, and the least-squares
// estimate of where it lies.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/matching/float_sums.h"
#include "core/raster/image.h"

namespace orient::interior {

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
  friend class SharpDrawing;
  friend class MovingDrawing;
  Eigen::Index inner_ = 0;  // side without its border of two pixels, which is never used
  std::pair<Eigen::Index, Eigen::Index> cols_;  // first and stop of all rows, read four at a time
  FloatPlane weight_;  // of the inner pixels, with some zeros behind every row
  double count_ = 0;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> spans_;  // first and stop of a row's part
};

class MovingDrawing;

// A drawing without a scanner's blur.
class SharpDrawing {
 public:
  // `drawing`: `finer` (1 or 2) times as large as its part, its centre in the middle, without NaN.
  SharpDrawing(const FloatPlane& drawing, int finer, std::shared_ptr<const DrawingPart> part);

  // As it is seen through a Gaussian blur, of `sigma_px` pixels of the image.
  MovingDrawing Blurred(double sigma_px) const;

 private:
  FloatPlane coefficients_;  // of an interpolating cubic spline
  int finer_;
  std::shared_ptr<const DrawingPart> part_;
};

// Plain Gauss-Newton steps; or, if these still oscillate after their maximum number, further steps
// that are scaled: for sharpened scans, whose halos the drawing does not have.
enum class Steps { kPlain, kScaled };

// A blurred drawing. The image's pixels are means over `finer` of its pixels in each direction: in
// pixels of half the size it is nearly band-limited, and moves without the errors that a spline
// makes of sharp edges.
class MovingDrawing {
 public:
  // Until a step is shorter than `converged_px`. Empty where it does not converge within
  // `max_shift_px` of `start`, leaves the image, or is flat or singular there.
  std::optional<DrawingMatch> Match(const SeenPlane& seen, const Eigen::Vector2d& start,
                                    double max_shift_px, double converged_px = 1e-3,
                                    Steps steps = Steps::kPlain) const;

  // As the image shows it, as large as its part, moved by half a pixel at most in each direction;
  // NaN in the border of two pixels.
  Image Moved(const Eigen::Vector2d& fraction) const;

 private:
  friend class SharpDrawing;
  MovingDrawing(const FloatPlane& coefficients, int finer, std::shared_ptr<const DrawingPart> part);

  struct Taps;
  struct Sums;
  // The drawing moved along its rows: a row for every one of the coefficients and a column for
  // every inner pixel, memory to work in.
  struct Across {
    FloatPlane value, slope;
    Eigen::Index ready = 0;  // rows below it are done
  };
  Taps TapsAt(double fraction) const;
  Across Memory() const;
  // All rows that the inner pixels' row takes from; returns the first of them.
  template <int kTaps>
  Eigen::Index MoveAcross(const Taps& x, const Taps& y, Eigen::Index row,
                          std::pair<Eigen::Index, Eigen::Index> cols, Across* across) const;
  // With the drawing's inner upper-left pixel `fraction` beyond the image's pixel (col, row).
  template <int kTaps>
  Sums SumUp(const SeenPlane& seen, Eigen::Index col, Eigen::Index row,
             const Eigen::Vector2d& fraction, Across* across) const;
  template <int kTaps>
  Image MovedBy(const Eigen::Vector2d& fraction) const;

  int finer_;
  Eigen::Index width_;  // of a plane
  // Of the spline: the planes of every `finer`-th column beside each other, as neighbouring pixels
  // take from neighbours there; with some zeros behind every row of a plane.
  FloatPlane planes_;
  std::shared_ptr<const DrawingPart> part_;
};

}  // namespace orient::interior

// A mark's centre to a small fraction of a pixel: least-squares matching with the drawing.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "core/files/results.h"
#include "core/raster/raster.h"
#include "interior/marks/mark_drawing.h"

namespace orient::interior {

class MatchingDrawing;

struct MarkPosition {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // px^2
  double correlation = 0;  // of the drawing and the scan, positive for either polarity
  double correlation_without_grain = 0, gain_over_sigma = 0;  // MatchPrecision's
  double blur_sigma_px = 0;                                   // of the scan, as it fits best
};

// Matches one mark's drawing at one size and rotation with the scan at full resolution. The drawing
// is rendered once for all places where the mark is measured.
//
// scan(p) = offset + gain * drawing(p - shift) + noise (Gruen 1985, Foerstner 1982). The scan is
// held fast and the drawing moves under it: the other way round the scan would be interpolated,
// which smooths its grain most at half pixels and so pulls the match there. A shift is one and the
// same for all pixels, so that the spline through the drawing is a separable filter of four taps.
class MarkMeasurer {
 public:
  // `pixel_from_mm`: linear part of scan pixel from photo mm, rotation and scale as found. `shape`
  // must outlive the measurer.
  MarkMeasurer(const MarkShape& shape, const Eigen::Matrix2d& pixel_from_mm);
  ~MarkMeasurer();
  MarkMeasurer(MarkMeasurer&&) noexcept;
  MarkMeasurer& operator=(MarkMeasurer&&) noexcept;

  // The scanner's blur is found by trying several. Empty where nothing converges within
  // `max_shift_px` of `start`. May be called from several threads.
  std::optional<MarkPosition> Measure(const Raster& scan, const Eigen::Vector2d& start,
                                      Polarity polarity, double max_shift_px) const;

 private:
  std::unique_ptr<const MatchingDrawing> drawn_;
};

// The same for a single mark.
std::optional<MarkPosition> MeasureMark(const Raster& scan, const MarkShape& shape,
                                        const Eigen::Matrix2d& pixel_from_mm,
                                        const Eigen::Vector2d& start, Polarity polarity,
                                        double max_shift_px);

}  // namespace orient::interior

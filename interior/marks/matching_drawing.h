// A mark's drawing made ready for least-squares matching: which pixels take part, slow brightness
// taken off, at any of the scanner's blurs.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "core/raster/image.h"
#include "interior/marks/mark_drawing.h"
#include "interior/marks/moving_drawing.h"

namespace orient::interior {

class MatchingDrawing {
 public:
  struct Level {
    double blur_px;
    MovingDrawing moving;
  };

  // `pixel_from_mm`: linear part of scan pixel from photo mm.
  MatchingDrawing(const MarkShape& shape, const Eigen::Matrix2d& pixel_from_mm);

  // From the middle of the drawing to its side, pixels.
  double HalfSide() const { return 0.5 * static_cast<double>(part_.rows()); }
  double BackgroundPx() const { return background_px_; }

  // From the widest blur to the sharpest, for a scan with its background removed everywhere: the
  // widest has the largest pull-in range. Rendered in whole pixels: accurate to 0.005 px.
  const std::vector<Level>& Rough() const { return rough_; }

  // For the mark's own pixels alone (CutOut) with their background removed: accurate to a few
  // 0.0001 px. Blurs grow with the step by 2 % each; 0 is the sharpest. Drawn when
  // first asked for, and then kept; several threads may ask.
  const Level& Fine(int step) const;
  static int StepOf(double blur_px);  // the nearest one; negative for a blur sharper than step 0

  // The scan where the drawing's pixels take part, its centre at `centre`; no larger than they
  // need.
  ImageWindow CutOut(const Image& seen, const Eigen::Vector2d& centre) const;

 private:
  FloatPlane PartOf(const MarkShape& shape, const Eigen::Matrix2d& pixel_from_mm, double margin_mm,
                    const FloatPlane& drawn) const;
  void DrawRough(const FloatPlane& drawn, float fill, std::shared_ptr<const DrawingPart> part);
  FloatPlane BackgroundOf(const FloatPlane& drawn) const;

  double background_px_ = 0;
  FloatPlane part_;  // pixels that take part
  int border_ = 0;   // so many outermost rows and columns take no part
  std::vector<Level> rough_;
  std::optional<SharpDrawing> sharp_;
  mutable std::mutex mutex_;
  mutable std::map<int, Level> fine_;
};

// A part in its place, no data elsewhere.
Image PutInPlace(const ImageWindow& part, int width, int height);

}  // namespace orient::interior

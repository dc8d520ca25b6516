// A source shifted by the residual of one point: it shows that point where it was
// measured, and its surroundings shifted by the same amount in the image.
#pragma once

#include "patchdb/harvest/source_view.h"

namespace orient::patchdb {

// Keeps a reference to `view`.
class CorrectedView : public SourceView {
 public:
  // `offset_px`: measured minus computed, pixels of the raster.
  CorrectedView(const SourceView& view, const Eigen::Vector2d& offset_px)
      : view_(view), offset_px_(offset_px) {}
  // Shows ground_m at `pixel`. Empty where the source does not show ground_m at all.
  static std::optional<CorrectedView> ThatShows(const SourceView& view,
                                                const Eigen::Vector3d& ground_m,
                                                const Eigen::Vector2d& pixel);

  std::optional<Eigen::Vector2d> PixelFromGround(const Eigen::Vector3d& ground_m) const override;
  std::optional<Eigen::Vector3d> GroundFromPixel(const Eigen::Vector2d& pixel) const override;
  bool IsOrthophoto() const override;
  Eigen::Vector3d HeightEffect(const Eigen::Vector3d& ground_m) const override;
  Eigen::Matrix2d OrientationCovariance(const Eigen::Vector3d& ground_m) const override;

 private:
  const SourceView& view_;
  Eigen::Vector2d offset_px_;
};

}  // namespace orient::patchdb

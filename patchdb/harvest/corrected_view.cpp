#include "patchdb/harvest/corrected_view.h"

namespace orient::patchdb {

std::optional<CorrectedView> CorrectedView::ThatShows(const SourceView& view,
                                                      const Eigen::Vector3d& ground_m,
                                                      const Eigen::Vector2d& pixel) {
  const auto computed = view.PixelFromGround(ground_m);
  if (!computed) return std::nullopt;
  return CorrectedView(view, pixel - *computed);
}

std::optional<Eigen::Vector2d> CorrectedView::PixelFromGround(
    const Eigen::Vector3d& ground_m) const {
  const auto pixel = view_.PixelFromGround(ground_m);
  if (!pixel) return std::nullopt;
  return Eigen::Vector2d(*pixel + offset_px_);
}

std::optional<Eigen::Vector3d> CorrectedView::GroundFromPixel(const Eigen::Vector2d& pixel) const {
  return view_.GroundFromPixel(pixel - offset_px_);
}

bool CorrectedView::IsOrthophoto() const { return view_.IsOrthophoto(); }

Eigen::Vector3d CorrectedView::HeightEffect(const Eigen::Vector3d& ground_m) const {
  return view_.HeightEffect(ground_m);
}

Eigen::Matrix2d CorrectedView::OrientationCovariance(const Eigen::Vector3d& ground_m) const {
  return view_.OrientationCovariance(ground_m);
}

}  // namespace orient::patchdb

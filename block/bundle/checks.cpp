// Check patches: how the adjusted block fits control patches that were held out of the adjustment.
#include "block/bundle/adjusted_view.h"
#include "block/bundle/outcome.h"
#include "core/geometry/intersection.h"
#include "core/terrain/photo_view.h"

namespace orient::block {
namespace {

void Intersect(const BlockToAdjust& block, const BlockResult& result, CheckPatch* check) {
  std::vector<PhotoObservation> seen;
  for (const std::size_t i : check->observations) {
    const std::size_t photo = block.observations[i].photo;
    const PhotoView view = AdjustedView(block, result, photo);
    seen.push_back({&result.cameras[block.photos[photo].camera], view.pose,
                    view.PhotoFromPixel(block.observations[i].pixel), block.ImageCovariance(i)});
  }
  if (const auto met = IntersectPhotos(seen))
    check->ground_residual_m = block.points[check->point].control->ground_m - met->ground_m;
}

}  // namespace

void FillChecks(const BlockToAdjust& block, BlockResult* result) {
  std::vector<CheckPatch> checks(block.points.size());
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    const ImageObservation& o = block.observations[i];
    const BlockPoint& point = block.points[o.point];
    if (!point.held_out || !point.control) continue;
    if (result->photos[o.photo].state != PhotoState::kAdjusted) continue;
    const PhotoView view = AdjustedView(block, *result, o.photo);
    const auto pixel = view.PixelFromGround(point.control->ground_m);
    if (!pixel) continue;
    checks[o.point].observations.push_back(i);
    checks[o.point].image_residuals_px.emplace_back(o.pixel - *pixel);
    result->observations[i].residual_px = o.pixel - *pixel;
  }
  for (std::size_t i = 0; i < checks.size(); ++i) {
    if (checks[i].observations.empty()) continue;
    checks[i].point = i;
    checks[i].rays = static_cast<int>(checks[i].observations.size());
    if (checks[i].rays > 1) Intersect(block, *result, &checks[i]);
    result->checks.push_back(std::move(checks[i]));
  }
}

}  // namespace orient::block

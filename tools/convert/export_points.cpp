#include "tools/convert/export_points.h"

#include <iterator>

namespace orient {

void ExportPoints::AddPhoto(std::size_t photo, const ExteriorResult& result, FilmImage image) {
  for (const PatchResult& patch : result.patches) {
    if (patch.id < 0 || patch.state != PatchState::kMatched || !patch.pixel || !patch.ground_m)
      continue;
    const auto pixel = image.ImageFromScan(*patch.pixel);
    if (!pixel) continue;
    ExchangePoint& point = patches_[patch.id];
    point.name = std::to_string(patch.id);
    point.control = true;
    point.ground = *patch.ground_m;
    point.observations.push_back({photo, *pixel});
  }
  photos_.insert_or_assign(result.photo, std::pair(photo, std::move(image)));
}

void ExportPoints::AddTies(const AdjustmentResult& adjusted) {
  std::int64_t first = 1000;
  while (!patches_.empty() && first <= patches_.rbegin()->first) first *= 10;
  for (const PointResult& tie : adjusted.ties) {
    if (!tie.ground_m) continue;
    ExchangePoint point;
    point.name = std::to_string(first + tie.id);
    point.ground = *tie.ground_m;
    for (const SightingResult& seen : tie.seen) {
      const auto photo = photos_.find(seen.photo);
      if (seen.state != "used" || photo == photos_.end()) continue;
      const auto& [place, image] = photo->second;
      if (const auto pixel = image.ImageFromScan(seen.pixel))
        point.observations.push_back({place, *pixel});
    }
    if (point.observations.size() > 1) ties_.push_back(std::move(point));
  }
}

std::vector<ExchangePoint> ExportPoints::Take() {
  std::vector<ExchangePoint> points;
  for (auto& [id, point] : patches_) points.push_back(std::move(point));
  points.insert(points.end(), std::make_move_iterator(ties_.begin()),
                std::make_move_iterator(ties_.end()));
  return points;
}

}  // namespace orient

#include "exterior/search/patch_mosaic.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/bounds.h"
#include "core/raster/resample.h"

namespace orient::exterior {
namespace {

Bounds Covered(const std::vector<patchdb::Patch>& patches) {
  Bounds bounds = Bounds::OfNothing();
  for (const patchdb::Patch& patch : patches) {
    const double half = patch.gsd_m * std::max(patch.chip.width, patch.chip.height) / 2;
    bounds.Include(patch.ground_m.x() - half, patch.ground_m.y() - half);
    bounds.Include(patch.ground_m.x() + half, patch.ground_m.y() + half);
  }
  return bounds;
}

}  // namespace

// Each chip pixel goes to the cell in which its centre lies; a coarse one is divided first, so that
// no cell under it stays empty.
void PatchMosaic::Add(const patchdb::Patch& patch, std::vector<float>* weights) {
  const int parts = std::max(1, static_cast<int>(std::ceil(patch.gsd_m / gsd_m_)));
  const double step = patch.gsd_m / parts;
  const Eigen::Vector2d first = CellOf(
      patch.ground_m.head<2>() + 0.5 * Eigen::Vector2d(step - patch.chip.width * patch.gsd_m,
                                                       patch.chip.height * patch.gsd_m - step));
  for (int row = 0; row < patch.chip.height * parts; ++row)
    for (int col = 0; col < patch.chip.width * parts; ++col) {
      const float value = patch.chip.At(col / parts, row / parts);
      const int x = static_cast<int>(first.x() + col * step / gsd_m_);
      const int y = static_cast<int>(first.y() + row * step / gsd_m_);
      if (!std::isfinite(value) || x < 0 || y < 0 || x >= grey_.width || y >= grey_.height)
        continue;
      grey_.At(x, y) += value;
      ++(*weights)[static_cast<std::size_t>(y) * static_cast<std::size_t>(grey_.width) +
                   static_cast<std::size_t>(x)];
    }
}

std::optional<PatchMosaic> PatchMosaic::Of(const std::vector<patchdb::Patch>& patches, double gsd_m,
                                           double max_cells) {
  const Bounds bounds = Covered(patches);
  if (bounds.Empty() || !(gsd_m > 0)) return std::nullopt;
  const double width = std::ceil((bounds.max_x - bounds.min_x) / gsd_m) + 1;
  const double height = std::ceil((bounds.max_y - bounds.min_y) / gsd_m) + 1;
  if (!(width * height <= max_cells)) return std::nullopt;
  PatchMosaic mosaic;
  mosaic.gsd_m_ = gsd_m;
  mosaic.west_m_ = bounds.min_x;
  mosaic.north_m_ = bounds.max_y;
  mosaic.grey_ = Image(static_cast<int>(width), static_cast<int>(height));
  std::vector<float> weights(mosaic.grey_.values.size(), 0);
  for (const patchdb::Patch& patch : patches) {
    mosaic.Add(patch, &weights);
    mosaic.points_m_.push_back(patch.ground_m);
  }
  for (std::size_t i = 0; i < weights.size(); ++i)
    mosaic.grey_.values[i] = weights[i] > 0 ? mosaic.grey_.values[i] / weights[i] : kNoData;
  std::sort(mosaic.points_m_.begin(), mosaic.points_m_.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x(); });
  return mosaic;
}

Image PatchMosaic::Draw(const Eigen::Vector2d& centre_m, const Eigen::Matrix2d& ground_from_image,
                        int side) const {
  Image image(side, side);
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col) {
      const Eigen::Vector2d off(col + 0.5 - side / 2.0, row + 0.5 - side / 2.0);
      image.At(col, row) = SampleBilinear(grey_, CellOf(centre_m + ground_from_image * off));
    }
  return image;
}

double PatchMosaic::HeightAround(const Eigen::Vector2d& centre_m, double half_m) const {
  const auto first =
      std::lower_bound(points_m_.begin(), points_m_.end(), centre_m.x() - half_m,
                       [](const Eigen::Vector3d& point, double x) { return point.x() < x; });
  double sum = 0;
  int count = 0;
  for (auto point = first; point != points_m_.end() && point->x() <= centre_m.x() + half_m;
       ++point) {
    if (std::abs(point->y() - centre_m.y()) > half_m) continue;
    sum += point->z();
    ++count;
  }
  return count > 0 ? sum / count : std::nan("");
}

}  // namespace orient::exterior

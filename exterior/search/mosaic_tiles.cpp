#include "exterior/search/mosaic_tiles.h"

#include <algorithm>
#include <cmath>

#include "core/base/side_by_side.h"
#include "core/matching/correlation.h"

namespace orient::exterior {
namespace {

constexpr int kSide = 25;             // of a tile, pixels of the level
constexpr double kShortSide = 160;    // of the photo at the coarsest level, pixels
constexpr double kMaxPixels = 1.5e6;  // of a level that is searched whole
constexpr double kCovered = 0.6;      // of a tile, by patches
constexpr std::size_t kMaxTiles = 250;
constexpr std::size_t kMinTiles = 8;

constexpr int kMaxCandidates = 4;    // of a tile
constexpr double kMinScore = 0.45;   // of a candidate
constexpr double kPeakDistance = 3;  // pixels of the level

bool IsCovered(const Image& tile) {
  const auto valid = std::count_if(tile.values.begin(), tile.values.end(),
                                   [](float value) { return std::isfinite(value); });
  return static_cast<double>(valid) >= kCovered * static_cast<double>(tile.values.size());
}

// Middles of tiles side by side on the ground, those nearest to a point first.
std::vector<Eigen::Vector3d> Middles(const std::vector<patchdb::Patch>& patches,
                                     const PatchMosaic& mosaic, double cell_m,
                                     const Eigen::Vector2d& nearest_to_m) {
  const double side_m = cell_m * kSide;
  std::vector<Eigen::Vector2d> points;
  for (const patchdb::Patch& patch : patches) points.emplace_back(patch.ground_m.head<2>());
  std::stable_sort(points.begin(), points.end(), [&](const auto& a, const auto& b) {
    return (a - nearest_to_m).squaredNorm() < (b - nearest_to_m).squaredNorm();
  });
  std::vector<Eigen::Vector3d> middles;
  for (const Eigen::Vector2d& point : points) {
    if (middles.size() >= kMaxTiles) break;
    const bool taken = std::any_of(
        middles.begin(), middles.end(),
        [&](const Eigen::Vector3d& middle) { return (middle.head<2>() - point).norm() < side_m; });
    if (taken || !IsCovered(mosaic.Draw(point, cell_m * Eigen::Matrix2d::Identity(), kSide)))
      continue;
    middles.emplace_back(point.x(), point.y(), mosaic.HeightAround(point, side_m / 2));
  }
  return middles;
}

}  // namespace

std::optional<MosaicTiles> MosaicTiles::Of(const std::vector<patchdb::Patch>& patches,
                                           const PhotoImage& photo, double gsd_m,
                                           const Eigen::Vector2d& middle_m) {
  const double width = photo.Width(), height = photo.Height();
  const double shorter = std::min(width, height);
  int reduction = std::max(1, static_cast<int>(std::lround(shorter / kShortSide)));
  for (; reduction >= 1 && width * height <= kMaxPixels * reduction * reduction; reduction /= 2) {
    if (shorter < 2.0 * kSide * reduction) continue;
    auto mosaic = PatchMosaic::Of(patches, gsd_m * reduction);
    if (!mosaic) return std::nullopt;
    auto middles = Middles(patches, *mosaic, gsd_m * reduction, middle_m);
    if (middles.size() < kMinTiles) continue;
    const Eigen::Vector2d half(width / 2, height / 2);
    MosaicTiles tiles(std::move(*mosaic), reduction, photo.Around(half, half, reduction), kSide);
    tiles.middles_m_ = std::move(middles);
    return tiles;
  }
  return std::nullopt;
}

std::vector<VotingPatch> MosaicTiles::Seek(const Shape& ground_from_scan) const {
  std::vector<VotingPatch> voting(middles_m_.size());
  SideBySide(voting.size(), [&](std::size_t i) {
    const Eigen::Vector3d& middle_m = middles_m_[i];
    voting[i].ground_m = middle_m;
    const Image tile =
        mosaic_.Draw(middle_m.head<2>(), reduction_ * ground_from_scan(middle_m), kSide);
    if (!IsCovered(tile)) return;
    const Image scores = search_.Scores(tile);
    voting[i].window_px2 = static_cast<double>(scores.values.size()) * reduction_ * reduction_;
    for (const Peak& peak : FindPeaks(scores, kMaxCandidates, kPeakDistance, kMinScore)) {
      const Eigen::Vector2d middle = peak.position + Eigen::Vector2d::Constant(kSide / 2.0);
      voting[i].candidates.push_back({photo_.RasterFromImage(middle), peak.score});
    }
  });
  return voting;
}

}  // namespace orient::exterior

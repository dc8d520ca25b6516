#include "block/ties/tie_places.h"

#include <algorithm>
#include <cmath>

#include "core/base/side_by_side.h"
#include "core/matching/interest_points.h"

namespace orient::block {
namespace {

constexpr int kTriesPerCell = 3;  // interest points per cell, until one is found in another photo

// Probes per cell and axis at which its overlaps are looked for.
constexpr int kProbes = 4;
// Added around a window, so that there are interest points up to its border.
constexpr double kInterestBorderPx = 14;
// A point this much nearer to another photo's middle (share of the frame) is that photo's; among
// nearly equals the first photo owns it.
constexpr double kOwnerTolerance = 1e-9;

double Margin(const TieOptions& options) { return options.template_px / 2.0 + 2; }

// Distance from the frame's middle, 0 there and 1 at the nearest border.
double FromMiddle(const TiePhoto& photo, const Eigen::Vector2d& pixel) {
  const Camera& camera = photo.view.camera;
  return (photo.view.PhotoFromPixel(pixel) - camera.frame_centre_mm)
      .cwiseQuotient(camera.frame_mm / 2)
      .norm();
}

// The place at a pixel of the owner; empty where no other photo shows it, or another one owns it.
std::optional<TiePlace> PlaceAt(const std::vector<TiePhoto>& photos, std::size_t owner,
                                const GroundSurface& surface, const Eigen::Vector2d& pixel,
                                const TieOptions& options) {
  const auto ground = photos[owner].view.GroundFromPixel(pixel, surface);
  if (!ground || !SeenAt(photos[owner], *ground, Margin(options))) return std::nullopt;
  const double own = FromMiddle(photos[owner], pixel);
  TiePlace place{pixel, *ground, {}};
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (i == owner) continue;
    const auto seen = SeenAt(photos[i], *ground, Margin(options));
    if (!seen) continue;
    const double other = FromMiddle(photos[i], *seen);
    const bool nearer = i < owner ? other <= own + kOwnerTolerance : other < own - kOwnerTolerance;
    if (nearer) return std::nullopt;
    place.further.push_back(i);
  }
  if (place.further.empty()) return std::nullopt;
  return place;
}

struct Cell {
  Eigen::Vector2d first_mm, size_mm;  // in the photo system
};

// The probe of the cell that most photos show, nearest to the cell's middle among equals.
std::optional<Eigen::Vector2d> BestProbe(const std::vector<TiePhoto>& photos, std::size_t owner,
                                         const GroundSurface& surface, const Cell& cell,
                                         const TieOptions& options) {
  std::optional<Eigen::Vector2d> best;
  std::pair<double, double> best_rank;
  for (int i = 0; i < kProbes * kProbes; ++i) {
    const Eigen::Vector2d unit((i % kProbes + 0.5) / kProbes, (i / kProbes + 0.5) / kProbes);
    const Eigen::Vector2d pixel =
        photos[owner].view.PixelFromPhoto(cell.first_mm + unit.cwiseProduct(cell.size_mm));
    const auto place = PlaceAt(photos, owner, surface, pixel, options);
    if (!place) continue;
    const std::pair<double, double> rank{static_cast<double>(place->further.size()),
                                         -(unit - Eigen::Vector2d(0.5, 0.5)).norm()};
    if (!best || rank > best_rank) {
      best = pixel;
      best_rank = rank;
    }
  }
  return best;
}

std::vector<TiePlace> PlacesIn(const std::vector<TiePhoto>& photos, std::size_t owner,
                               const GroundSurface& surface, const Cell& cell,
                               const TieOptions& options) {
  const auto middle = BestProbe(photos, owner, surface, cell, options);
  if (!middle) return {};
  const double cell_px = cell.size_mm.minCoeff() / photos[owner].view.PixelSize();
  const double half = std::min<double>(options.window_px, cell_px) / 2;
  const ImageWindow window =
      photos[owner].image->Around(*middle, Eigen::Vector2d::Constant(half + kInterestBorderPx), 1);
  InterestOptions interest;
  interest.min_weight_ratio = 0.1;  // a weak point may be the best of a weak cell
  std::vector<TiePlace> places;
  for (const InterestPoint& point : FindInterestPoints(window.image, interest)) {
    const Eigen::Vector2d pixel = window.RasterFromImage(point.pixel);
    if ((pixel - *middle).cwiseAbs().maxCoeff() > half) continue;
    auto place = PlaceAt(photos, owner, surface, pixel, options);
    if (place) places.push_back(std::move(*place));
  }
  std::stable_sort(places.begin(), places.end(), [](const TiePlace& a, const TiePlace& b) {
    return a.further.size() > b.further.size();
  });
  if (std::ssize(places) > kTriesPerCell) places.resize(static_cast<std::size_t>(kTriesPerCell));
  return places;
}

}  // namespace

std::optional<Eigen::Vector2d> SeenAt(const TiePhoto& photo, const Eigen::Vector3d& ground_m,
                                      double margin_px) {
  const auto photo_mm = PhotoFromGround(photo.view.camera, photo.view.pose, ground_m);
  const double margin_mm = margin_px * photo.view.PixelSize();
  if (!photo_mm || !photo.view.camera.InFrame(*photo_mm, -margin_mm)) return std::nullopt;
  const Eigen::Vector2d pixel = photo.view.PixelFromPhoto(*photo_mm);
  const bool inside = pixel.minCoeff() >= margin_px &&
                      pixel.x() <= photo.image->Width() - margin_px &&
                      pixel.y() <= photo.image->Height() - margin_px;
  if (!inside) return std::nullopt;
  return pixel;
}

std::vector<std::vector<TiePlace>> FindTiePlaces(const std::vector<TiePhoto>& photos,
                                                 std::size_t owner, const GroundSurface& surface,
                                                 const TieOptions& options) {
  const Camera& camera = photos[owner].view.camera;
  const Eigen::Vector2d size = camera.frame_mm / options.cells;
  const Eigen::Vector2d corner = camera.frame_centre_mm - camera.frame_mm / 2;
  const auto count = static_cast<std::size_t>(options.cells * options.cells);
  std::vector<std::vector<TiePlace>> places(count);
  SideBySide(count, [&](std::size_t i) {
    const int index = static_cast<int>(i);
    const int col = index % options.cells, row = index / options.cells;
    const Cell cell{corner + size.cwiseProduct(Eigen::Vector2d(col, row)), size};
    places[i] = PlacesIn(photos, owner, surface, cell, options);
  });
  std::erase_if(places, [](const auto& of_cell) { return of_cell.empty(); });
  return places;
}

}  // namespace orient::block

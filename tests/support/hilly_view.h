// A film photo over hills with all geometric effects, for tests of orthophotos.
#pragma once

#include <cmath>
#include <memory>

#include "core/raster/band_raster.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "tools/simulate/geotiff.h"

namespace orient::ortho {

inline constexpr int kScan_px = 420;

// Wide angle, lens distortion, rotated scan, deformed film; the GSD is about 4 m.
inline PhotoView HillyView() {
  PhotoView view;
  view.camera.kind = CameraKind::kFilm;
  view.camera.principal_distance_mm = 150;
  view.camera.principal_point_mm = {0.3, -0.2};
  view.camera.frame_mm = {200, 200};
  view.camera.lens = BrownDistortion{{-2e-7, 3e-12, 0}, {1e-7, -1e-7}};
  view.photo_from_pixel.A << 0.002, -0.5, -0.5, -0.002;
  view.photo_from_pixel.t = {105, 105};
  view.pose = {{5000, 3000, 1300}, {0.03, -0.02, 0.4}};
  FilmCorrection film;
  film.origin_px = {0, 0};
  film.step_px = {210, 210};
  film.columns = film.rows = 3;
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 3; ++col) film.correction_mm.emplace_back(0.1 * col, 0.05 * (row - 1));
  view.film_correction = std::make_shared<const FilmCorrection>(film);
  return view;
}

// Gentle hills of 60 m; with `wall`, the terrain west of x = 5200 is 150 m higher.
inline GroundSurface Hills(bool wall = false) {
  constexpr int kNodes = 301;
  constexpr double kWest = 3500, kNorth = 4500, kCell = 10;
  Eigen::MatrixXf heights(kNodes, kNodes);
  for (int r = 0; r < kNodes; ++r)
    for (int c = 0; c < kNodes; ++c) {
      const double x = kWest + kCell * (c + 0.5), y = kNorth - kCell * (r + 0.5);
      const double step = wall && x < 5200 ? 150 : 0;
      heights(r, c) = static_cast<float>(100 + 30 * std::sin(x / 150) * std::cos(y / 180) + step);
    }
  return GroundSurface::FromGrid(heights, kWest, kNorth, kCell);
}

// Writes the same heights to a file.
inline void WriteHills(const std::string& path, const Crs& crs, bool wall = false) {
  const GroundSurface hills = Hills(wall);
  std::vector<float> heights;
  for (int r = 0; r < 300; ++r)
    for (int c = 0; c < 300; ++c)
      heights.push_back(
          static_cast<float>(hills.HeightAt(3500 + 10 * (c + 0.5), 4500 - 10 * (r + 0.5)).value()));
  simulation::WriteFloatTiff(path, 300, 300, heights, {3500, 4500, 10, crs});
}

// Writes the scan of the photo for ground with grey value value(x, y) at (x, y); 16 bit, 0 where it
// shows no ground.
template <typename Value>
void WriteScan(const std::string& path, const PhotoView& view, const GroundSurface& surface,
               const Value& value, int side = kScan_px) {
  std::vector<std::uint16_t> values;
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col) {
      const auto ground = view.GroundFromPixel({col + 0.5, row + 0.5}, surface);
      values.push_back(
          ground ? static_cast<std::uint16_t>(std::lround(value(ground->x(), ground->y()))) : 0);
    }
  simulation::WriteGreyTiff(path, side, side, values, 16, std::nullopt, std::nullopt);
}

}  // namespace orient::ortho

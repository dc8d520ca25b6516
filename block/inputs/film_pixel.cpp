#include "block/inputs/film_pixel.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/raster/raster.h"

namespace orient::block {

std::optional<double> FilmPixel_mm(const Camera& camera, const std::vector<std::string>& scans) {
  constexpr std::size_t kEnough = 9;  // of one block, scanned by one scanner
  if (camera.kind != CameraKind::kFilm) return std::nullopt;
  std::vector<double> pixels_mm;
  for (std::size_t i = 0; i < scans.size() && pixels_mm.size() < kEnough; ++i) {
    try {
      const Raster scan = Raster::OpenScan(scans[i]);
      const int shorter = std::min(scan.Width(), scan.Height());
      const int longer = std::max(scan.Width(), scan.Height());
      pixels_mm.push_back(
          std::max(camera.frame_mm.minCoeff() / shorter, camera.frame_mm.maxCoeff() / longer));
    } catch (const InputError&) {
      continue;  // that photo fails by itself
    }
  }
  if (pixels_mm.empty()) return std::nullopt;
  return UpperMedian(std::move(pixels_mm));
}

}  // namespace orient::block

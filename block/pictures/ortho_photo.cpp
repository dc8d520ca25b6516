#include "block/pictures/ortho_photo.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/raster/resample.h"

namespace orient::block {

using Eigen::Vector2d;
using Eigen::Vector3d;

void Standardise(Image* image) {
  double sum = 0, squares = 0;
  int n = 0;
  for (const float v : image->values)
    if (!std::isnan(v)) sum += v, squares += static_cast<double>(v) * v, ++n;
  if (n == 0) return;
  constexpr double kMean = 128, kContrast = 45;
  const double mean = sum / n, sigma = std::sqrt(std::max(squares / n - mean * mean, 1e-9));
  for (float& v : image->values) v = static_cast<float>(kMean + kContrast * (v - mean) / sigma);
}

OrthoPhoto::OrthoPhoto(const QuicklookPhoto& photo)
    : photo_(photo), raster_(Raster::Open(photo.path)), image_(raster_, photo.negative) {}

double OrthoPhoto::Gsd(double height_m) const {
  const Vector3d& centre = photo_.view.pose.position_m;
  return (centre.z() - height_m) * photo_.view.PixelSize() /
         photo_.view.camera.principal_distance_mm;
}

std::optional<OrthoPhoto::Seen> OrthoPhoto::See(const Vector3d& ground_m) const {
  const auto pixel = photo_.view.PixelFromGround(ground_m);
  if (!pixel) return std::nullopt;
  const Camera& camera = photo_.view.camera;
  const Vector2d mm = photo_.view.PhotoFromPixel(*pixel) - camera.frame_centre_mm;
  const Vector2d off = 2 * mm.cwiseQuotient(camera.frame_mm);
  const double to_border = off.cwiseAbs().maxCoeff();
  constexpr double kUsed = 0.98;  // of the frame: its border is not the ground
  if (!(to_border < kUsed)) return std::nullopt;
  return Seen{*pixel, off.norm(), to_border};
}

ImageWindow OrthoPhoto::Whole(int reduction) const {
  const Vector2d half(0.5 * image_.Width(), 0.5 * image_.Height());
  return image_.Around(half, half, reduction);
}

Image OrthoPhoto::Draw(const GroundGrid& grid, const GroundSurface& surface) const {
  Image ortho(grid.width, grid.height, kNoData);
  const Vector2d middle = grid.At(0.5 * grid.width, 0.5 * grid.height);
  const auto height = surface.HeightAt(middle.x(), middle.y());
  const auto centre = height ? See({middle.x(), middle.y(), *height}) : std::nullopt;
  if (!centre) return ortho;
  const double ratio = std::max(1.0, grid.gsd_m / Gsd(*height));  // finer photos show more pixels
  constexpr double kTilted = 1.5;                                 // turned squares, relief
  const double half = kTilted * std::max(grid.width, grid.height) * ratio;
  ImageWindow window;
  try {
    window = image_.Around(centre->pixel, Vector2d(half, half), static_cast<int>(ratio));
  } catch (const InputError&) {
    return ortho;
  }
  for (int row = 0; row < grid.height; ++row)
    for (int col = 0; col < grid.width; ++col) {
      const Vector2d xy = grid.At(col + 0.5, row + 0.5);
      const auto z = surface.HeightAt(xy.x(), xy.y());
      const auto seen = z ? See({xy.x(), xy.y(), *z}) : std::nullopt;
      if (seen)
        ortho.At(col, row) = SampleBicubic(window.image, window.ImageFromRaster(seen->pixel));
    }
  Standardise(&ortho);
  return ortho;
}

}  // namespace orient::block

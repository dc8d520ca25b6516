// A made-up piece of ground with known heights and grey values, for tests of the harvest.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <random>
#include <string>
#include <vector>

#include "core/raster/image.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient::patchdb {

// Grey values 0..255: many waves of random direction and a wavelength of 8 m and more, so that
// bicubic interpolation at 1 m reproduces them.
class SyntheticTexture {
 public:
  explicit SyntheticTexture(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 30; ++i) {
      const double wavelength = 8 * std::pow(10, unit(random));
      const double angle = 2 * M_PI * unit(random);
      waves_.push_back({2 * M_PI / wavelength * std::cos(angle),
                        2 * M_PI / wavelength * std::sin(angle), 2 * M_PI * unit(random)});
    }
  }
  float At(double x, double y) const {
    double sum = 0;
    for (const Eigen::Vector3d& wave : waves_)
      sum += std::sin(wave.x() * x + wave.y() * y + wave.z());
    return static_cast<float>(127.5 + 100 * std::tanh(sum / 5.6));
  }

 private:
  std::vector<Eigen::Vector3d> waves_;
};

inline constexpr double kWest = 500000, kNorth = 5001000;  // of the synthetic ground's 1 x 1 km

// Hills of 60 m with slopes up to 40 %.
inline GroundSurface SyntheticSurface(double cell_m = 10) {
  const int size = static_cast<int>(1000 / cell_m);
  Eigen::MatrixXf heights(size, size);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col)
      heights(row, col) = static_cast<float>(300 + 30 * std::sin((col + 0.5) * cell_m / 80) *
                                                       std::cos((row + 0.5) * cell_m / 100));
  return GroundSurface::FromGrid(heights, kWest, kNorth, cell_m);
}

// A digital camera 900 m above the middle of the ground, tilted and turned: about 1 m a pixel.
inline PhotoView SyntheticView(double kappa_rad) {
  PhotoView view;
  view.camera.name = "synthetic";
  view.camera.kind = CameraKind::kDigital;
  view.camera.principal_distance_mm = 100;
  view.camera.image_px = Eigen::Vector2i(600, 500);
  view.camera.frame_mm = Eigen::Vector2d(66, 55);
  view.photo_from_pixel = DigitalPhotoFromPixel(view.camera);
  view.pose = {{500500, 5000500, 1200}, {0.05, -0.08, kappa_rad}};
  return view;
}

inline void WriteGreyPng(const std::string& path, const Image& image) {
  std::vector<unsigned char> grey(image.values.size());
  for (std::size_t i = 0; i < grey.size(); ++i)
    grey[i] = static_cast<unsigned char>(std::lround(image.values[i]));
  WritePng(path, image.width, image.height, 1, grey);
}

// What the view sees: every pixel's ray meets the surface, the texture is taken there.
inline Image RenderPhoto(const PhotoView& view, const GroundSurface& surface,
                         const SyntheticTexture& texture) {
  Image image(view.camera.image_px->x(), view.camera.image_px->y());
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const auto ground = view.GroundFromPixel({col + 0.5, row + 0.5}, surface);
      image.At(col, row) = ground ? texture.At(ground->x(), ground->y()) : 0;
    }
  return image;
}

// An orthophoto as PNG with GDAL's .aux.xml beside it; map = A * pixel + t.
inline void WriteOrtho(const std::string& path, const Image& image, const Affine2d& map_from_pixel,
                       const std::string& crs) {
  WriteGreyPng(path, image);
  std::ofstream aux(path + ".aux.xml");
  aux << std::setprecision(17) << "<PAMDataset><SRS>" << crs << "</SRS><GeoTransform>"
      << map_from_pixel.t.x() << "," << map_from_pixel.A(0, 0) << "," << map_from_pixel.A(0, 1)
      << "," << map_from_pixel.t.y() << "," << map_from_pixel.A(1, 0) << ","
      << map_from_pixel.A(1, 1)
      << "</GeoTransform><PAMRasterBand band=\"1\"><NoDataValue>0</NoDataValue></PAMRasterBand>"
      << "</PAMDataset>";
}

}  // namespace orient::patchdb

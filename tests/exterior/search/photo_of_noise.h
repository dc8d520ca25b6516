// A blank photo with places of noise, as large as a test needs.
#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/raster/raster.h"
#include "exterior/steps/photo_task.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {

// Of a photo by itself, seen from straight above: a pixel shows a metre of level ground.
class PhotoOfNoise {
 public:
  // Grey but for 7 x 7 places of noise, of which there are patches.
  explicit PhotoOfNoise(int side_px, bool blank = false) {
    std::vector<unsigned char> grey(static_cast<std::size_t>(side_px) * side_px, 128);
    camera_.kind = CameraKind::kDigital;
    camera_.principal_distance_mm = 60;
    camera_.frame_mm = {60, 60};
    camera_.image_px = Eigen::Vector2i(side_px, side_px);
    std::mt19937 random(1);
    const double middle = side_px / 2.0;
    for (int i = -3; i <= 3; ++i)
      for (int j = -3; j <= 3; ++j) {
        patchdb::Patch patch;
        patch.id = std::ssize(patches_) + 1;
        patch.gsd_m = 1;
        patch.chip = Image(kChip, kChip);
        const int first_col = side_px / 2 + i * side_px / 8,
                  first_row = side_px / 2 + j * side_px / 8;
        patch.ground_m = {first_col + kChip / 2.0 - middle, middle - first_row - kChip / 2.0, 0};
        for (int row = 0; row < kChip; ++row)
          for (int col = 0; col < kChip; ++col) {
            const auto value = static_cast<unsigned char>(random() % 256);
            patch.chip.At(col, row) = value;
            if (!blank)
              grey[static_cast<std::size_t>(first_row + row) * side_px + first_col + col] = value;
          }
        patch.heights = {3, 50, std::vector<float>(9, 0)};
        patches_.push_back(std::move(patch));
      }
    const std::string path = folder_ / "photo.png";
    WritePng(path, side_px, side_px, 1, grey);
    raster_.emplace(Raster::Open(path));
    image_.emplace(*raster_, false);
    photo_.camera = camera_;
    photo_.positions.push_back({DigitalPhotoFromPixel(camera_), std::nullopt});
    photo_.prior.pose = {{0, 0, static_cast<double>(side_px)}, {0, 0, 0}};
  }

  // One sigma: as a shift of all patches.
  void SetSigma(double sigma_px) {
    Vector6d sigma;
    sigma << sigma_px, sigma_px, 1, 1e-4, 1e-4, 1e-4;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
  }
  PhotoTask Task() const { return {photo_, *image_, patches_, options_}; }

 private:
  static constexpr int kChip = 29;  // too small for another level than full resolution
  Camera camera_;
  std::vector<patchdb::Patch> patches_;
  TemporaryFolder folder_;
  std::optional<Raster> raster_;
  std::optional<PhotoImage> image_;
  PhotoToOrient photo_;
  OrientPhotoOptions options_;
};

}  // namespace orient::exterior

// A small photo of textured ground, and patches of it, shared by tests of complete searches.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/raster/raster.h"
#include "exterior/orient_photo.h"
#include "tests/support/shared_data.h"
#include "tests/support/texture.h"

namespace orient::exterior {

// Hills of 30 m, for photos from some hundred metres.
inline double HillsAt(double x, double y) { return 30 * std::sin(x / 130) * std::cos(y / 170); }

class TexturedPhoto {
 public:
  static constexpr double kGsd_m = 2;

  // `height`: of the ground at x, y. `changed`: every second parcel is inverted in the photo.
  TexturedPhoto(int side_px, std::function<double(double, double)> height, bool changed)
      : height_(std::move(height)), changed_(changed) {
    Camera& camera = view_.camera;
    camera.kind = CameraKind::kDigital;
    camera.principal_distance_mm = 60;
    camera.frame_mm = {60, 60};
    camera.image_px = Eigen::Vector2i(side_px, side_px);
    view_.photo_from_pixel = DigitalPhotoFromPixel(camera);
    view_.pose = {{10, -20, kGsd_m * side_px}, {0.12, -0.15, 2.3}};
    std::vector<unsigned char> grey;
    for (int row = 0; row < side_px; ++row)
      for (int col = 0; col < side_px; ++col) grey.push_back(GreyAt({col + 0.5, row + 0.5}));
    const std::string path = folder_ / "photo.png";
    WritePng(path, side_px, side_px, 1, grey);
    raster_.emplace(Raster::Open(path));
    image_.emplace(*raster_, false);
  }

  const PhotoView& View() const { return view_; }
  const PhotoImage& File() const { return *image_; }
  const Texture& Ground() const { return texture_; }

  // Largest reprojection error, px, of a pose at the patches that the photo shows.
  double WorstError(const Pose& pose, const std::vector<patchdb::Patch>& patches) const {
    PhotoView found = view_;
    found.pose = pose;
    double worst = 0;
    for (const patchdb::Patch& patch : patches) {
      const auto truth = view_.PixelFromGround(patch.ground_m);
      if (!truth || !view_.camera.InFrame(view_.PhotoFromPixel(*truth))) continue;
      worst = std::max(worst, (*found.PixelFromGround(patch.ground_m) - *truth).norm());
    }
    return worst;
  }

  // The caller sets the prior.
  PhotoToOrient ToOrient() const {
    PhotoToOrient photo;
    photo.camera = view_.camera;
    photo.positions.push_back({view_.photo_from_pixel, std::nullopt});
    return photo;
  }

  // A patch of this photo's own ground, without an id.
  patchdb::Patch Patch(double x, double y) const { return PatchAt(texture_, x, y); }

  // (2 n + 1)^2 patches about the origin, with chips of the given texture.
  std::vector<patchdb::Patch> Patches(const Texture& texture, int n, double step_m) const {
    std::vector<patchdb::Patch> patches;
    for (int i = -n; i <= n; ++i)
      for (int j = -n; j <= n; ++j) {
        patches.push_back(PatchAt(texture, step_m * i, step_m * j));
        patches.back().id = static_cast<std::int64_t>(patches.size());
      }
    return patches;
  }

 private:
  static constexpr double kParcel_m = 60;
  static constexpr int kChip = 51;

  patchdb::Patch PatchAt(const Texture& texture, double x, double y) const {
    constexpr int kNodes = 15, kMiddle = kNodes / 2;
    constexpr double kStep_m = 10;
    patchdb::Patch patch;
    patch.ground_m = {x, y, height_(x, y)};
    patch.gsd_m = kGsd_m;
    patch.chip = Image(kChip, kChip);
    for (int row = 0; row < kChip; ++row)
      for (int col = 0; col < kChip; ++col)
        patch.chip.At(col, row) = static_cast<float>(
            texture.At(patch.ground_m.head<2>() / kGsd_m +
                       Eigen::Vector2d(col + 0.5 - kChip / 2.0, kChip / 2.0 - row - 0.5)));
    patch.heights = {kNodes, kStep_m, {}};
    for (int row = 0; row < kNodes; ++row)
      for (int col = 0; col < kNodes; ++col)
        patch.heights.heights_m.push_back(static_cast<float>(
            height_(x + kStep_m * (col - kMiddle), y - kStep_m * (row - kMiddle))));
    return patch;
  }

  unsigned char GreyAt(const Eigen::Vector2d& pixel) const {
    const Ray ray = *GroundRayFromPhoto(view_.camera, view_.pose, view_.PhotoFromPixel(pixel));
    Eigen::Vector3d ground = ray.origin_m;
    for (int i = 0; i < 30; ++i)
      ground = ray.origin_m +
               ray.direction *
                   ((height_(ground.x(), ground.y()) - ray.origin_m.z()) / ray.direction.z());
    const double then = texture_.At(ground.head<2>() / kGsd_m);
    const auto parcel =
        static_cast<int>(std::floor(ground.x() / kParcel_m) + std::floor(ground.y() / kParcel_m));
    const bool same = !changed_ || parcel % 2 == 0;
    return static_cast<unsigned char>(std::clamp(same ? then : 256 - then, 0.0, 255.0));
  }

  std::function<double(double, double)> height_;
  bool changed_;
  const Texture texture_{5, 6};
  PhotoView view_;
  TemporaryFolder folder_;
  std::optional<Raster> raster_;
  std::optional<PhotoImage> image_;
};

// A photo of hills, 400 x 400 pixels; rendered once for all tests.
inline const TexturedPhoto& PhotoOfHills() {
  static const TexturedPhoto photo(400, HillsAt, false);
  return photo;
}

}  // namespace orient::exterior

#include "exterior/steps/photo_image.h"

#include <algorithm>

namespace orient::exterior {
namespace {

// A level of up to this many pixels is read whole: cheaper than many overlapping windows of it.
constexpr double kWholeLevelPixels = 6e6;

void Negate(Image& image) {
  for (float& value : image.values) value = -value;
}

Image Crop(const Image& level, int col0, int row0, int width, int height) {
  Image crop(width, height, kNoData);
  const int first = std::max(col0, 0);
  const int last = std::min(col0 + width, level.width);
  for (int row = std::max(row0, 0); row < std::min(row0 + height, level.height); ++row)
    if (first < last)
      std::copy(level.Row(row) + first, level.Row(row) + last,
                crop.Row(row - row0) + (first - col0));
  return crop;
}

}  // namespace

const Image& PhotoImage::Level(int reduction) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = levels_.find(reduction);
  if (known != levels_.end()) return known->second;
  Image image = raster_.ReadGrey({0, 0, Width(), Height()}, reduction).image;
  if (negative_) Negate(image);
  return levels_.emplace(reduction, std::move(image)).first->second;
}

ImageWindow PhotoImage::Around(const Eigen::Vector2d& centre_px, const Eigen::Vector2d& half_px,
                               int reduction) const {
  const Eigen::Vector2d first = ((centre_px - half_px) / reduction).array().floor();
  const Eigen::Vector2d last = ((centre_px + half_px) / reduction).array().ceil();
  const int col0 = static_cast<int>(first.x());
  const int row0 = static_cast<int>(first.y());
  const int width = static_cast<int>(last.x() - first.x());
  const int height = static_cast<int>(last.y() - first.y());

  const double level_pixels = static_cast<double>(Width()) * Height() / (reduction * reduction);
  if (level_pixels <= kWholeLevelPixels)
    return {Crop(Level(reduction), col0, row0, width, height), first * reduction,
            static_cast<double>(reduction)};
  ImageWindow window = raster_.ReadGrey(
      {col0 * reduction, row0 * reduction, width * reduction, height * reduction}, reduction);
  if (negative_) Negate(window.image);
  return window;
}

int FinestReduction(const PhotoImage& photo, double most_pixels) {
  int reduction = 1;
  const double pixels = static_cast<double>(photo.Width()) * photo.Height();
  while (pixels > most_pixels * reduction * reduction) ++reduction;
  return reduction;
}

}  // namespace orient::exterior

#include "interior/constellation/film_frame.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kOverviewPx = 500;
constexpr double kMinBedShare = 0.5;    // of the outermost pixels that must have the bed's tone
constexpr double kLargestShare = 0.97;  // of the scan, in both directions: no bed around it
constexpr double kSmallestShare = 0.02;
constexpr double kFilled = 0.25;  // share of a line within the rectangle that is not bed

struct Bed {
  float grey = 0, tolerance = 0;
  bool there = false;
};

std::vector<float> BorderValues(const Image& image) {
  std::vector<float> values;
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const int edge = std::min({row, col, image.height - 1 - row, image.width - 1 - col});
      if (edge < 3 && std::isfinite(image.At(col, row))) values.push_back(image.At(col, row));
    }
  return values;
}

// The most frequent tone of the border.
Bed FindBed(const Image& image) {
  constexpr size_t kBins = 64;
  const std::vector<float> border = BorderValues(image);
  float low = 0, high = 0;
  for (const float v : image.values)
    if (std::isfinite(v)) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  Bed bed;
  if (border.empty() || !(high > low)) return bed;
  std::array<int, kBins> counts{};
  for (const float v : border)
    ++counts[std::min(kBins - 1, static_cast<size_t>((v - low) / (high - low) * kBins))];
  const auto top = std::max_element(counts.begin(), counts.end());
  const float bin = (high - low) / kBins;
  bed.grey = low + (static_cast<float>(top - counts.begin()) + 0.5f) * bin;
  bed.tolerance = 1.5f * bin;
  const auto like = std::count_if(border.begin(), border.end(),
                                  [&](float v) { return std::abs(v - bed.grey) <= bed.tolerance; });
  bed.there = static_cast<double>(like) >= kMinBedShare * static_cast<double>(border.size());
  return bed;
}

struct Box {
  int left = 0, top = 0, right = -1, bottom = -1;  // inclusive
  int Width() const { return right - left + 1; }
  int Height() const { return bottom - top + 1; }
};

// Not bed, small gaps closed: a pixel counts where most of its 5 x 5 neighbours are not bed.
std::vector<char> Foreground(const Image& image, const Bed& bed) {
  std::vector<char> other(image.values.size()), result(image.values.size());
  for (size_t i = 0; i < other.size(); ++i)
    other[i] =
        std::isfinite(image.values[i]) && std::abs(image.values[i] - bed.grey) > bed.tolerance;
  for (int row = 2; row < image.height - 2; ++row)
    for (int col = 2; col < image.width - 2; ++col) {
      int count = 0;
      for (int r = row - 2; r <= row + 2; ++r)
        for (int c = col - 2; c <= col + 2; ++c)
          count += other[static_cast<size_t>(r * image.width + c)];
      result[static_cast<size_t>(row * image.width + col)] = count > 12;
    }
  return result;
}

// Bounds of the connected part that holds `seed`; it is taken out of the mask.
Box TakePart(size_t seed, int width, int height, std::vector<char>* mask,
             std::vector<size_t>* part) {
  Box box{width, height, -1, -1};
  part->assign(1, seed);
  (*mask)[seed] = 0;
  for (size_t i = 0; i < part->size(); ++i) {
    const int col = static_cast<int>((*part)[i] % static_cast<size_t>(width));
    const int row = static_cast<int>((*part)[i] / static_cast<size_t>(width));
    box = {std::min(box.left, col), std::min(box.top, row), std::max(box.right, col),
           std::max(box.bottom, row)};
    for (const auto& [dc, dr] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int c = col + dc, r = row + dr;
      if (c < 0 || r < 0 || c >= width || r >= height) continue;
      const auto next = static_cast<size_t>(r * width + c);
      if ((*mask)[next] == 0) continue;
      (*mask)[next] = 0;
      part->push_back(next);
    }
  }
  return box;
}

// The box without thin tails (a ruler, a hair, a label's edge): lines that hold little of the part.
Box WithoutTails(const Box& box, const std::vector<size_t>& part, int width) {
  std::vector<int> cols(static_cast<size_t>(box.Width()), 0),
      rows(static_cast<size_t>(box.Height()), 0);
  for (const size_t i : part) {
    ++cols[i % static_cast<size_t>(width) - static_cast<size_t>(box.left)];
    ++rows[i / static_cast<size_t>(width) - static_cast<size_t>(box.top)];
  }
  Box trimmed = box;
  const auto thin = [](const std::vector<int>& counts, int at, int full) {
    return counts[static_cast<size_t>(at)] < kFilled * full;
  };
  while (trimmed.left < trimmed.right && thin(cols, trimmed.left - box.left, box.Height()))
    ++trimmed.left;
  while (trimmed.right > trimmed.left && thin(cols, trimmed.right - box.left, box.Height()))
    --trimmed.right;
  while (trimmed.top < trimmed.bottom && thin(rows, trimmed.top - box.top, box.Width()))
    ++trimmed.top;
  while (trimmed.bottom > trimmed.top && thin(rows, trimmed.bottom - box.top, box.Width()))
    --trimmed.bottom;
  return trimmed;
}

}  // namespace

ScanRegion WholeScan(const Eigen::Vector2i& scan_px) {
  return {0.5 * scan_px.cast<double>(), scan_px.cast<double>()};
}

std::vector<ScanRegion> FindFilmOnBed(const ImageWindow& overview) {
  const Image& image = overview.image;
  const Bed bed = FindBed(image);
  std::vector<ScanRegion> found;
  if (!bed.there || image.width < 8 || image.height < 8) return found;
  std::vector<char> mask = Foreground(image, bed);
  std::vector<size_t> part;
  const int smallest =
      static_cast<int>(std::ceil(kSmallestShare * std::max(image.width, image.height)));
  for (size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    const Box whole = TakePart(i, image.width, image.height, &mask, &part);
    const Box box = WithoutTails(whole, part, image.width);
    if (std::min(box.Width(), box.Height()) < smallest) continue;
    if (box.Width() > kLargestShare * image.width && box.Height() > kLargestShare * image.height)
      continue;
    const Vector2d low = overview.RasterFromImage(Vector2d(box.left, box.top));
    const Vector2d high = overview.RasterFromImage(Vector2d(box.right + 1, box.bottom + 1));
    found.push_back({0.5 * (low + high), high - low});
  }
  std::stable_sort(found.begin(), found.end(), [](const ScanRegion& a, const ScanRegion& b) {
    return a.size_px.prod() > b.size_px.prod();
  });
  return found;
}

std::vector<ScanRegion> FindFilmOnBed(const Raster& scan) {
  const int longest = std::max(scan.Width(), scan.Height());
  return FindFilmOnBed(
      scan.ReadGrey({0, 0, scan.Width(), scan.Height()}, std::max(1.0, longest / kOverviewPx)));
}

}  // namespace orient::interior

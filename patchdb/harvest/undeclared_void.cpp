#include "patchdb/harvest/undeclared_void.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>

#include "core/raster/colour_bands.h"

namespace orient::patchdb {
namespace {

constexpr int kSolid_px = 41;      // side of the square of one value that every void contains
constexpr int kSmall_px = 150;     // pixels of one value needed if declared nodata fills the square
constexpr int kLarge_px = 40000;   // pixels of one value from which on edges do not matter
constexpr float kOfEnd = 3;        // most grey values between that value and the end of the range
constexpr float kOfBorder = 12;    // the same for the border of a compressed void
constexpr int kBorder_px = 16;     // width of that border: two JPEG blocks
constexpr int kBeyondEdge_px = 4;  // distance beyond which nothing is left of an edge's blur
constexpr double kSharp = 0.65;    // least share of the step at an edge that its first pixel has

// Ends of the range; for 16 bits those of signed values, too: a raster does not say which it has.
std::vector<float> EndsOf(int bits) {
  if (bits < 8 || bits > 16) return {};
  if (bits == 16) return {0, 65535, 32767, -32768};
  return {0, GreatestValue(bits)};
}

bool IsNear(float value, float other, float tolerance) {
  return std::abs(value - other) <= tolerance;
}

// The pixels that are set, as an image of bytes.
struct Mask {
  int width, height;
  std::vector<std::uint8_t> set;

  Mask(int width_px, int height_px)
      : width(width_px),
        height(height_px),
        set(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), 0) {}
  std::size_t Index(int col, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(col);
  }
  // Calls `work` for each row, then each column: its first pixel, its length, the step to the next.
  template <typename Work>
  void OnLines(const Work& work) {
    for (int row = 0; row < height; ++row) work(&set[Index(0, row)], width, std::size_t{1});
    for (int col = 0; col < width; ++col)
      work(&set[Index(col, 0)], height, static_cast<std::size_t>(width));
  }
};

// Keeps only the pixels in which a full square ends.
void Erode(std::uint8_t* line, int count, std::size_t step) {
  int run = 0;
  for (int i = 0; i < count; ++i) {
    std::uint8_t& pixel = line[step * static_cast<std::size_t>(i)];
    run = pixel != 0 ? run + 1 : 0;
    pixel = run >= kSolid_px;
  }
}

// Sets the pixels that such a square covers.
void Dilate(std::uint8_t* line, int count, std::size_t step) {
  int left = 0;
  for (int i = count; i-- > 0;) {
    std::uint8_t& pixel = line[step * static_cast<std::size_t>(i)];
    left = pixel != 0 ? kSolid_px : left - 1;
    pixel = left > 0;
  }
}

// The most frequent value near an end of the range.
std::optional<float> ValueNear(const Image& grey, float end) {
  std::map<float, int> counts;
  for (const float value : grey.values)
    if (IsNear(value, end, kOfEnd)) ++counts[std::round(value)];
  if (counts.empty()) return std::nullopt;
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

// Finds the voids whose value lies at one end of the range.
class VoidSearch {
 public:
  VoidSearch(const Image& grey, float end, float value)
      : grey_(grey), end_(end), value_(value), taken_(grey.values.size(), 0) {}

  void MarkIn(std::vector<std::uint8_t>* voids) {
    const Mask solid = Solid();
    for (std::size_t start = 0; start < taken_.size(); ++start) {
      if (solid.set[start] == 0 || taken_[start] != 0 || !IsValue(start)) continue;
      const Pixels area = AreaFrom(start);
      if (area_of_value_ >= kLarge_px || (area_of_value_ >= kSmall_px && IsSharp(area)))
        for (const std::size_t pixel : area) (*voids)[pixel] = 1;
    }
  }

 private:
  using Pixels = std::vector<std::size_t>;

  std::size_t Width() const { return static_cast<std::size_t>(grey_.width); }
  bool IsValue(std::size_t pixel) const { return IsNear(grey_.values[pixel], value_, 0.5f); }

  // Pixels covered by squares that contain only the value or nodata.
  Mask Solid() const {
    Mask mask(grey_.width, grey_.height);
    for (std::size_t i = 0; i < mask.set.size(); ++i)
      mask.set[i] = std::isnan(grey_.values[i]) || IsValue(i);
    mask.OnLines(Erode);
    mask.OnLines(Dilate);
    return mask;
  }

  // Neighbours of these pixels that are wanted and not yet taken; marks them as taken.
  template <typename Wanted>
  Pixels Around(const Pixels& pixels, const Wanted& wanted) {
    Pixels around;
    const auto take = [&](std::size_t pixel) {
      if (taken_[pixel] != 0 || !wanted(pixel)) return;
      taken_[pixel] = 1;
      around.push_back(pixel);
    };
    for (const std::size_t pixel : pixels) {
      if (pixel % Width() > 0) take(pixel - 1);
      if (pixel % Width() + 1 < Width()) take(pixel + 1);
      if (pixel >= Width()) take(pixel - Width());
      if (pixel + Width() < taken_.size()) take(pixel + Width());
    }
    return around;
  }

  // The connected area of the value, with the border that compression has altered.
  Pixels AreaFrom(std::size_t start) {
    Pixels area = {start};
    taken_[start] = 1;
    const auto add = [&](const Pixels& pixels) {
      area.insert(area.end(), pixels.begin(), pixels.end());
      return pixels;
    };
    for (Pixels next = area; !next.empty();)
      next = add(Around(next, [&](std::size_t pixel) { return IsValue(pixel); }));
    area_of_value_ = static_cast<int>(area.size());
    Pixels border = area;
    for (int i = 0; i < kBorder_px && !border.empty(); ++i)
      border = add(Around(
          border, [&](std::size_t pixel) { return IsNear(grey_.values[pixel], end_, kOfBorder); }));
    return area;
  }

  double MeanStep(const Pixels& pixels) const {
    double sum = 0;
    for (const std::size_t pixel : pixels) sum += std::abs(grey_.values[pixel] - end_);
    return sum / static_cast<double>(pixels.size());
  }

  bool IsSharp(const Pixels& area) {
    const auto is_data = [&](std::size_t pixel) { return !std::isnan(grey_.values[pixel]); };
    Pixels ring = area, all;
    double first = 0, last = 0;
    for (int i = 0; i < kBeyondEdge_px && !ring.empty(); ++i) {
      ring = Around(ring, is_data);
      all.insert(all.end(), ring.begin(), ring.end());
      if (!ring.empty()) (i == 0 ? first : last) = MeanStep(ring);
    }
    for (const std::size_t pixel : all) taken_[pixel] = 0;
    return first >= kSharp * last;
  }

  const Image& grey_;
  float end_, value_;
  std::vector<std::uint8_t> taken_;
  int area_of_value_ = 0;  // px, of the last area
};

}  // namespace

std::vector<std::uint8_t> UndeclaredVoids(const Image& grey, int bits) {
  std::vector<std::uint8_t> voids(grey.values.size(), 0);
  for (const float end : EndsOf(bits))
    if (const auto value = ValueNear(grey, end)) VoidSearch(grey, end, *value).MarkIn(&voids);
  return voids;
}

double ShareNearEnds(const Image& grey, int bits) {
  const std::vector<float> ends = EndsOf(bits);
  const auto count = std::count_if(grey.values.begin(), grey.values.end(), [&](float value) {
    return std::any_of(ends.begin(), ends.end(),
                       [&](float end) { return IsNear(value, end, kOfBorder); });
  });
  return static_cast<double>(count) /
         static_cast<double>(std::max<std::size_t>(1, grey.values.size()));
}

}  // namespace orient::patchdb

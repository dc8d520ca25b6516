#include "block/pictures/patch_sheet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/raster/raster.h"
#include "exterior/steps/align.h"

namespace orient::block {
namespace {

using Colour = std::array<unsigned char, 3>;

constexpr int kZoom = 2;
constexpr int kMaxSide = 41;             // photo pixels per patch
constexpr int kTile = kMaxSide * kZoom;  // one picture
constexpr int kGap = 6;                  // around a pair, and its coloured frame within
constexpr int kColumns = 8;
constexpr int kCellWidth = 2 * kTile + 2 * kGap;
constexpr int kCellHeight = kTile + 2 * kGap;
constexpr Colour kMatched{46, 140, 70};
constexpr Colour kRejected{200, 50, 40};
constexpr Colour kNotFound{150, 150, 150};

// A sheet of RGB pixels.
class Sheet {
 public:
  Sheet(int width, int height) : width_(width), height_(height) {
    values_.assign(static_cast<std::size_t>(width * height) * 3, 255);
  }
  void Fill(int col, int row, int width, int height, const Colour& colour) {
    for (int r = row; r < row + height; ++r)
      for (int c = col; c < col + width; ++c) Set(c, r, colour);
  }
  // Stretches the image's own range to black and white, enlarged; NaN stays white.
  void Draw(int col, int row, const Image& image) {
    float low = 1e30f, high = -1e30f;
    for (const float v : image.values)
      if (!std::isnan(v)) low = std::min(low, v), high = std::max(high, v);
    const float scale = high > low ? 255.0f / (high - low) : 0.0f;
    for (int r = 0; r < image.height * kZoom; ++r)
      for (int c = 0; c < image.width * kZoom; ++c) {
        const float v = image.At(c / kZoom, r / kZoom);
        const auto grey = std::isnan(v)
                              ? static_cast<unsigned char>(255)
                              : static_cast<unsigned char>(std::lround((v - low) * scale));
        Set(col + c, row + r, {grey, grey, grey});
      }
  }
  void Write(const std::string& path) const { WritePng(path, width_, height_, 3, values_); }

 private:
  void Set(int col, int row, const Colour& colour) {
    std::copy(colour.begin(), colour.end(),
              values_.begin() + static_cast<long>((row * width_ + col) * 3));
  }
  int width_, height_;
  std::vector<unsigned char> values_;
};

// What a person should look at first comes first.
int Rank(PatchState state) {
  return state == PatchState::kRejected ? 0 : state == PatchState::kMatched ? 1 : 2;
}

std::vector<PatchResult> Chosen(const ExteriorResult& result, int count) {
  std::vector<PatchResult> chosen;
  for (const PatchResult& patch : result.patches)
    if (patch.state != PatchState::kNotVisible) chosen.push_back(patch);
  std::stable_sort(chosen.begin(), chosen.end(), [](const PatchResult& a, const PatchResult& b) {
    if (Rank(a.state) != Rank(b.state)) return Rank(a.state) < Rank(b.state);
    return a.ncc.value_or(0) < b.ncc.value_or(0);
  });
  // A quarter for each of the troubled kinds, so that the matched ones are seen as well.
  std::map<int, int> taken;
  std::vector<PatchResult> sheet;
  for (const PatchResult& patch : chosen) {
    const int limit = Rank(patch.state) == 1 ? count / 2 : count / 4;
    if (taken[Rank(patch.state)]++ < limit) sheet.push_back(patch);
  }
  return sheet;
}

Colour FrameColour(PatchState state) {
  if (state == PatchState::kMatched) return kMatched;
  return state == PatchState::kRejected ? kRejected : kNotFound;
}

// The photo around a place without resampling: whole pixels are accurate enough for viewing.
Image PhotoAround(const exterior::PhotoImage& photo, const Eigen::Vector2d& centre, int side) {
  const Eigen::Vector2d corner = (centre.array() - side / 2.0).round();
  const ImageWindow window = photo.Around(corner + Eigen::Vector2d::Constant(side / 2.0),
                                          Eigen::Vector2d::Constant(side / 2.0), 1);
  return window.image;
}

void DrawPair(const PhotoView& view, const exterior::PhotoImage& photo, const patchdb::Patch& patch,
              const PatchResult& result, int col, int row, Sheet* sheet) {
  const auto aligned = exterior::AlignPatch(view, patch, 1, 3, kMaxSide);
  if (!aligned) return;
  sheet->Fill(col + kGap / 2, row + kGap / 2, kCellWidth - kGap, kCellHeight - kGap,
              FrameColour(result.state));
  sheet->Draw(col + kGap, row + kGap, aligned->image);
  const Eigen::Vector2d place = result.pixel.value_or(aligned->predicted_px);
  sheet->Draw(col + kGap + kTile, row + kGap, PhotoAround(photo, place, aligned->image.width));
}

}  // namespace

void WritePatchSheet(const std::string& path, const PhotoView& view,
                     const exterior::PhotoImage& photo, const std::vector<patchdb::Patch>& patches,
                     const ExteriorResult& result, int max_patches) {
  const std::vector<PatchResult> chosen = Chosen(result, max_patches);
  if (chosen.empty()) return;
  std::map<std::int64_t, const patchdb::Patch*> by_id;
  for (const patchdb::Patch& patch : patches) by_id[patch.id] = &patch;
  const int count = static_cast<int>(chosen.size());
  const int rows = (count + kColumns - 1) / kColumns;
  Sheet sheet(std::min(count, kColumns) * kCellWidth, rows * kCellHeight);
  for (int i = 0; i < count; ++i) {
    const PatchResult& patch = chosen[static_cast<std::size_t>(i)];
    const auto known = by_id.find(patch.id);
    if (known == by_id.end()) continue;
    DrawPair(view, photo, *known->second, patch, (i % kColumns) * kCellWidth,
             (i / kColumns) * kCellHeight, &sheet);
  }
  sheet.Write(path);
}

}  // namespace orient::block

#include "block/pictures/scan_overview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/raster/grey_range.h"
#include "core/raster/picture_text.h"

namespace orient::block {
namespace {

using Eigen::Vector2d;
using Colour = std::array<unsigned char, 3>;

constexpr int kLargestSide = 900, kThumbnailSide = 240;
// As on the contact sheet.
constexpr Colour kUsed{60, 220, 60};
constexpr Colour kRejected{255, 140, 0};
constexpr Colour kNotFound{255, 60, 60};

Colour ColourOf(OverviewState state) {
  if (state == OverviewState::kUsed) return kUsed;
  return state == OverviewState::kRejected ? kRejected : kNotFound;
}

// The reduced scan, in which lines are drawn. Places in pixels of the scan.
class Canvas {
 public:
  Canvas(const Raster& scan, int largest_side)
      : reduced_(std::max(
            1.0, std::max(scan.Width(), scan.Height()) / static_cast<double>(largest_side))) {
    const Image grey = scan.ReadGrey({0, 0, scan.Width(), scan.Height()}, reduced_).image;
    width_ = grey.width;
    height_ = grey.height;
    rgb_.assign(3 * grey.values.size(), 255);
    const auto [low, brightest] = GreyRange(grey);
    const float high = std::max(brightest, low + 1e-6f);
    for (size_t i = 0; i < grey.values.size(); ++i) {
      if (std::isnan(grey.values[i])) continue;
      const float share = (grey.values[i] - low) / (high - low);
      const auto level = static_cast<unsigned char>(std::clamp(255 * share, 0.0f, 255.0f));
      std::fill_n(rgb_.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, level);
    }
  }

  void Line(const Vector2d& from, const Vector2d& to, const Colour& colour) {
    const Vector2d a = from / reduced_, b = to / reduced_;
    if (!a.allFinite() || !b.allFinite()) return;
    const auto steps =
        static_cast<int>(std::clamp(std::ceil((b - a).norm()), 1.0, 4.0 * kLargestSide));
    for (int i = 0; i <= steps; ++i) Set(a + (b - a) * i / steps, colour);
  }

  void Frame(const SearchedWindow& w, const Colour& colour) {
    const Vector2d low(w.col, w.row), high = low + Vector2d(w.width, w.height);
    const std::array corners = {low, Vector2d(high.x(), low.y()), high,
                                Vector2d(low.x(), high.y())};
    for (size_t i = 0; i < 4; ++i) Line(corners[i], corners[(i + 1) % 4], colour);
  }

  void Circle(const Vector2d& at, double radius, const Colour& colour) {
    constexpr int kPoints = 40;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2 * std::numbers::pi * i / kPoints;
      Set(at / reduced_ + radius * Vector2d(std::cos(angle), std::sin(angle)), colour);
    }
  }

  // Open at the centre.
  void Cross(const Vector2d& at, double arm, const Colour& colour) {
    const double gap = arm / 3 * reduced_;
    arm *= reduced_;
    for (const Vector2d& along : {Vector2d(1, 0), Vector2d(-1, 0), Vector2d(0, 1), Vector2d(0, -1)})
      Line(at + gap * along, at + arm * along, colour);
  }

  void Write(const std::string& text, const Vector2d& at, const Colour& colour) {
    constexpr int kHeight = 12, kBeside = 8;
    const Vector2d place = at / reduced_;
    if (!Inside(place)) return;
    DrawText(text, static_cast<int>(place.x()) + kBeside,
             std::max(static_cast<int>(place.y()) - kBeside, kHeight + 1), kHeight, colour, width_,
             &rgb_);
  }

  void Save(const std::string& path) const { WritePng(path, width_, height_, 3, rgb_); }

 private:
  bool Inside(const Vector2d& place) const {
    return place.minCoeff() >= 0 && place.x() < width_ && place.y() < height_;
  }

  void Set(const Vector2d& place, const Colour& colour) {
    if (!Inside(place)) return;
    const auto col = static_cast<std::ptrdiff_t>(place.x());
    const auto row = static_cast<std::ptrdiff_t>(place.y());
    std::copy(colour.begin(), colour.end(), rgb_.begin() + 3 * (row * width_ + col));
  }

  double reduced_;
  int width_ = 0, height_ = 0;
  std::vector<unsigned char> rgb_;
};

void Draw(const OverviewItem& item, Canvas* canvas) {
  constexpr double kRadius = 4, kArm = 9;  // pixels of the picture
  const Colour colour = ColourOf(item.state);
  if (item.window) canvas->Frame(*item.window, colour);
  if (item.expected) canvas->Circle(*item.expected, kRadius, colour);
  if (item.expected && item.found) canvas->Line(*item.expected, *item.found, colour);
  if (item.found) canvas->Cross(*item.found, kArm, colour);
  std::optional<Vector2d> at = item.found ? item.found : item.expected;
  if (!at && item.window) at = Vector2d(item.window->col, item.window->row);
  if (at && !item.label.empty()) canvas->Write(item.label, at->cwiseMax(0), colour);
}

}  // namespace

std::vector<OverviewItem> OverviewOf(const InteriorResult& result) {
  std::vector<OverviewItem> items;
  for (const MarkResult& mark : result.marks) {
    OverviewState state = OverviewState::kNotFound;
    if (mark.state == MarkState::kUsed) state = OverviewState::kUsed;
    if (mark.state == MarkState::kRejected) state = OverviewState::kRejected;
    items.push_back({mark.id, state, mark.window, mark.expected, mark.pixel});
  }
  return items;
}

std::vector<OverviewItem> OverviewOf(const ExteriorResult& result) {
  std::vector<OverviewItem> items;
  for (const PatchResult& patch : result.patches) {
    if (patch.state == PatchState::kNotVisible || !(patch.predicted || patch.pixel)) continue;
    OverviewState state = OverviewState::kNotFound;
    if (patch.state == PatchState::kMatched) state = OverviewState::kUsed;
    if (patch.state == PatchState::kRejected) state = OverviewState::kRejected;
    items.push_back({"", state, std::nullopt, patch.predicted, patch.pixel});
  }
  return items;
}

void WriteScanOverview(const std::string& path, const Raster& scan,
                       const std::vector<OverviewItem>& items) {
  Canvas canvas(scan, kLargestSide);
  // What is used last, on top.
  for (const OverviewState state :
       {OverviewState::kNotFound, OverviewState::kRejected, OverviewState::kUsed})
    for (const OverviewItem& item : items)
      if (item.state == state) Draw(item, &canvas);
  canvas.Save(path);
}

void WriteThumbnail(const std::string& path, const Raster& scan) {
  Canvas(scan, kThumbnailSide).Save(path);
}

}  // namespace orient::block

#include "tools/review/scan_tiles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/raster/colour_bands.h"
#include "core/raster/overviews.h"
#include "core/raster/png_bands.h"

namespace orient {
namespace {

constexpr std::size_t kMostOpened = 4;
constexpr std::size_t kMostBytes = 32 * 1024 * 1024;

// Reductions up to this are averaged over all pixels; beyond it a tile would read too many of them.
constexpr int kLargestAverage = 8;

// One row of the scan per row of the image, its columns averaged: sufficient for an overview, and
// only every `reduction`th row of a scan in strips is read. `window` lies inside the scan.
Image PickRows(const Raster& scan, const PixelWindow& window, int reduction) {
  const int width = (window.width + reduction - 1) / reduction;
  const int height = (window.height + reduction - 1) / reduction;
  Image picked(width, height, kNoData);
  for (int row = 0; row < height; ++row) {
    const int source = std::min(window.row + row * reduction + reduction / 2, scan.Height() - 1);
    const Image line = scan.ReadGrey({window.col, source, window.width, 1}).image;
    for (int col = 0; col < width; ++col) {
      double sum = 0;
      int valid = 0;
      for (int c = col * reduction; c < std::min((col + 1) * reduction, line.width); ++c)
        if (!std::isnan(line.At(c, 0))) sum += line.At(c, 0), ++valid;
      if (valid > 0) picked.At(col, row) = static_cast<float>(sum / valid);
    }
  }
  return picked;
}

// `overview`: raster pixels per pixel of the coarsest one.
Image Reduced(const Raster& scan, double overview, const PixelWindow& window, int reduction) {
  if (reduction <= kLargestAverage * overview) return scan.ReadGrey(window, reduction).image;
  return PickRows(scan, window, reduction);
}

int LevelsOf(const Raster& scan) {
  int levels = 1;
  while (std::max(scan.Width(), scan.Height()) > (kTilePx << (levels - 1))) ++levels;
  return levels;
}

// Grey values that become black and white.
struct Stretch {
  float black = 0, white = 255;
};

// From some of its rows: enough for percentiles, and quickly read.
Stretch StretchOf(const Raster& scan) {
  constexpr int kRows = 32;
  const int bits = scan.BitsPerSample();
  if (bits <= 8) return {0, GreatestValue(bits)};
  std::vector<float> values;
  for (int i = 0; i < std::min(kRows, scan.Height()); ++i) {
    const int row = static_cast<int>((i + 0.5) * scan.Height() / std::min(kRows, scan.Height()));
    const Image line = scan.ReadGrey({0, row, scan.Width(), 1}).image;
    std::copy_if(line.values.begin(), line.values.end(), std::back_inserter(values),
                 [](float value) { return !std::isnan(value); });
  }
  if (values.empty()) return {};
  const auto at = [&](double share) {
    const auto nth = values.begin() +
                     static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  const float black = at(0.005), white = at(0.995);
  return {black, std::max(white, std::nextafter(black, INFINITY))};
}

Image Stretched(Image grey, const Stretch& stretch) {
  const float scale = 255 / (stretch.white - stretch.black);
  for (float& value : grey.values)
    value = std::isnan(value) ? 0 : std::clamp((value - stretch.black) * scale, 0.0F, 255.0F);
  return grey;
}

// The part of the scan that a tile shows; empty where there is none.
std::optional<PixelWindow> WindowOf(const Raster& scan, const TilePlace& place, int levels) {
  if (place.level < 0 || place.level >= levels || place.col < 0 || place.row < 0)
    return std::nullopt;
  const long long side = static_cast<long long>(kTilePx) << place.level;
  const long long left = place.col * side, top = place.row * side;
  if (left >= scan.Width() || top >= scan.Height()) return std::nullopt;
  return PixelWindow{static_cast<int>(left), static_cast<int>(top),
                     static_cast<int>(std::min(side, scan.Width() - left)),
                     static_cast<int>(std::min(side, scan.Height() - top))};
}

class Release {
 public:
  explicit Release(std::counting_semaphore<kMostAtWork>* semaphore) : semaphore_(semaphore) {}
  Release(const Release&) = delete;
  Release& operator=(const Release&) = delete;
  ~Release() { semaphore_->release(); }

 private:
  std::counting_semaphore<kMostAtWork>* semaphore_;
};

}  // namespace

struct ScanTiles::Scan {
  explicit Scan(const std::string& path)
      : raster(Raster::OpenScan(path)),
        overview(CoarsestOverview(path)),
        levels(LevelsOf(raster)),
        stretch(StretchOf(raster)) {}

  Raster raster;
  double overview;
  int levels;
  Stretch stretch;
};

std::shared_ptr<const ScanTiles::Scan> ScanTiles::Opened(const std::string& name) {
  const auto path = paths_.find(name);
  if (path == paths_.end()) return nullptr;
  // Others wait: the next tile asked for is mostly one of the same scan.
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(opened_.begin(), opened_.end(),
                                  [&](const auto& one) { return one.first == name; });
  if (found != opened_.end()) {
    opened_.splice(opened_.begin(), opened_, found);
  } else {
    opened_.emplace_front(name, std::make_shared<const Scan>(path->second));
    if (opened_.size() > kMostOpened) opened_.pop_back();
  }
  return opened_.front().second;
}

std::optional<ScanSize> ScanTiles::Size(const std::string& scan) {
  const auto opened = Opened(scan);
  if (opened == nullptr) return std::nullopt;
  return ScanSize{opened->raster.Width(), opened->raster.Height(), opened->levels};
}

std::shared_ptr<const std::string> ScanTiles::Tile(const std::string& scan,
                                                   const TilePlace& place) {
  if (!Has(scan)) return nullptr;
  const std::string key = fmt::format("{} {} {} {}", place.level, place.col, place.row, scan);
  if (auto known = FromCache(key)) return known;
  const auto opened = Opened(scan);
  const auto window = WindowOf(opened->raster, place, opened->levels);
  if (!window) return nullptr;
  at_work_.acquire();
  const Release when_done(&at_work_);
  Image grey = Reduced(opened->raster, opened->overview, *window, 1 << place.level);
  const auto bytes = EncodePngBands({Stretched(std::move(grey), opened->stretch)}, 8);
  auto png = std::make_shared<const std::string>(bytes.begin(), bytes.end());
  Keep(key, png);
  return png;
}

std::shared_ptr<const std::string> ScanTiles::FromCache(const std::string& key) {
  const std::lock_guard lock(mutex_);
  const auto found = by_key_.find(key);
  if (found == by_key_.end()) return nullptr;
  tiles_.splice(tiles_.begin(), tiles_, found->second);
  return found->second->png;
}

void ScanTiles::Keep(const std::string& key, const std::shared_ptr<const std::string>& png) {
  const std::lock_guard lock(mutex_);
  if (by_key_.contains(key)) return;  // another thread was faster
  tiles_.push_front({key, png});
  by_key_[key] = tiles_.begin();
  bytes_ += png->size();
  while (bytes_ > kMostBytes && tiles_.size() > 1) {
    bytes_ -= tiles_.back().png->size();
    by_key_.erase(tiles_.back().key);
    tiles_.pop_back();
  }
}

}  // namespace orient

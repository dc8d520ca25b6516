#include "ortho/mosaic.h"

#include <fmt/format.h>
#include <gdal.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/base/side_by_side.h"
#include "core/raster/band_raster.h"
#include "core/raster/colour_bands.h"
#include "ortho/new_cog.h"

namespace orient::ortho {
namespace {

// The parts' files. As many as a process may have open, or fewer, are: blocks may have thousands.
class Parts {
 public:
  // Throws InputError for parts that make no mosaic together.
  explicit Parts(const std::vector<MosaicPart>& parts) : parts_(parts) {
    if (parts.empty()) throw InputError("no orthophoto to make a mosaic of");
    const MosaicPart& first = parts.front();
    format_ = RasterOf(0)->Format();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (RasterOf(i)->Format() != format_)
        throw InputError(first.path + " and " + parts[i].path +
                         " differ in bands or bits and make no mosaic; make one of each kind");
      if (parts[i].grid.gsd_m != first.grid.gsd_m)
        throw InputError(first.path + " and " + parts[i].path +
                         " differ in their pixel size; make them anew with one --gsd-m");
    }
  }

  std::size_t Size() const { return parts_.size(); }
  const MosaicPart& operator[](std::size_t i) const { return parts_[i]; }
  const BandFormat& Format() const { return format_; }

  // Threads may share it, and keep it while others are opened.
  std::shared_ptr<const BandRaster> RasterOf(std::size_t i) const {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(open_.begin(), open_.end(), [&](const auto& one) { return one.first == i; });
    if (found != open_.end()) {
      std::rotate(open_.begin(), found, found + 1);
      return open_.front().second;
    }
    if (open_.size() == kMostOpen) open_.pop_back();
    open_.emplace_front(i, std::make_shared<const BandRaster>(BandRaster::Open(parts_[i].path)));
    return open_.front().second;
  }

 private:
  static constexpr std::size_t kMostOpen = 100;

  const std::vector<MosaicPart>& parts_;
  BandFormat format_;
  mutable std::mutex mutex_;
  mutable std::deque<std::pair<std::size_t, std::shared_ptr<const BandRaster>>>
      open_;  // last first
};

MapGrid Around(const std::vector<MosaicPart>& parts) {
  MapGrid all = parts.front().grid;
  for (const MosaicPart& part : parts) all = all.With(part.grid);
  constexpr double kMostPixels = 1e11;
  const double pixels = static_cast<double>(all.width) * all.height;
  if (!(pixels < kMostPixels))
    throw InputError(fmt::format(
        "a mosaic of these {} orthophotos would have {:.2g} pixels; give a larger --gsd-m, or make "
        "one of each area",
        parts.size(), pixels));
  return all;
}

// The index into `parts` of each polygon's photo.
std::vector<int> PartsOf(const Seamlines& seamlines, const std::vector<MosaicPart>& parts) {
  std::vector<int> indices;
  for (const std::string& photo : seamlines.Photos()) {
    const auto part = std::find_if(parts.begin(), parts.end(),
                                   [&](const MosaicPart& one) { return one.name == photo; });
    if (part == parts.end())
      throw InputError("the seamlines name the photo " + photo +
                       ", of which there is no orthophoto; delete its polygon or add the photo");
    indices.push_back(static_cast<int>(part - parts.begin()));
  }
  return indices;
}

// The values that a format holds.
struct ValueRange {
  float least, greatest;

  static ValueRange Of(const BandFormat& format) {
    if (format.type == GDT_Byte || format.type == GDT_UInt16)
      return {0, GreatestValue(format.bits)};
    if (format.type == GDT_Int16) return {-32768, 32767};
    return {std::numeric_limits<float>::lowest(), std::numeric_limits<float>::max()};
  }
  float In(const Tone& tone, float value) const {
    return std::clamp(static_cast<float>(tone.Shown(static_cast<double>(value))), least, greatest);
  }
};

class MosaicTile {
 public:
  MosaicTile(const MapGrid& all, const PixelWindow& window, int bands)
      : all_(all),
        window_(window),
        values_(static_cast<std::size_t>(bands), Image(window.width, window.height)),
        mask_(Size(), 0),
        rank_(Size(), std::numeric_limits<double>::infinity()) {}

  // Whether every pixel shows the photo that the seamlines choose.
  bool Complete() const {
    return std::all_of(rank_.begin(), rank_.end(), [](double rank) { return rank < 0; });
  }

  // Takes the part's pixels where it ranks before all taken so far; `index` is its number.
  void Add(const Parts& parts, int index, const std::vector<int>& chosen) {
    const MosaicPart& part = parts[static_cast<std::size_t>(index)];
    const MapGrid& grid = part.grid;
    const PixelWindow from = all_.WindowIn(grid, window_);
    if (from.width <= 0 || from.height <= 0) return;
    const auto raster = parts.RasterOf(static_cast<std::size_t>(index));
    const std::vector<std::uint8_t> mask = raster->ReadMask(from);
    if (std::none_of(mask.begin(), mask.end(), [](std::uint8_t one) { return one != 0; })) return;
    std::vector<Image> values = raster->Read(from);
    Show(part.tones, parts.Format(), &values);
    const int left = static_cast<int>(from.col + grid.west - all_.west - window_.col);
    const int top = static_cast<int>(from.row + all_.north - grid.north - window_.row);
    for (int row = 0; row < from.height; ++row)
      for (int col = 0; col < from.width; ++col) {
        if (mask[static_cast<std::size_t>(row) * from.width + col] == 0) continue;
        const std::size_t to = static_cast<std::size_t>(top + row) * window_.width + left + col;
        const Eigen::Vector2d at = grid.GroundFromPixel(from.col + col + 0.5, from.row + row + 0.5);
        const double rank = chosen[to] == index ? -1 : (at - part.nadir_m).squaredNorm();
        if (!(rank < rank_[to])) continue;
        rank_[to] = rank;
        mask_[to] = 255;
        for (std::size_t band = 0; band < values.size(); ++band)
          values_[band].values[to] = values[band].At(col, row);
      }
  }

  void WriteTo(NewCog* file) const {
    if (std::any_of(mask_.begin(), mask_.end(), [](std::uint8_t one) { return one != 0; }))
      file->Write(window_, values_, mask_);
  }

 private:
  static void Show(const std::vector<Tone>& tones, const BandFormat& format,
                   std::vector<Image>* bands) {
    const ValueRange range = ValueRange::Of(format);
    for (std::size_t band = 0; band < tones.size(); ++band)
      for (float& value : (*bands)[band].values) value = range.In(tones[band], value);
  }

  std::size_t Size() const {
    return static_cast<std::size_t>(window_.width) * static_cast<std::size_t>(window_.height);
  }

  const MapGrid& all_;
  PixelWindow window_;
  std::vector<Image> values_;
  std::vector<std::uint8_t> mask_;
  std::vector<double> rank_;  // -1: chosen by the seamlines; else squared distance from nadir
};

// `chosen`: a part for each pixel, or none.
void DrawTile(const Parts& parts, const std::vector<int>& chosen, MosaicTile* tile) {
  std::vector<bool> is_chosen(parts.Size(), false);
  for (const int part : chosen)
    if (part >= 0) is_chosen[static_cast<std::size_t>(part)] = true;
  for (std::size_t i = 0; i < parts.Size(); ++i)
    if (is_chosen[i]) tile->Add(parts, static_cast<int>(i), chosen);
  if (tile->Complete()) return;
  for (std::size_t i = 0; i < parts.Size(); ++i)
    if (!is_chosen[i]) tile->Add(parts, static_cast<int>(i), chosen);
}

}  // namespace

MapGrid MakeMosaic(const std::vector<MosaicPart>& parts, const Seamlines& seamlines, const Crs& crs,
                   const std::map<std::string, std::string>& metadata, int threads,
                   const std::string& path, ProgressListener* listener) {
  const Parts open(parts);
  const std::vector<int> part_of_polygon = PartsOf(seamlines, parts);
  const MapGrid all = Around(parts);
  const BandFormat& format = open.Format();
  NewCog file(path, format, all, crs);
  const std::vector<PixelWindow> tiles = TilesOf(all);
  ProgressTask progress(listener, "mosaic", static_cast<int>(tiles.size()));
  const auto draw = [&](std::size_t i) {
    std::vector<int> chosen = seamlines.PhotoAt(all, tiles[i]);
    for (int& polygon : chosen)
      if (polygon >= 0) polygon = part_of_polygon[static_cast<std::size_t>(polygon)];
    MosaicTile tile(all, tiles[i], format.bands);
    DrawTile(open, chosen, &tile);
    tile.WriteTo(&file);
    progress.Advance();
  };
  OnThreads(threads, [&] { SideBySide(tiles.size(), draw); });
  file.Finish(metadata, threads);
  return all;
}

}  // namespace orient::ortho

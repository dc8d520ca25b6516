#include "core/raster/grey_reader.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "core/base/error.h"
#include "core/raster/area_average.h"
#include "core/raster/colour_bands.h"
#include "core/raster/reading_errors.h"

namespace orient {
namespace {

constexpr float kRed = 0.299f, kGreen = 0.587f, kBlue = 0.114f;
// Source pixels held in memory at a time while reducing: what the processor's cache holds.
constexpr int kStripPixels = 1 << 16;
// A result pixel needs this share of its area inside the raster and valid.
constexpr double kMinShare = 0.5;

int CellCount(int length, double reduction) {
  return static_cast<int>(std::ceil(length / reduction - 1e-9));
}

GDALRasterBand* MaskBand(GDALDataset* dataset) {
  for (int i = 1; i <= dataset->GetRasterCount(); ++i)
    if (dataset->GetRasterBand(i)->GetColorInterpretation() == GCI_AlphaBand)
      return dataset->GetRasterCount() > 1 ? dataset->GetRasterBand(i) : nullptr;
  GDALRasterBand* first = dataset->GetRasterBand(1);
  return (first->GetMaskFlags() & GMF_PER_DATASET) != 0 ? first->GetMaskBand() : nullptr;
}

GDALRasterBand* OverviewOfSize(GDALRasterBand* band, int width, int height) {
  for (int i = 0; i < band->GetOverviewCount(); ++i) {
    GDALRasterBand* overview = band->GetOverview(i);
    if (overview != nullptr && overview->GetXSize() == width && overview->GetYSize() == height)
      return overview;
  }
  return nullptr;
}

// How a format's overviews are aligned with the raster.
enum class OverviewKind {
  kStretched,   // to the raster's extent, as GDAL builds them
  kPowerOfTwo,  // cells of 2^n pixels, the last one hangs over the edge: decoders that shrink
  kWavelet,     // the same, but a cell is centred on the first of its pixels
};

OverviewKind KindOf(GDALDataset* dataset) {
  const std::string driver = dataset->GetDriverName();
  if (driver == "JPEG") return OverviewKind::kPowerOfTwo;
  return driver.starts_with("JP2") ? OverviewKind::kWavelet : OverviewKind::kStretched;
}

double OverviewScale(OverviewKind kind, int full, int reduced) {
  const double ratio = double(full) / reduced;
  return kind == OverviewKind::kStretched ? ratio : std::exp2(std::round(std::log2(ratio)));
}

double OverviewOrigin(OverviewKind kind, double scale) {
  return kind == OverviewKind::kWavelet ? (1 - scale) / 2 : 0;
}

}  // namespace

GreyReader::GreyReader(GDALDataset* dataset, std::string path)
    : dataset_(dataset), path_(std::move(path)) {
  ChooseBands();
  ReadPalette();
  AddOverviews();
}

void GreyReader::ChooseBands() {
  Level base;
  base.colours = ColourBands(dataset_);
  base.mask = MaskBand(dataset_);
  base.width = dataset_->GetRasterXSize();
  base.height = dataset_->GetRasterYSize();
  for (GDALRasterBand* band : base.colours) {
    if (GDALDataTypeIsComplex(band->GetRasterDataType()))
      throw InputError(path_ +
                       ": complex pixel values are not an image; convert it to grey or RGB");
    int has_nodata = 0;
    const double nodata = band->GetNoDataValue(&has_nodata);
    nodata_.push_back(has_nodata ? std::vector<float>{static_cast<float>(nodata)}
                                 : std::vector<float>{});
  }
  if (IsWhiteZero(dataset_)) white_is_ = GreatestValue(BitsPerSample(base.colours[0]));
  AddLevel(base);
}

void GreyReader::AddLevel(Level level) {
  std::vector<GDALRasterBand*> bands = level.colours;
  if (level.mask != nullptr) bands.push_back(level.mask);
  level.windows = std::make_shared<WindowReader>(dataset_, std::move(bands));
  levels_.push_back(std::move(level));
}

void GreyReader::ReadPalette() {
  if (levels_[0].colours.size() != 1) return;
  const GDALColorTable* table = ColourTableOf(dataset_, levels_[0].colours[0]);
  if (table == nullptr) return;
  for (int i = 0; i < table->GetColorEntryCount(); ++i) {
    GDALColorEntry entry;
    table->GetColorEntryAsRGB(i, &entry);
    const float grey = kRed * entry.c1 + kGreen * entry.c2 + kBlue * entry.c3;
    palette_.push_back(entry.c4 == 0 ? kNoData : grey);
  }
}

void GreyReader::AddOverviews() {
  // An overview of palette indices may hold averaged indices, which mean nothing.
  if (!palette_.empty()) return;
  const Level base = levels_[0];
  const OverviewKind kind = KindOf(dataset_);
  for (int i = 0; i < base.colours[0]->GetOverviewCount(); ++i) {
    GDALRasterBand* first = base.colours[0]->GetOverview(i);
    if (first == nullptr) continue;
    Level level;
    level.width = first->GetXSize();
    level.height = first->GetYSize();
    for (GDALRasterBand* band : base.colours)
      level.colours.push_back(OverviewOfSize(band, level.width, level.height));
    const bool complete = std::count(level.colours.begin(), level.colours.end(), nullptr) == 0;
    if (base.mask != nullptr) level.mask = OverviewOfSize(base.mask, level.width, level.height);
    if (!complete || (base.mask != nullptr && level.mask == nullptr)) continue;
    level.col_scale = OverviewScale(kind, base.width, level.width);
    level.row_scale = OverviewScale(kind, base.height, level.height);
    level.col_origin = OverviewOrigin(kind, level.col_scale);
    level.row_origin = OverviewOrigin(kind, level.row_scale);
    if (level.col_scale > 1 && level.row_scale > 1) AddLevel(level);
  }
}

const GreyReader::Level& GreyReader::LevelFor(double reduction) const {
  const Level* best = &levels_[0];
  for (const Level& level : levels_) {
    const bool fine_enough = std::max(level.col_scale, level.row_scale) <= reduction * (1 + 1e-9);
    if (fine_enough && level.col_scale > best->col_scale) best = &level;
  }
  return *best;
}

void GreyReader::ReadBand(const Level& level, std::size_t band, const Block& block,
                          const PixelWindow& asked, float* values) const {
  const std::optional<std::string> why_not =
      level.windows->Read(band, {block.col, block.row, block.width, block.height}, values);
  if (!why_not) return;
  const ReadingErrors flushing_may_speak;
  dataset_->FlushCache(false);
  const bool progressive = why_not->find("require libjpeg to allocate") != std::string::npos;
  throw InputError(fmt::format(
      "{}: cannot read the window col {} row {} size {} x {} ({}); {}", path_, asked.col, asked.row,
      asked.width, asked.height, *why_not,
      progressive ? "a progressive JPEG of this size has no windows: write it in tiles "
                    "(gdal_translate -co TILED=YES --config GDAL_ALLOW_LARGE_LIBJPEG_MEM_ALLOC YES)"
                  : "the file is damaged or truncated: copy or scan it again"));
}

bool GreyReader::IsGrey() const {
  return levels_[0].colours.size() == 1 && palette_.empty() && nodata_[0].empty() &&
         white_is_ < 0 && GDALDataTypeIsInteger(levels_[0].colours[0]->GetRasterDataType());
}

void GreyReader::ToGrey(const std::vector<Image>& colours, Image* grey) const {
  using Values = Eigen::Map<const Eigen::ArrayXf>;
  const auto size = static_cast<Eigen::Index>(grey->values.size());
  const Values first(colours[0].values.data(), size);
  Eigen::Map<Eigen::ArrayXf> result(grey->values.data(), size);
  if (colours.size() == 3)
    result = kRed * first + kGreen * Values(colours[1].values.data(), size) +
             kBlue * Values(colours[2].values.data(), size);
  else
    result = first;
  if (!palette_.empty()) {  // the palette already accounts for an inverted scale
    for (float& value : grey->values) {
      const bool known = value >= 0 && value < static_cast<float>(palette_.size());
      value = known ? palette_[static_cast<size_t>(value)] : kNoData;
    }
  } else if (white_is_ > 0) {
    result = white_is_ - result;
  }
  for (float& value : grey->values)
    if (!std::isfinite(value)) value = kNoData;
  if (std::any_of(nodata_.begin(), nodata_.end(), [](const auto& n) { return n.empty(); })) return;
  for (size_t i = 0; i < grey->values.size(); ++i) {
    bool any_data = false;
    for (size_t b = 0; b < colours.size(); ++b)
      any_data = any_data || colours[b].values[i] != nodata_[b][0];
    if (!any_data) grey->values[i] = kNoData;
  }
}

void GreyReader::ReadLevel(const Level& level, const Block& block, const PixelWindow& asked,
                           Image* grey) const {
  if (grey->width != block.width || grey->height != block.height)
    *grey = Image(block.width, block.height);
  if (IsGrey()) {
    ReadBand(level, 0, block, asked, grey->values.data());
  } else {
    std::vector<Image> colours;
    for (std::size_t band = 0; band < level.colours.size(); ++band) {
      colours.emplace_back(block.width, block.height);
      ReadBand(level, band, block, asked, colours.back().values.data());
    }
    ToGrey(colours, grey);
  }
  if (level.mask == nullptr) return;
  Image mask(block.width, block.height);
  ReadBand(level, level.colours.size(), block, asked, mask.values.data());
  for (size_t i = 0; i < grey->values.size(); ++i)
    if (mask.values[i] == 0) grey->values[i] = kNoData;
}

GreyReader::Span GreyReader::SpanOf(const std::vector<CellWeights>& cells) {
  Span span{0, 0};
  for (const CellWeights& cell : cells) {
    if (cell.weights.empty()) continue;
    if (span.stop == span.first) span.first = cell.first;
    span.stop = cell.first + static_cast<int>(cell.weights.size());
  }
  return span;
}

ImageWindow GreyReader::ReadUnreduced(const PixelWindow& window) const {
  const Level& level = levels_[0];
  ImageWindow result;
  result.image = Image(window.width, window.height, kNoData);
  result.origin = Eigen::Vector2d(window.col, window.row);
  const int left = std::max(window.col, 0), top = std::max(window.row, 0);
  const Block block{left, top, std::min(window.col + window.width, level.width) - left,
                    std::min(window.row + window.height, level.height) - top};
  if (block.width <= 0 || block.height <= 0) return result;
  Image grey;
  ReadLevel(level, block, window, &grey);
  for (int row = 0; row < block.height; ++row)
    std::copy_n(grey.Row(row), block.width,
                result.image.Row(top - window.row + row) + (left - window.col));
  return result;
}

ImageWindow GreyReader::Read(const PixelWindow& window, double reduction) const {
  if (reduction == 1) return ReadUnreduced(window);
  const Level& level = LevelFor(reduction);
  const auto cols =
      AreaWeights((window.col - level.col_origin) / level.col_scale, reduction / level.col_scale,
                  CellCount(window.width, reduction), level.width);
  const auto rows =
      AreaWeights((window.row - level.row_origin) / level.row_scale, reduction / level.row_scale,
                  CellCount(window.height, reduction), level.height);
  const Span col_span = SpanOf(cols), row_span = SpanOf(rows);
  AreaAverager averager(cols, rows, col_span.first);
  const int width = col_span.stop - col_span.first;
  if (width > 0) {
    const int strip = std::max(1, kStripPixels / width);
    Image grey;
    for (int row = row_span.first; row < row_span.stop; row += strip) {
      const Block block{col_span.first, row, width, std::min(strip, row_span.stop - row)};
      ReadLevel(level, block, window, &grey);
      for (int r = 0; r < block.height; ++r) averager.AddRow(row + r, grey.Row(r));
    }
  }
  ImageWindow result;
  result.image = averager.Result(kMinShare, false);
  result.origin = Eigen::Vector2d(window.col, window.row);
  result.scale = reduction;
  return result;
}

}  // namespace orient

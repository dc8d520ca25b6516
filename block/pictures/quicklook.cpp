#include "block/pictures/quicklook.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "block/inputs/block_files.h"
#include "block/pictures/ortho_photo.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "core/matching/correlation.h"
#include "core/raster/picture_text.h"
#include "core/raster/raster.h"
#include "core/raster/resample.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;
using Eigen::Vector2d;
using Colour = std::array<unsigned char, 3>;

constexpr int kMosaicSide = 1400;  // px, the longer one
constexpr int kCropSide = 120;     // pixels of a place at a seam
constexpr int kZoom = 2;           // of these in the picture
constexpr int kField = 30;         // of the chequerboard
constexpr int kTemplateSide = 61;  // what is matched across the seam
constexpr std::size_t kPlaces = 12;
constexpr int kColumns = 4;
constexpr Colour kSeam{250, 210, 40};

std::optional<GroundGrid> GridOver(const std::vector<QuicklookPhoto>& photos,
                                   const GroundSurface& surface) {
  Bounds all = Bounds::OfNothing();
  for (const QuicklookPhoto& photo : photos) {
    const auto seen = FootprintBounds(photo.view.camera, photo.view.pose, surface.MinHeight(),
                                      surface.MaxHeight());
    if (!seen) continue;
    all.Include(seen->min_x, seen->min_y);
    all.Include(seen->max_x, seen->max_y);
  }
  if (all.Empty()) return std::nullopt;
  const Bounds dem = surface.Extent();
  const double west = std::max(all.min_x, dem.min_x), east = std::min(all.max_x, dem.max_x);
  const double south = std::max(all.min_y, dem.min_y), north = std::min(all.max_y, dem.max_y);
  if (!(west < east && south < north)) return std::nullopt;
  GroundGrid grid{west, north, std::max(east - west, north - south) / kMosaicSide, 0, 0};
  grid.width = std::max(1, static_cast<int>((east - west) / grid.gsd_m));
  grid.height = std::max(1, static_cast<int>((north - south) / grid.gsd_m));
  return grid;
}

// A photo's contribution to the mosaic: orthophoto and each pixel's distance from the photo centre.
struct Layer {
  Image ortho, off_middle, to_border;
};

// The part of the grid that the photo may show.
struct GridPart {
  int first_col = 0, end_col = 0, first_row = 0, end_row = 0;
};

GridPart PartOf(const GroundGrid& grid, const QuicklookPhoto& photo, const GroundSurface& surface) {
  const auto seen =
      FootprintBounds(photo.view.camera, photo.view.pose, surface.MinHeight(), surface.MaxHeight());
  if (!seen) return {};
  const auto cell = [&](double offset_m, int most) {
    return static_cast<int>(std::clamp(offset_m / grid.gsd_m, 0.0, static_cast<double>(most)));
  };
  return {cell(seen->min_x - grid.west_m, grid.width),
          std::min(cell(seen->max_x - grid.west_m, grid.width) + 1, grid.width),
          cell(grid.north_m - seen->max_y, grid.height),
          std::min(cell(grid.north_m - seen->min_y, grid.height) + 1, grid.height)};
}

Layer DrawLayer(const QuicklookPhoto& file, const GroundGrid& grid, const GroundSurface& surface,
                const Image& heights) {
  const OrthoPhoto photo(file);
  const double gsd = photo.Gsd(surface.MeanHeight());
  const ImageWindow whole = photo.Whole(std::max(1, static_cast<int>(grid.gsd_m / gsd)));
  const Image none(grid.width, grid.height, kNoData);
  Layer layer{none, none, none};
  const GridPart part = PartOf(grid, file, surface);
  for (int row = part.first_row; row < part.end_row; ++row)
    for (int col = part.first_col; col < part.end_col; ++col) {
      const float height = heights.At(col, row);
      if (std::isnan(height)) continue;
      const Vector2d xy = grid.At(col + 0.5, row + 0.5);
      const auto seen = photo.See({xy.x(), xy.y(), static_cast<double>(height)});
      if (!seen) continue;
      layer.ortho.At(col, row) = SampleBilinear(whole.image, whole.ImageFromRaster(seen->pixel));
      if (std::isnan(layer.ortho.At(col, row))) continue;
      layer.off_middle.At(col, row) = static_cast<float>(seen->off_middle);
      layer.to_border.At(col, row) = static_cast<float>(seen->to_border);
    }
  Standardise(&layer.ortho);
  return layer;
}

Image HeightsOver(const GroundGrid& grid, const GroundSurface& surface) {
  Image heights(grid.width, grid.height, kNoData);
  for (int row = 0; row < grid.height; ++row)
    for (int col = 0; col < grid.width; ++col) {
      const Vector2d xy = grid.At(col + 0.5, row + 0.5);
      if (const auto height = surface.HeightAt(xy.x(), xy.y()))
        heights.At(col, row) = static_cast<float>(*height);
    }
  return heights;
}

// The mosaic: which photo each pixel is from (-1: none), and which would be next.
struct Mosaic {
  GroundGrid grid;
  Image grey;
  std::vector<int> owner, next;
  Image to_border;  // the nearer one of both photos' borders

  std::size_t Index(int col, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width) +
           static_cast<std::size_t>(col);
  }
  bool IsSeam(int col, int row) const {
    const int own = owner[Index(col, row)];
    const auto other = [&](int c, int r) {
      const int theirs = owner[Index(c, r)];
      return own >= 0 && theirs >= 0 && theirs != own;
    };
    return (col + 1 < grid.width && other(col + 1, row)) ||
           (row + 1 < grid.height && other(col, row + 1));
  }
};

// Distances to the centres of the best and second-best photos, and nearness of their borders.
struct Ranking {
  Image first_off, second_off, first_border, second_border;
};

void Merge(const Layer& layer, int photo, Ranking* ranking, Mosaic* mosaic) {
  for (std::size_t i = 0; i < layer.ortho.values.size(); ++i) {
    const float off = layer.off_middle.values[i], border = layer.to_border.values[i];
    if (std::isnan(off)) continue;
    if (!(ranking->first_off.values[i] <= off)) {
      ranking->second_off.values[i] = ranking->first_off.values[i];
      ranking->second_border.values[i] = ranking->first_border.values[i];
      mosaic->next[i] = mosaic->owner[i];
      ranking->first_off.values[i] = off;
      ranking->first_border.values[i] = border;
      mosaic->owner[i] = photo;
      mosaic->grey.values[i] = layer.ortho.values[i];
    } else if (!(ranking->second_off.values[i] <= off)) {
      ranking->second_off.values[i] = off;
      ranking->second_border.values[i] = border;
      mosaic->next[i] = photo;
    }
    mosaic->to_border.values[i] =
        std::fmax(ranking->first_border.values[i], ranking->second_border.values[i]);
  }
}

// Photo by photo: a block's scans and layers together would be too many.
Mosaic MakeMosaic(const std::vector<QuicklookPhoto>& photos, const GroundGrid& grid,
                  const GroundSurface& surface, std::vector<std::string>* left_out) {
  const Image heights = HeightsOver(grid, surface);
  const std::size_t pixels = heights.values.size();
  const Image none(grid.width, grid.height, kNoData);
  Mosaic mosaic{grid, none, std::vector<int>(pixels, -1), std::vector<int>(pixels, -1), none};
  Ranking ranking{none, none, none, none};
  for (std::size_t i = 0; i < photos.size(); ++i) {
    try {
      Merge(DrawLayer(photos[i], grid, surface, heights), static_cast<int>(i), &ranking, &mosaic);
    } catch (const InputError&) {
      left_out->push_back(photos[i].name);
    }
  }
  return mosaic;
}

unsigned char Grey(float value) {
  if (std::isnan(value)) return 255;
  return static_cast<unsigned char>(std::lround(std::clamp(value, 0.0f, 255.0f)));
}

void WriteMosaic(const std::string& path, const Mosaic& mosaic) {
  std::vector<unsigned char> rgb;
  rgb.reserve(3 * mosaic.grey.values.size());
  for (int row = 0; row < mosaic.grid.height; ++row)
    for (int col = 0; col < mosaic.grid.width; ++col) {
      const unsigned char grey = Grey(mosaic.grey.At(col, row));
      const Colour colour = mosaic.IsSeam(col, row) ? kSeam : Colour{grey, grey, grey};
      rgb.insert(rgb.end(), colour.begin(), colour.end());
    }
  WritePng(path, mosaic.grid.width, mosaic.grid.height, 3, rgb);
}

// A pixel of the mosaic on a seam, with the two photos that meet there.
struct Candidate {
  int col = 0, row = 0, first = 0, second = 0;
  Vector2d Place() const { return {col, row}; }
};

// Spread: each next place is the one farthest from those that are taken.
std::vector<Candidate> ChoosePlaces(const Mosaic& mosaic) {
  constexpr float kWellInside = 0.85f;  // both photos show all of the place
  std::vector<Candidate> candidates;
  for (int row = 0; row < mosaic.grid.height; ++row)
    for (int col = 0; col < mosaic.grid.width; ++col)
      if (mosaic.IsSeam(col, row) && mosaic.next[mosaic.Index(col, row)] >= 0 &&
          mosaic.to_border.At(col, row) < kWellInside)
        candidates.push_back(
            {col, row, mosaic.owner[mosaic.Index(col, row)], mosaic.next[mosaic.Index(col, row)]});
  std::vector<Candidate> chosen;
  if (candidates.empty()) return chosen;
  std::vector<double> distance(candidates.size(), 1e18);
  std::size_t next = candidates.size() / 2;
  while (chosen.size() < kPlaces && distance[next] > 0) {
    chosen.push_back(candidates[next]);
    for (std::size_t i = 0; i < candidates.size(); ++i)
      distance[i] = std::min(distance[i], (candidates[i].Place() - chosen.back().Place()).norm());
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) -
                                    distance.begin());
  }
  return chosen;
}

std::optional<Vector2d> ShiftBetween(const Image& first, const Image& second) {
  const Image templ = MiddleOf(first, kTemplateSide, kTemplateSide);
  const Image scores = Correlate(templ, second);
  constexpr double kLeastScore = 0.6;
  const std::vector<Peak> peaks = FindPeaks(scores, 2, 5, kLeastScore);
  if (peaks.empty()) return std::nullopt;
  constexpr double kAmbiguous = 0.1;
  if (peaks.size() > 1 && peaks[0].score - peaks[1].score < kAmbiguous) return std::nullopt;
  const int zero = (kCropSide - kTemplateSide) / 2;  // whole pixels, as MiddleOf
  return Vector2d(peaks[0].position.x() - zero, peaks[0].position.y() - zero);
}

struct SeamPicture {
  SeamPlace place;
  Image first, second;
};

SeamPicture MakeSeam(const Candidate& candidate, const std::vector<QuicklookPhoto>& photos,
                     const GroundGrid& grid, const GroundSurface& surface) {
  const OrthoPhoto first(photos[static_cast<std::size_t>(candidate.first)]);
  const OrthoPhoto second(photos[static_cast<std::size_t>(candidate.second)]);
  const Vector2d xy = grid.At(candidate.col + 0.5, candidate.row + 0.5);
  const double height = surface.HeightAt(xy.x(), xy.y()).value_or(surface.MeanHeight());
  const double gsd = std::max(first.Gsd(height), second.Gsd(height));
  const double half = 0.5 * kCropSide * gsd;
  const GroundGrid crop{xy.x() - half, xy.y() + half, gsd, kCropSide, kCropSide};
  SeamPicture seam{{first.Name(), second.Name(), {xy.x(), xy.y(), height}, std::nullopt},
                   first.Draw(crop, surface),
                   second.Draw(crop, surface)};
  seam.place.shift_px = ShiftBetween(seam.first, seam.second);
  return seam;
}

class SeamSheet {
 public:
  explicit SeamSheet(std::size_t places)
      : width_(kColumns * kCell + kGap),
        height_(static_cast<int>((places + kColumns - 1) / kColumns) * (kCell + kText) + kGap),
        rgb_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 3, 255) {}

  void Draw(std::size_t i, const SeamPicture& seam) {
    const int left = kGap + static_cast<int>(i % kColumns) * kCell;
    const int top = kGap + static_cast<int>(i / kColumns) * (kCell + kText);
    for (int row = 0; row < kCropSide * kZoom; ++row)
      for (int col = 0; col < kCropSide * kZoom; ++col) {
        const int c = col / kZoom, r = row / kZoom;
        const bool even = (c / kField + r / kField) % 2 == 0;
        Set(left + col, top + row, Grey((even ? seam.first : seam.second).At(c, r)));
      }
    const auto& shift = seam.place.shift_px;
    const std::string text =
        shift ? fmt::format("{:.1f} {:.1f} px", shift->x(), shift->y()) : "not measured";
    DrawText(text, left, top + kCropSide * kZoom + 16, 11, {34, 40, 47}, width_, &rgb_);
  }

  void Write(const std::string& path) const { WritePng(path, width_, height_, 3, rgb_); }

 private:
  static constexpr int kGap = 8, kText = 16, kCell = kCropSide * kZoom + kGap;

  void Set(int col, int row, unsigned char grey) {
    const std::size_t at = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                                static_cast<std::size_t>(col));
    rgb_[at] = rgb_[at + 1] = rgb_[at + 2] = grey;
  }

  int width_, height_;
  std::vector<unsigned char> rgb_;
};

std::vector<SeamPicture> MakeSeams(const Mosaic& mosaic, const std::vector<QuicklookPhoto>& photos,
                                   const GroundSurface& surface) {
  const std::vector<Candidate> places = ChoosePlaces(mosaic);
  std::vector<SeamPicture> seams(places.size());
  SideBySide(places.size(),
             [&](std::size_t i) { seams[i] = MakeSeam(places[i], photos, mosaic.grid, surface); });
  return seams;
}

}  // namespace

int Quicklook::Measured() const {
  return static_cast<int>(std::count_if(
      seams.begin(), seams.end(), [](const SeamPlace& seam) { return seam.shift_px.has_value(); }));
}

std::optional<double> Quicklook::MedianShiftPx() const {
  constexpr std::size_t kFewest = 3;
  std::vector<double> lengths;
  for (const SeamPlace& seam : seams)
    if (seam.shift_px) lengths.push_back(seam.shift_px->norm());
  if (lengths.size() < kFewest) return std::nullopt;
  return Median(std::move(lengths));
}

std::optional<Quicklook> WriteQuicklook(const std::string& directory,
                                        const std::vector<QuicklookPhoto>& photos,
                                        const GroundSurface& surface) {
  const std::string mosaic_path = (fs::path(directory) / kQuicklookFile).string();
  const std::string seams_path = (fs::path(directory) / kSeamsFile).string();
  fs::remove(mosaic_path);
  fs::remove(seams_path);
  const auto grid = GridOver(photos, surface);
  if (!grid) return std::nullopt;
  Quicklook quicklook{grid->gsd_m, {}, {}};
  const Mosaic mosaic = MakeMosaic(photos, *grid, surface, &quicklook.left_out);
  WriteMosaic(mosaic_path, mosaic);
  const std::vector<SeamPicture> seams = MakeSeams(mosaic, photos, surface);
  if (seams.empty()) return quicklook;
  SeamSheet sheet(seams.size());
  for (std::size_t i = 0; i < seams.size(); ++i) {
    sheet.Draw(i, seams[i]);
    quicklook.seams.push_back(seams[i].place);
  }
  sheet.Write(seams_path);
  return quicklook;
}

}  // namespace orient::block

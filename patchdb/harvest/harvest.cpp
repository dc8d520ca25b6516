#include "patchdb/harvest/harvest.h"

#include <fmt/format.h>

#include <map>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "patchdb/harvest/candidates.h"
#include "patchdb/harvest/patch_making.h"
#include "patchdb/harvest/source_view.h"

namespace orient::patchdb {
namespace {

constexpr double kMinSpacing_px = 30;      // where spacing_px is empty: half a chip
constexpr int kTriesPerCell = 4;           // candidates looked at, strongest first
constexpr double kDefaultDemSigma = 0.1;   // of the DEM's cell
constexpr int kGsdSamples = 7;             // a side, over the source
constexpr std::size_t kCellsAtOnce = 256;  // cut in parallel, then accepted in order

// Places that have a patch, by cell.
class TakenPlaces {
 public:
  TakenPlaces(double cell_m, double min_distance_m)
      : cell_m_(cell_m), min_distance_m_(min_distance_m) {}
  void Add(const Eigen::Vector2d& place_m) { places_[CellOf(place_m, cell_m_)].push_back(place_m); }
  // Patches of neighbouring cells must not meet at their common border.
  bool TooClose(const Eigen::Vector2d& place_m) const {
    const CellIndex index = CellOf(place_m, cell_m_);
    for (std::int64_t row = index.first - 1; row <= index.first + 1; ++row)
      for (std::int64_t col = index.second - 1; col <= index.second + 1; ++col) {
        const auto cell = places_.find({row, col});
        if (cell == places_.end()) continue;
        for (const Eigen::Vector2d& other : cell->second)
          if ((other - place_m).norm() < min_distance_m_) return true;
      }
    return false;
  }

 private:
  double cell_m_, min_distance_m_;
  std::map<CellIndex, std::vector<Eigen::Vector2d>> places_;
};

// A cell still without a patch.
struct OpenCell {
  const std::vector<InterestCandidate>* candidates;
  std::optional<Patch> patch = {};
};

class PatchCutter {
 public:
  PatchCutter(const PatchMaker& maker, double cell_m, HarvestResult& result)
      : maker_(maker), taken_(cell_m, 0.5 * cell_m), result_(result) {
    for (const Eigen::Vector2d& place : maker.context.taken_m) taken_.Add(place);
  }

  // Tries the cells' candidates in rounds: all next ones are made in parallel, then accepted in the
  // cells' order, so that the result does not depend on the number of threads.
  void Cut(std::vector<OpenCell>& cells) {
    for (std::size_t round = 0; static_cast<int>(round) < kTriesPerCell; ++round) {
      std::vector<OpenCell*> open;
      for (OpenCell& cell : cells)
        if (!cell.patch && round < cell.candidates->size() &&
            !taken_.TooClose((*cell.candidates)[round].ground_m.head<2>()))
          open.push_back(&cell);
      std::vector<std::variant<Patch, Refusal>> made(open.size());
      SideBySide(open.size(),
                 [&](std::size_t i) { made[i] = maker_.Make((*open[i]->candidates)[round]); });
      for (std::size_t i = 0; i < open.size(); ++i) Take(made[i], *open[i]);
    }
    for (OpenCell& cell : cells)
      if (cell.patch) result_.patches.push_back(std::move(*cell.patch));
  }

 private:
  void Take(std::variant<Patch, Refusal>& made, OpenCell& cell) {
    if (const auto* refusal = std::get_if<Refusal>(&made)) {
      ++result_.refused[static_cast<std::size_t>(*refusal)];
      return;
    }
    Patch& patch = std::get<Patch>(made);
    if (taken_.TooClose(patch.ground_m.head<2>())) return;
    taken_.Add(patch.ground_m.head<2>());
    cell.patch = std::move(patch);
  }

  const PatchMaker& maker_;
  TakenPlaces taken_;
  HarvestResult& result_;
};

void CutPatches(const PatchMaker& maker, const CandidateGrid& grid, double cell_m,
                const HarvestProgress& progress, HarvestResult& result) {
  PatchCutter cutter(maker, cell_m, result);
  const int total = static_cast<int>(grid.cells.size());
  int done = 0;
  for (auto next = grid.cells.begin(); next != grid.cells.end();) {
    std::vector<OpenCell> cells;
    for (; next != grid.cells.end() && cells.size() < kCellsAtOnce; ++next)
      cells.push_back({&next->second});
    cutter.Cut(cells);
    done += static_cast<int>(cells.size());
    if (progress) progress("cutting patches", done, total);
  }
}

// Median ground pixel over the source. Throws InputError where no part of it has known ground.
double MedianGsd(const Raster& raster, const SourceView& source) {
  std::vector<double> gsds;
  for (int i = 0; i < kGsdSamples; ++i)
    for (int j = 0; j < kGsdSamples; ++j) {
      const Eigen::Vector2d pixel((j + 0.5) / kGsdSamples * raster.Width(),
                                  (i + 0.5) / kGsdSamples * raster.Height());
      const auto ground = source.GroundFromPixel(pixel);
      const auto gsd = ground ? GsdAt(source, *ground) : std::nullopt;
      if (gsd) gsds.push_back(*gsd);
    }
  if (gsds.empty())
    throw InputError(raster.Path() + " shows no ground that the DEM covers; check the DEM, and " +
                     "that the orientation or georeference belongs to this image");
  return UpperMedian(std::move(gsds));
}

double CellSpacing(const Raster& raster, const HarvestOptions& options) {
  if (options.spacing_px) return *options.spacing_px;
  const double area = static_cast<double>(raster.Width()) * raster.Height();
  return std::max(kMinSpacing_px, std::sqrt(area / options.max_count));
}

// So coarse that a cell still has dozens of pixels per side: for few patches, not all pixels of a
// large photo need be searched.
int ReductionFor(double cell_px) {
  constexpr double kPixelsACell = 60;
  constexpr int kCoarsest = 4;
  return std::clamp(static_cast<int>(cell_px / kPixelsACell), 1, kCoarsest);
}

HarvestResult Harvest(const Raster& raster, const SourceView& source, const GroundSurface& surface,
                      const HarvestOptions& options, const HarvestProgress& progress,
                      const HarvestContext& context) {
  const auto colour = options.colour ? ColourRaster::Open(raster.Path()) : std::nullopt;
  PatchMaker maker{raster, source, surface, options, context, StoredBits(raster)};
  maker.colour = colour ? &*colour : nullptr;
  maker.dem_sigma_m = options.dem_sigma_m.value_or(kDefaultDemSigma * surface.CellSize());
  HarvestResult result;
  result.gsd_m = MedianGsd(raster, source);
  const double cell_px = CellSpacing(raster, options);
  CandidateSearch search;
  search.cell_m = cell_px * result.gsd_m;
  search.per_cell = kTriesPerCell;
  search.tile_px = options.tile_px;
  search.reduction = ReductionFor(cell_px);
  if (!context.further.empty())
    search.wanted = [&maker](const Eigen::Vector3d& ground) { return maker.ShowsBest(ground); };
  const CandidateGrid grid =
      FindInterestCandidates(raster, source, search, [&progress](int done, int total) {
        if (progress) progress("searching tiles", done, total);
      });
  result.candidates = grid.count;
  result.cells = static_cast<int>(grid.cells.size());
  CutPatches(maker, grid, search.cell_m, progress, result);
  return result;
}

void RequireGood(const HarvestOptions& options) {
  if (const auto wrong = options.Check()) throw std::invalid_argument(*wrong);
}

}  // namespace

std::string_view Name(Refusal refusal) {
  switch (refusal) {
    case Refusal::kNoHeight:
      return "no height";
    case Refusal::kNoImage:
      return "image border or nodata";
    case Refusal::kRelief:
      return "rugged ground";
    case Refusal::kFlat:
      return "no contrast";
    case Refusal::kRepetitive:
      return "repetitive";
    case Refusal::kShortLived:
      return "lost in the pyramid";
    case Refusal::kNotConfirmed:
      return "not in other views";
    case Refusal::kDisagreement:
      return "views disagree";
    case Refusal::kOtherHeight:
      return "not the DEM's height";
    case Refusal::kStanding:
      break;
  }
  return "stands in the DSM";
}

std::optional<std::string> HarvestOptions::Check() const {
  if (chip_px < 15 || chip_px > 501 || chip_px % 2 == 0)
    return "the chip's side must be an odd number of pixels from 15 to 501";
  if (spacing_px && !(*spacing_px >= 1)) return "the spacing must be at least 1 pixel";
  if (max_count < 1) return "the number of patches must be positive";
  if (tile_px < 64) return "a tile must have at least 64 pixels per side";
  if (max_further_views < 0) return "the number of further views must not be negative";
  if (!(max_lean_px > 0)) return "the lean must be positive";
  if (!(orientation_sigma_px > 0) || (dem_sigma_m && !(*dem_sigma_m > 0)))
    return "a sigma must be positive";
  return std::nullopt;
}

HarvestOptions OrthoHarvestOptions() {
  HarvestOptions options;
  options.max_count = 10000;
  return options;
}

HarvestResult HarvestPhoto(const Raster& photo, const PhotoView& view,
                           const std::optional<Matrix6d>& pose_covariance,
                           const GroundSurface& surface, const HarvestOptions& options,
                           const HarvestProgress& progress, const HarvestContext& context) {
  RequireGood(options);
  const auto source = MakePhotoSource(view, pose_covariance, options.orientation_sigma_px, surface);
  return Harvest(photo, *source, surface, options, progress, context);
}

HarvestResult HarvestOrtho(const Raster& ortho, const Crs& ground_crs, const GroundSurface& surface,
                           const HarvestOptions& options, const HarvestProgress& progress,
                           const HarvestContext& context) {
  RequireGood(options);
  const auto source = MakeOrthoSource(ortho, ground_crs, options.orientation_sigma_px, surface);
  return Harvest(ortho, *source, surface, options, progress, context);
}

}  // namespace orient::patchdb

#include "patchdb/harvest.h"

#include <stdexcept>
#include <variant>

#include "core/error.h"
#include "patchdb/candidates.h"
#include "patchdb/patch_quality.h"
#include "patchdb/rectify.h"
#include "patchdb/source_view.h"

namespace orient {
namespace {

constexpr int kDistinctnessTemplate = 31;  // px a side
constexpr int kDistinctnessSearch = 24;    // px in every direction
constexpr double kHeightMarginPx = 2;      // heights reach that far beyond the chip
constexpr double kDefaultDemSigma = 0.1;   // of the DEM's cell
constexpr int kGsdSamples = 7;             // a side, over the source

struct Job {
  const Raster& raster;
  const SourceView& source;
  const GroundSurface& surface;
  const HarvestOptions& options;
  int bits = 8;
  double gsd_m = 0;
  double dem_sigma_m = 0;
};

double LevelsOf8Bit(double levels, int bits) { return bits == 8 ? levels : levels * 4; }

Image Surroundings(const Raster& raster, const Eigen::Vector2d& pixel) {
  constexpr int kHalf = kDistinctnessTemplate / 2 + kDistinctnessSearch;
  const Eigen::Vector2i middle = pixel.array().floor().cast<int>();
  return raster.ReadGrey({middle.x() - kHalf, middle.y() - kHalf, 2 * kHalf + 1, 2 * kHalf + 1})
      .image;
}

// Grey values and everything measured on them.
std::optional<Refusal> AddChip(const Job& job, const InterestCandidate& candidate, Patch& patch) {
  auto chip = RectifyChip(job.raster, job.source, patch.heights, patch.ground_m,
                          job.options.chip_px, patch.gsd_m);
  if (!chip || std::any_of(chip->values.begin(), chip->values.end(),
                           [](float value) { return std::isnan(value); }))
    return Refusal::kNoImage;
  patch.chip = std::move(*chip);
  if (Contrast(patch.chip) < LevelsOf8Bit(job.options.min_contrast, job.bits))
    return Refusal::kFlat;
  patch.distinctness =
      Distinctness(Surroundings(job.raster, candidate.pixel), kDistinctnessTemplate);
  if (!patch.distinctness) return Refusal::kFlat;
  if (*patch.distinctness < job.options.min_distinctness) return Refusal::kRepetitive;
  patch.persistence = Persistence(patch.chip);
  if (*patch.persistence < job.options.min_persistence) return Refusal::kShortLived;
  return std::nullopt;
}

std::variant<Patch, Refusal> MakePatch(const Job& job, const InterestCandidate& candidate) {
  Patch patch;
  patch.ground_m = candidate.ground_m;
  patch.bits = job.bits;
  patch.roundness = candidate.roundness;
  const auto gsd = GsdAt(job.source, candidate.ground_m);
  if (!gsd) return Refusal::kNoImage;
  patch.gsd_m = *gsd;
  patch.heights = CutHeights(job.surface, candidate.ground_m.head<2>(),
                             (0.5 * job.options.chip_px + kHeightMarginPx) * *gsd, *gsd);
  const double spread = HeightSpread(patch.heights);
  if (std::isnan(spread)) return Refusal::kNoHeight;
  patch.relief_px = spread / *gsd;
  if (*patch.relief_px > job.options.max_relief_px) return Refusal::kRelief;
  const auto covariance = GroundCovariance(job.source, patch.heights, patch.ground_m,
                                           job.options.pointing_sigma_px, job.dem_sigma_m);
  if (!covariance) return Refusal::kRelief;
  patch.covariance_m2 = *covariance;
  patch.height_effect = job.source.HeightEffect(patch.ground_m);
  patch.height_sigma_m = job.dem_sigma_m;
  if (const auto refusal = AddChip(job, candidate, patch)) return *refusal;
  return patch;
}

// Patches of neighbouring cells may not meet at their common border.
bool TooClose(const std::map<CellIndex, Eigen::Vector2d>& taken, const CellIndex& index,
              const Eigen::Vector3d& ground_m, double min_distance_m) {
  for (std::int64_t row = index.first - 1; row <= index.first; ++row)
    for (std::int64_t col = index.second - 1; col <= index.second + 1; ++col) {
      const auto other = taken.find({row, col});
      if (other != taken.end() && (other->second - ground_m.head<2>()).norm() < min_distance_m)
        return true;
    }
  return false;
}

void CutPatches(const Job& job, const CandidateGrid& grid, double cell_m,
                const HarvestProgress& progress, HarvestResult& result) {
  std::map<CellIndex, Eigen::Vector2d> taken;
  int done = 0;
  for (const auto& [index, candidates] : grid.cells) {
    for (const InterestCandidate& candidate : candidates) {
      if (TooClose(taken, index, candidate.ground_m, 0.5 * cell_m)) continue;
      auto made = MakePatch(job, candidate);
      if (const auto* refusal = std::get_if<Refusal>(&made)) {
        ++result.refused[static_cast<std::size_t>(*refusal)];
        continue;
      }
      taken[index] = candidate.ground_m.head<2>();
      result.patches.push_back(std::move(std::get<Patch>(made)));
      break;
    }
    if (progress) progress("cutting patches", ++done, static_cast<int>(grid.cells.size()));
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
  std::nth_element(gsds.begin(), gsds.begin() + static_cast<std::ptrdiff_t>(gsds.size() / 2),
                   gsds.end());
  return gsds[gsds.size() / 2];
}

int StoredBits(const Raster& raster) {
  if (raster.BitsPerSample() > 16)
    throw InputError(
        raster.Path() + " has " + std::to_string(raster.BitsPerSample()) +
        " bits a sample; convert it to 8 or 16 bit (gdal_translate -ot UInt16 -scale)");
  return raster.BitsPerSample() > 8 ? 16 : 8;
}

double CellSpacing(const Raster& raster, const HarvestOptions& options) {
  if (options.spacing_px) return *options.spacing_px;
  const double area = static_cast<double>(raster.Width()) * raster.Height();
  return std::max(options.min_spacing_px, std::sqrt(area / options.max_count));
}

HarvestResult Harvest(const Raster& raster, const SourceView& source, const GroundSurface& surface,
                      const HarvestOptions& options, const HarvestProgress& progress) {
  Job job{raster, source, surface, options, StoredBits(raster), MedianGsd(raster, source), 0};
  job.dem_sigma_m = options.dem_sigma_m.value_or(kDefaultDemSigma * surface.CellSize());
  const double cell_m = CellSpacing(raster, options) * job.gsd_m;
  const auto tiles = [&progress](int done, int total) {
    if (progress) progress("searching tiles", done, total);
  };
  const CandidateGrid grid = FindInterestCandidates(raster, source, cell_m, options.tries_per_cell,
                                                    options.tile_px, tiles);
  HarvestResult result;
  result.gsd_m = job.gsd_m;
  result.candidates = grid.count;
  result.cells = static_cast<int>(grid.cells.size());
  CutPatches(job, grid, cell_m, progress, result);
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
      break;
  }
  return "lost in the pyramid";
}

std::optional<std::string> HarvestOptions::Check() const {
  if (chip_px < 15 || chip_px > 501 || chip_px % 2 == 0)
    return "the chip's side must be an odd number of pixels from 15 to 501";
  if (spacing_px && !(*spacing_px >= 1)) return "the spacing must be at least 1 pixel";
  if (max_count < 1) return "the number of patches must be positive";
  if (!(min_spacing_px >= 1)) return "the smallest spacing must be at least 1 pixel";
  if (tries_per_cell < 1 || tile_px < 64) return "tries a cell and tile size must be positive";
  if (!(orientation_sigma_px > 0) || !(pointing_sigma_px > 0) ||
      (dem_sigma_m && !(*dem_sigma_m > 0)))
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
                           const HarvestProgress& progress) {
  RequireGood(options);
  const auto source = MakePhotoSource(view, pose_covariance, options.orientation_sigma_px, surface);
  return Harvest(photo, *source, surface, options, progress);
}

HarvestResult HarvestOrtho(const Raster& ortho, const Crs& ground_crs, const GroundSurface& surface,
                           const HarvestOptions& options, const HarvestProgress& progress) {
  RequireGood(options);
  const auto source = MakeOrthoSource(ortho, ground_crs, options.orientation_sigma_px, surface);
  return Harvest(ortho, *source, surface, options, progress);
}

}  // namespace orient

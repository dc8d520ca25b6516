#include "patchdb/harvest/patch_making.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "patchdb/harvest/corrected_view.h"
#include "patchdb/harvest/patch_quality.h"
#include "patchdb/harvest/place.h"
#include "patchdb/harvest/rectify.h"
#include "patchdb/harvest/undeclared_void.h"

namespace orient::patchdb {
namespace {

constexpr double kMinContrast = 2;    // standard deviation, in levels of 8 bit
constexpr double kMaxRelief_px = 60;  // height spread in chip pixels: about 45 degrees of slope
constexpr double kPointingSigma_px = 0.1;  // of an interest point
constexpr double kMaxHeightTest = 3.3;     // normal deviate: 1 in 1000 by chance
// 13.8: rejects one good patch in 992
const double kMaxSightingTest = ChiSquareLimit(2, 1.00778542904851e-3);
constexpr int kDistinctnessTemplate = 31;               // px per side
constexpr int kDistinctnessSearch = 24;                 // px in every direction
constexpr double kHeightMarginPx = 2;                   // heights reach that far beyond the chip
constexpr double kMaxVoid = 0.003;                      // share of the chip, not declared as nodata
constexpr double kMinSearchPx = 20, kMaxSearchPx = 24;  // enough to find a displaced roof
constexpr double kSearchSigmas = 3.5;
constexpr double kSearchMarginPx = 2;

using Outcome = std::optional<Refusal>;

// Files of 16 bits often hold no more than 10, of which a limit for all 16 would refuse the
// texture.
double LevelsOf8Bit(double levels, int bits) { return bits == 8 ? levels : levels * 4; }

Image Surroundings(const Raster& raster, const Eigen::Vector2d& pixel) {
  constexpr int kHalf = kDistinctnessTemplate / 2 + kDistinctnessSearch;
  const Eigen::Vector2i middle = pixel.array().floor().cast<int>();
  return raster.ReadGrey({middle.x() - kHalf, middle.y() - kHalf, 2 * kHalf + 1, 2 * kHalf + 1})
      .image;
}

HeightGrid HeightsUnder(const PatchMaker& maker, const Patch& patch, double side_px) {
  return CutHeights(maker.surface, patch.ground_m.head<2>(),
                    (0.5 * side_px + kHeightMarginPx) * patch.gsd_m, patch.gsd_m);
}

// Whether part of the ground under the patch's heights lies outside the image: a surface may end
// where its source does.
bool ReachesBeyondImage(const PatchMaker& maker, const Patch& patch) {
  const double half_m = 0.5 * (patch.heights.size - 1) * patch.heights.step_m;
  const Raster& raster = maker.raster;
  for (const double east : {-half_m, half_m})
    for (const double north : {-half_m, half_m}) {
      const auto pixel =
          maker.source.PixelFromGround(patch.ground_m + Eigen::Vector3d(east, north, 0));
      if (!pixel || !(pixel->minCoeff() >= 0 && pixel->x() <= raster.Width() &&
                      pixel->y() <= raster.Height()))
        return true;
    }
  return false;
}

Outcome AddGround(const PatchMaker& maker, const InterestCandidate& candidate, Patch& patch) {
  patch.ground_m = candidate.ground_m;
  const auto gsd = GsdAt(maker.source, candidate.ground_m);
  if (!gsd) return Refusal::kNoImage;
  patch.gsd_m = *gsd;
  patch.heights = HeightsUnder(maker, patch, maker.options.chip_px);
  const double spread = HeightSpread(patch.heights);
  if (std::isnan(spread))
    return ReachesBeyondImage(maker, patch) ? Refusal::kNoImage : Refusal::kNoHeight;
  patch.relief_px = spread / *gsd;
  if (*patch.relief_px > kMaxRelief_px) return Refusal::kRelief;
  return std::nullopt;
}

// The chip's middle shows the candidate, wherever the source's orientation projects ground_m: a
// point that several sources determine together does not lie on the candidate's own ray.
Outcome AddChip(const PatchMaker& maker, const InterestCandidate& candidate, Patch& patch) {
  const auto view = CorrectedView::ThatShows(maker.source, patch.ground_m, candidate.pixel);
  if (!view) return Refusal::kNoImage;
  auto chip = RectifyChip(maker.raster, *view, patch.heights, patch.ground_m, maker.options.chip_px,
                          patch.gsd_m);
  if (!chip || std::any_of(chip->values.begin(), chip->values.end(),
                           [](float value) { return std::isnan(value); }))
    return Refusal::kNoImage;
  if (ShareNearEnds(*chip, maker.raster.BitsPerSample()) > kMaxVoid &&
      VoidShare(maker.raster, *view, patch.heights, patch.ground_m, maker.options.chip_px,
                patch.gsd_m) > kMaxVoid)
    return Refusal::kNoImage;
  RequireNoSign(*chip, maker.raster, *view, patch.heights, patch.ground_m, patch.gsd_m);
  patch.chip = std::move(*chip);
  return std::nullopt;
}

void AddColour(const PatchMaker& maker, const InterestCandidate& candidate, Patch& patch) {
  const auto view = CorrectedView::ThatShows(maker.source, patch.ground_m, candidate.pixel);
  if (!view || maker.colour == nullptr) return;
  patch.colour = RectifyColour(*maker.colour, maker.raster, *view, patch.heights, patch.ground_m,
                               maker.options.chip_px, patch.gsd_m);
}

// Adds the measures of texture, taken from grey values.
Outcome AddTexture(const PatchMaker& maker, const InterestCandidate& candidate, Patch& patch) {
  const HarvestOptions& options = maker.options;
  if (Contrast(patch.chip) < LevelsOf8Bit(kMinContrast, maker.bits)) return Refusal::kFlat;
  patch.roundness = candidate.roundness;
  patch.energy = TextureEnergy(patch.chip);
  patch.persistence = Persistence(patch.chip);
  if (*patch.persistence < options.min_persistence) return Refusal::kShortLived;
  const auto second =
      FindSecondPeak(Surroundings(maker.raster, candidate.pixel), kDistinctnessTemplate);
  if (!second) return Refusal::kFlat;
  patch.distinctness = second->Distinctness();
  patch.second_peak_px = second->distance_px;
  if (*patch.distinctness < options.min_distinctness) return Refusal::kRepetitive;
  return std::nullopt;
}

// The further sources that show the whole chip, the best ones first.
std::vector<const FurtherSource*> WhoElseSees(const PatchMaker& maker, const Patch& patch) {
  std::vector<std::pair<double, const FurtherSource*>> seeing;
  for (const FurtherSource& source : maker.context.further)
    if (const auto penalty = ViewingPenalty(source, patch.ground_m, patch.chip.width))
      seeing.emplace_back(*penalty, &source);
  std::stable_sort(seeing.begin(), seeing.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const FurtherSource*> sources;
  for (const auto& [penalty, source] : seeing) {
    if (static_cast<int>(sources.size()) == maker.options.max_further_views) break;
    sources.push_back(source);
  }
  return sources;
}

// How far from the expected place another source may show the point, by orientation and height.
double SearchRadius(const PatchMaker& maker, const FurtherSource& other, const Patch& patch) {
  const Eigen::Vector3d& ground = patch.ground_m;
  const double lean =
      (maker.source.HeightEffect(ground) - other.view->HeightEffect(ground)).head<2>().norm();
  const double height_px = maker.dem_sigma_m * lean / patch.gsd_m;
  const double variance = 0.5 * maker.source.OrientationCovariance(ground).trace() +
                          0.5 * other.view->OrientationCovariance(ground).trace() +
                          height_px * height_px;
  return std::clamp(kSearchSigmas * std::sqrt(variance) + kSearchMarginPx, kMinSearchPx,
                    kMaxSearchPx);
}

struct Sightings {
  std::vector<Sighting> all;                  // the first is the source's own
  std::vector<const FurtherSource*> further;  // of all the others
};

Outcome Search(const PatchMaker& maker, const InterestCandidate& candidate, const Patch& patch,
               Sightings& sightings) {
  const double pointing = kPointingSigma_px;
  sightings.all = {
      {&maker.source, candidate.pixel, Eigen::Matrix2d::Identity() * (pointing * pointing)}};
  const auto seeing = WhoElseSees(maker, patch);
  if (seeing.empty()) return std::nullopt;
  Patch wide = patch;
  wide.heights = HeightsUnder(maker, patch, patch.chip.width + 2 * kMaxSearchPx);
  for (const FurtherSource* source : seeing) {
    MatchOptions options;
    options.radius_px = SearchRadius(maker, *source, patch);
    const auto sighting = FindIn(*source, wide, options);
    if (!sighting) continue;
    sightings.all.push_back(*sighting);
    sightings.further.push_back(source);
  }
  if (2 * sightings.further.size() < seeing.size()) return Refusal::kNotConfirmed;
  return std::nullopt;
}

// The ground point determined by all sightings and the surface together.
Outcome Locate(const PatchMaker& maker, const InterestCandidate& candidate,
               const Sightings& sightings, Patch& patch) {
  const auto place = EstimatePlace(sightings.all, patch.heights, patch.ground_m, maker.dem_sigma_m);
  if (!place) return Refusal::kRelief;
  if (std::abs(place->height_test) > kMaxHeightTest) return Refusal::kOtherHeight;
  if (place->sighting_test > kMaxSightingTest) return Refusal::kDisagreement;
  patch.covariance_m2 = place->covariance_m2;
  patch.height_effect = place->height_effect;
  patch.height_sigma_m = maker.dem_sigma_m;
  patch.views = static_cast<int>(sightings.all.size());
  for (std::size_t i = 0; i < sightings.further.size(); ++i)
    patch.evidence.push_back(
        {sightings.further[i]->number, sightings.all[i + 1].pixel, place->residuals_px[i + 1]});
  if (sightings.further.empty()) return std::nullopt;
  // The chip's middle shows this point; the heights around it are shifted with it.
  patch.ground_m = place->ground_m;
  patch.heights = HeightsUnder(maker, patch, maker.options.chip_px);
  const auto rise = static_cast<float>(patch.ground_m.z() - patch.heights.At(0, 0));
  for (float& height : patch.heights.heights_m) height += rise;
  if (std::isnan(HeightSpread(patch.heights))) return Refusal::kNoHeight;
  return AddChip(maker, candidate, patch);
}

Outcome CompareWithSurfaceModel(const PatchMaker& maker, Patch& patch) {
  if (maker.context.dsm == nullptr) return std::nullopt;
  patch.lean_px = LeanOf(*maker.context.dsm, maker.source, patch);
  if (patch.lean_px && *patch.lean_px > maker.options.max_lean_px) return Refusal::kStanding;
  return std::nullopt;
}

}  // namespace

int StoredBits(const Raster& raster) {
  if (raster.BitsPerSample() > 16)
    throw InputError(fmt::format(
        "{} has {} bits per sample; convert it to 8 or 16 bit (gdal_translate -ot UInt16 -scale)",
        raster.Path(), raster.BitsPerSample()));
  return raster.BitsPerSample() > 8 ? 16 : 8;
}

bool PatchMaker::ShowsBest(const Eigen::Vector3d& ground_m) const {
  if (context.further.empty()) return true;
  const FurtherSource itself{&raster, &source, nullptr, context.number};
  const auto own = ViewingPenalty(itself, ground_m, options.chip_px);
  if (!own) return false;
  return std::all_of(
      context.further.begin(), context.further.end(), [&](const FurtherSource& other) {
        const auto penalty = ViewingPenalty(other, ground_m, options.chip_px);
        return !penalty || *own < *penalty || (*own == *penalty && context.number < other.number);
      });
}

std::variant<Patch, Refusal> PatchMaker::Make(const InterestCandidate& candidate) const {
  Patch patch;
  patch.bits = bits;
  if (const Outcome refusal = AddGround(*this, candidate, patch)) return *refusal;
  if (const Outcome refusal = AddChip(*this, candidate, patch)) return *refusal;
  if (const Outcome refusal = CompareWithSurfaceModel(*this, patch)) return *refusal;
  if (const Outcome refusal = AddTexture(*this, candidate, patch)) return *refusal;
  Sightings sightings;
  if (const Outcome refusal = Search(*this, candidate, patch, sightings)) return *refusal;
  if (const Outcome refusal = Locate(*this, candidate, sightings, patch)) return *refusal;
  patch.quality = QualityOf(patch);
  AddColour(*this, candidate, patch);
  return patch;
}

}  // namespace orient::patchdb

#include "patchdb/harvest/control_points.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/chi_square.h"
#include "patchdb/harvest/corrected_view.h"
#include "patchdb/harvest/patch_making.h"
#include "patchdb/harvest/patch_quality.h"
#include "patchdb/harvest/rectify.h"

namespace orient::patchdb {
namespace {

constexpr double kPointingPx = 0.5;  // sigma of a measurement by hand
const double kMaxContradiction = ChiSquareLimit(2, 1.00778542904851e-3);  // 13.8, as for patches
constexpr double kHeightMarginPx = 2;
constexpr int kSurroundings = 79, kTemplate = 31;  // px per side, of the autocorrelation

// A sighting with its residual and penalty under the orientation.
struct Judged {
  const ControlSighting* sighting;
  Eigen::Vector2d residual_px;  // measured - computed
  double penalty;               // ViewingPenalty
};

bool Contradicts(const ControlPoint& point, const SourceView& view,
                 const Eigen::Vector2d& residual_px) {
  const auto by_ground = PixelDerivatives(view, point.ground_m, 1.0);
  if (!by_ground) return true;
  const Eigen::Matrix3d ground = point.sigma_m.cwiseAbs2().asDiagonal();
  const Eigen::Matrix2d covariance = view.OrientationCovariance(point.ground_m) +
                                     *by_ground * ground * by_ground->transpose() +
                                     Eigen::Matrix2d::Identity() * (kPointingPx * kPointingPx);
  return residual_px.dot(covariance.inverse() * residual_px) > kMaxContradiction;
}

bool IsWhole(const Image& chip) {
  return std::none_of(chip.values.begin(), chip.values.end(),
                      [](float value) { return std::isnan(value); });
}

bool AddChip(const Judged& judged, const GroundSurface& surface, int chip_px, Patch* patch,
             ControlRefusal* why) {
  const FurtherSource& source = *judged.sighting->source;
  const auto gsd = GsdAt(*source.view, patch->ground_m);
  *why = ControlRefusal::kNoImage;
  if (!gsd) return false;
  patch->gsd_m = *gsd;
  patch->heights = CutHeights(surface, patch->ground_m.head<2>(),
                              (0.5 * chip_px + kHeightMarginPx) * *gsd, *gsd);
  const double spread = HeightSpread(patch->heights);
  *why = ControlRefusal::kNoHeight;
  if (std::isnan(spread)) return false;
  patch->relief_px = spread / *gsd;
  const auto rise = static_cast<float>(patch->ground_m.z() - patch->heights.At(0, 0));
  for (float& height : patch->heights.heights_m) height += rise;
  *why = ControlRefusal::kNoImage;
  const CorrectedView view(*source.view, judged.residual_px);
  auto chip = RectifyChip(*source.raster, view, patch->heights, patch->ground_m, chip_px, *gsd);
  if (!chip || !IsWhole(*chip)) return false;
  RequireNoSign(*chip, *source.raster, view, patch->heights, patch->ground_m, *gsd);
  patch->chip = std::move(*chip);
  patch->bits = StoredBits(*source.raster);
  return true;
}

void AddTexture(const Judged& judged, Patch* patch) {
  patch->energy = TextureEnergy(patch->chip);
  patch->persistence = Persistence(patch->chip);
  const Eigen::Vector2i middle = judged.sighting->pixel.array().floor().cast<int>();
  const int half = kSurroundings / 2;
  const ImageWindow around = judged.sighting->source->raster->ReadGrey(
      {middle.x() - half, middle.y() - half, kSurroundings, kSurroundings});
  const auto second = FindSecondPeak(around.image, kTemplate);
  patch->distinctness = second ? second->Distinctness() : 0;
  if (second) patch->second_peak_px = second->distance_px;
}

}  // namespace

std::string_view Name(ControlRefusal refusal) {
  switch (refusal) {
    case ControlRefusal::kNoHeight:
      return "no height";
    case ControlRefusal::kNoImage:
      return "image border or nodata";
    case ControlRefusal::kContradicted:
      break;
  }
  return "contradicts the orientation";
}

std::variant<Patch, ControlRefusal> MakeControlPatch(const ControlPoint& point,
                                                     const std::vector<ControlSighting>& sightings,
                                                     const GroundSurface& surface, int chip_px) {
  std::vector<Judged> judged;
  for (const ControlSighting& sighting : sightings) {
    const auto computed = sighting.source->view->PixelFromGround(point.ground_m);
    if (!computed) return ControlRefusal::kContradicted;
    const Eigen::Vector2d residual = sighting.pixel - *computed;
    if (Contradicts(point, *sighting.source->view, residual)) return ControlRefusal::kContradicted;
    if (const auto penalty = ViewingPenalty(*sighting.source, point.ground_m, chip_px))
      judged.push_back({&sighting, residual, *penalty});
  }
  std::stable_sort(judged.begin(), judged.end(),
                   [](const Judged& a, const Judged& b) { return a.penalty < b.penalty; });
  ControlRefusal why = ControlRefusal::kNoImage;
  for (std::size_t best = 0; best < judged.size(); ++best) {
    Patch patch;
    patch.ground_m = point.ground_m;
    patch.covariance_m2 = point.sigma_m.cwiseAbs2().asDiagonal();
    if (!AddChip(judged[best], surface, chip_px, &patch, &why)) continue;
    AddTexture(judged[best], &patch);
    for (std::size_t i = 0; i < judged.size(); ++i)
      if (i != best)
        patch.evidence.push_back(
            {judged[i].sighting->source->number, judged[i].sighting->pixel, judged[i].residual_px});
    patch.quality = QualityOf(patch);
    return patch;
  }
  return why;
}

}  // namespace orient::patchdb

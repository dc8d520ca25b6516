#include "block/roll/clicked_scale.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/median.h"
#include "interior/constellation/clicked_film.h"

namespace orient::block {
namespace {

using Eigen::Matrix2d;

// Linear part of the transform from scan pixels to photo mm, from the stated positions.
Matrix2d ByPositions(const ClickedScan& scan, const NewCameraOptions& options) {
  constexpr double kLargest_mm = 3;  // a print curls by millimetres
  std::vector<PointPair2d> pairs;
  std::vector<std::string> names;
  for (const StatedPosition& stated : options.positions)
    if (const auto* click = interior::ClickOn(scan.clicks, stated.mark)) {
      pairs.push_back({click->pixel, stated.position_mm});
      names.push_back(stated.mark);
    }
  if (pairs.size() < 3)
    throw InputError(
        fmt::format("photo {} has {} clicked marks with stated positions; three are "
                    "needed on every scan",
                    scan.photo, pairs.size()));
  // Rows count downwards: the transform from the scan of an unmirrored film has a negative
  // determinant.
  const auto upright = FitSimilarity(pairs, true), mirrored = FitSimilarity(pairs, false);
  if (!upright || !mirrored)
    throw InputError(fmt::format("photo {}: the clicked marks lie at one place", scan.photo));
  const bool fits_mirrored = mirrored->sigma0 < 0.2 * upright->sigma0;
  if (fits_mirrored && !IsMirrored(options.orientation))
    throw InputError(
        fmt::format("photo {}: the clicks fit the stated positions only if mirrored. Are two marks "
                    "confused? If the scan is mirrored, give --orientation m0",
                    scan.photo));
  const TransformFit& fit = fits_mirrored ? *mirrored : *upright;
  size_t worst = 0;
  for (size_t i = 0; i < pairs.size(); ++i)
    if (fit.residuals[i].norm() > fit.residuals[worst].norm()) worst = i;
  if (fit.residuals[worst].norm() > kLargest_mm)
    throw InputError(
        fmt::format("photo {}: the clicks contradict the stated positions; mark {} is "
                    "{:.1f} mm off. Are two marks confused?",
                    scan.photo, names[worst], fit.residuals[worst].norm()));
  return fit.transform.A;
}

// Millimetres per pixel, from the stated distances.
std::optional<double> PixelByDistances(const ClickedScan& scan,
                                       const std::vector<StatedDistance>& distances) {
  constexpr double kLargestDeviation = 0.05;  // prints shrink by up to 2.5 % in one direction
  std::vector<double> sizes;
  std::vector<const StatedDistance*> stated;
  for (const StatedDistance& d : distances) {
    const auto *from = interior::ClickOn(scan.clicks, d.from),
               *to = interior::ClickOn(scan.clicks, d.to);
    if (from == nullptr || to == nullptr) continue;
    const double length_px = (to->pixel - from->pixel).norm();
    if (!(length_px > 1))
      throw InputError(fmt::format("photo {}: marks {} and {} are clicked at one place", scan.photo,
                                   d.from, d.to));
    sizes.push_back(d.distance_mm / length_px);
    stated.push_back(&d);
  }
  if (sizes.empty()) return std::nullopt;
  const double median = Median(sizes);
  for (size_t i = 0; i < sizes.size(); ++i)
    if (std::abs(sizes[i] / median - 1) > kLargestDeviation)
      throw InputError(fmt::format(
          "photo {}: the distance from {} to {}, {:.3f} mm, contradicts the others by {:.0f} %: "
          "mistyped, or marks confused?",
          scan.photo, stated[i]->from, stated[i]->to, stated[i]->distance_mm,
          100 * std::abs(sizes[i] / median - 1)));
  return median;
}

}  // namespace

ClickedScale ScaleOf(const ClickedScan& scan, const NewCameraOptions& options) {
  if (!options.positions.empty()) return {ByPositions(scan, options), "stated positions"};
  ClickedScale scale;
  std::optional<double> pixel_mm = PixelByDistances(scan, options.distances);
  scale.from = "stated distances";
  if (!pixel_mm && options.pixel_size_um) {
    pixel_mm = *options.pixel_size_um / 1000;
    scale.from = "--pixel-size-um";
  }
  if (const auto dpi = scan.raster.DpiTag(); !pixel_mm && dpi) {
    pixel_mm = 25.4 / *dpi;
    scale.from = "the resolution tag";
  }
  if (!pixel_mm)
    throw InputError(scan.photo +
                     ": nothing fixes the scale; give --positions, --distances or "
                     "--pixel-size-um");
  scale.mm_from_pixel = *pixel_mm * PhotoFromPixelAxes(options.orientation);
  return scale;
}

}  // namespace orient::block

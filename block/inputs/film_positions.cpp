#include "block/inputs/film_positions.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "block/inputs/photo_interior.h"
#include "interior/interior.h"

namespace orient::block {
namespace {

// Degrees of freedom that the prior knowledge of aerial film counts for: as many as the residuals
// of four marks have.
constexpr double kFilmDegreesOfFreedom = 2;

// What inexact mark positions of camera files, and the marks' measurement, leave as residuals: such
// residuals are no deformation of the film.
constexpr double kOfMarks_mm = 0.010;

double PooledVariance(const TransformFit& fit, double prior_sigma) {
  return (fit.redundancy * fit.sigma0 * fit.sigma0 +
          kFilmDegreesOfFreedom * prior_sigma * prior_sigma) /
         (fit.redundancy + kFilmDegreesOfFreedom);
}

// With a reseau, what it leaves: by how much its crosses, each left out in turn, miss their
// prediction beyond their own noise, but at least half that noise, which the prediction contains.
double SigmaBetweenCrosses_mm(const ReseauResult& reseau) {
  const double noise = reseau.noise_um, left_out = reseau.left_out_rms_um;
  return 1e-3 *
         std::sqrt(std::max(0.5 * left_out * left_out - noise * noise, 0.25 * noise * noise));
}

std::optional<TransformFit> FitOf(const InteriorResult& result, const CameraFile& camera) {
  std::vector<PointPair2d> pairs;
  for (const MarkResult& mark : result.marks)
    for (const Fiducial& fiducial : camera.fiducials)
      if (mark.state == MarkState::kUsed && mark.pixel && fiducial.id == mark.id)
        pairs.push_back({*mark.pixel, fiducial.position_mm});
  return FitAffine(pairs);
}

exterior::FilmPosition PositionOf(const InteriorResult& result, const CameraFile& camera) {
  const auto fit = FitOf(result, camera);
  exterior::FilmPosition position;
  position.photo_from_pixel = *result.photo_from_pixel;
  position.orientation = result.orientation;
  position.covariance = fit ? PooledCovariance(*fit, kFilmSigma_mm) : Matrix6d::Zero();
  position.film_sigma_mm = result.reseau ? SigmaBetweenCrosses_mm(*result.reseau)
                           : fit         ? FilmSigma_mm(*fit, kFilmSigma_mm, 1)
                                         : kFilmSigma_mm;
  position.film_correction = CorrectionOf(result);
  return position;
}

}  // namespace

Matrix6d PooledCovariance(const TransformFit& fit, double prior_sigma) {
  // FitAffine scales with its own sigma0 where it has one, which may be next to nothing.
  const double own = fit.redundancy > 0 ? fit.sigma0 * fit.sigma0 : 1.0;
  return fit.covariance *
         (PooledVariance(fit, prior_sigma) / std::max(own, std::numeric_limits<double>::min()));
}

double FilmSigma_mm(const TransformFit& fit, double prior_sigma, double unit_mm) {
  const double residual_mm2 =
      (PooledVariance(fit, prior_sigma) - prior_sigma * prior_sigma) * unit_mm * unit_mm;
  return std::sqrt(kFilmSigma_mm * kFilmSigma_mm +
                   std::max(residual_mm2 - kOfMarks_mm * kOfMarks_mm, 0.0));
}

std::vector<exterior::FilmPosition> FilmPositions(const InteriorResult& result,
                                                  const CameraFile& camera,
                                                  const interior::MarkShapes& marks) {
  std::vector<exterior::FilmPosition> positions;
  for (const ScanOrientation orientation : result.possible_orientations)
    if (const auto turned = interior::InOrientation(result, camera, marks, orientation)) {
      positions.push_back(PositionOf(*turned, camera));
      positions.back().orientation = orientation;
    }
  if (positions.empty()) positions.push_back(PositionOf(result, camera));
  return positions;
}

}  // namespace orient::block

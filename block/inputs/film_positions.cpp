#include "block/inputs/film_positions.h"

#include <algorithm>
#include <cmath>

#include "block/inputs/photo_interior.h"
#include "interior/interior.h"

namespace orient::block {
namespace {

// Degrees of freedom that the prior knowledge of aerial film counts for: as many as the residuals
// of four marks have.
constexpr double kFilmDegreesOfFreedom = 2;

// Sigma of the film's smooth deformation between the marks. With a reseau, what it leaves: by how
// much its crosses, each left out in turn, miss their prediction beyond their own noise, but at
// least half that noise, which the prediction contains.
double FilmSigma(const InteriorResult& result) {
  if (!result.reseau) return kFilmSigma_mm;
  const double noise = result.reseau->noise_um, left_out = result.reseau->left_out_rms_um;
  return 1e-3 *
         std::sqrt(std::max(0.5 * left_out * left_out - noise * noise, 0.25 * noise * noise));
}

Matrix6d InteriorCovariance(const InteriorResult& result, const CameraFile& camera) {
  std::vector<PointPair2d> pairs;
  for (const MarkResult& mark : result.marks)
    for (const Fiducial& fiducial : camera.fiducials)
      if (mark.state == MarkState::kUsed && mark.pixel && fiducial.id == mark.id)
        pairs.push_back({*mark.pixel, fiducial.position_mm});
  const auto fit = FitAffine(pairs);
  return fit ? PooledCovariance(*fit, kFilmSigma_mm) : Matrix6d::Zero();
}

}  // namespace

Matrix6d PooledCovariance(const TransformFit& fit, double prior_sigma) {
  // FitAffine scales with its own sigma0 where it has one.
  const double own = fit.redundancy > 0 ? fit.sigma0 * fit.sigma0 : 1.0;
  const double variance = (fit.redundancy * fit.sigma0 * fit.sigma0 +
                           kFilmDegreesOfFreedom * prior_sigma * prior_sigma) /
                          (fit.redundancy + kFilmDegreesOfFreedom);
  return fit.covariance * (variance / std::max(own, 1e-20));
}

std::vector<exterior::FilmPosition> FilmPositions(const InteriorResult& result,
                                                  const CameraFile& camera,
                                                  const interior::MarkShapes& marks) {
  const auto position = [&](const InteriorResult& turned) {
    return exterior::FilmPosition{*turned.photo_from_pixel, turned.orientation,
                                  InteriorCovariance(turned, camera), FilmSigma(turned),
                                  CorrectionOf(turned)};
  };
  std::vector<exterior::FilmPosition> positions;
  for (const ScanOrientation orientation : result.possible_orientations)
    if (const auto turned = interior::InOrientation(result, camera, marks, orientation)) {
      positions.push_back(position(*turned));
      positions.back().orientation = orientation;
    }
  if (positions.empty()) positions.push_back(position(result));
  return positions;
}

}  // namespace orient::block

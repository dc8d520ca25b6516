#include "tools/scan_geometry.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/files/results.h"
#include "tools/interior_run.h"
#include "tools/photo_interior.h"

namespace orient {
namespace {

// What fiducial marks tell of the film between them: with four marks their residuals have but two
// degrees of freedom, so they are taken together with what aerial film is known to do.
constexpr double kFilmSigma_mm = 0.003;
constexpr double kFilmDegreesOfFreedom = 2;

// Of the film's smooth deformation between the marks. What a reseau leaves of it: by how much its
// crosses, each left out, miss their prediction beyond their own noise, and no less than half that
// noise, with which the prediction is made.
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
  if (!fit) return Matrix6d::Zero();
  // FitAffine scales with its own sigma0 where it has one.
  const double own = fit->redundancy > 0 ? fit->sigma0 * fit->sigma0 : 1.0;
  const double variance = (fit->redundancy * fit->sigma0 * fit->sigma0 +
                           kFilmDegreesOfFreedom * kFilmSigma_mm * kFilmSigma_mm) /
                          (fit->redundancy + kFilmDegreesOfFreedom);
  return fit->covariance * (variance / std::max(own, 1e-20));
}

}  // namespace

ScanGeometry DigitalGeometry(const Camera& camera, const Raster& raster) {
  ScanGeometry interior;
  interior.positions.push_back(
      {PhotoInteriorOf(raster, camera, "").photo_from_pixel, std::nullopt, Matrix6d::Zero(), 0});
  return interior;
}

ScanGeometry FilmGeometry(const CameraFile& camera, const MarkShapes& marks, const Raster& scan,
                          const std::string& path) {
  ScanGeometry interior;
  const InteriorResult result = ReadInteriorResult(path);
  if (result.status == Status::kFailed || !result.photo_from_pixel) {
    interior.failure = "its interior orientation failed";
    for (const std::string& message : result.messages) interior.failure += ": " + message;
    return interior;
  }
  if (result.width != scan.Width() || result.height != scan.Height()) {
    interior.failure = path + " is of a scan of " + std::to_string(result.width) + " x " +
                       std::to_string(result.height) + " px, " + scan.Path() + " has " +
                       std::to_string(scan.Width()) + " x " + std::to_string(scan.Height()) +
                       "; run 'orient interior' again";
    return interior;
  }
  interior.weak = result.status == Status::kWeak;
  if (interior.weak) interior.messages.emplace_back("interior orientation is weak");
  interior.negative = result.polarity == Polarity::kNegative;
  for (const ScanOrientation orientation : result.possible_orientations)
    if (const auto turned = InOrientation(result, camera, marks, orientation))
      interior.positions.push_back({*turned->photo_from_pixel, orientation,
                                    InteriorCovariance(*turned, camera), FilmSigma(*turned),
                                    CorrectionOf(*turned)});
  if (interior.positions.empty())
    interior.positions.push_back({*result.photo_from_pixel, result.orientation,
                                  InteriorCovariance(result, camera), FilmSigma(result),
                                  CorrectionOf(result)});
  return interior;
}

}  // namespace orient

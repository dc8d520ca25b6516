// What people measured and decided (core/measurements) as the stages take it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/inputs.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/measurements/measurements.h"
#include "exterior/search/point_resection.h"
#include "interior/constellation/interior_options.h"

namespace orient::block {

// Ids of the camera's marks, as its file names them.
std::vector<std::string> MarkIds(const CameraFile& camera);

// Throws InputError naming the photo, a mark that was measured in it and that its camera does not
// have, and the marks that the camera has.
void RequireKnownMarks(const Measurements& measurements, const std::string& photo,
                       const CameraFile& camera);

// Photo names of scans, from their paths.
std::vector<std::string> PhotoNames(const std::vector<std::string>& paths);

// Measurements and decisions that no photo of the run takes (a misspelt name), with the names that
// were perhaps meant; absent: there are none.
std::optional<Finding> UnknownPhotos(const Measurements& measurements,
                                     const std::vector<std::string>& photos);

// The run's options with what was said of this photo: its clicked marks, and how it lies.
interior::InteriorOptions WithMarksOf(const Measurements& measurements, const std::string& photo,
                                      interior::InteriorOptions options);

// Accuracy of approximations that no table states (SigmaOfApproximation).
struct AssumedAccuracy {
  std::optional<double> position_m = {}, attitude_rad = {}, kappa_rad = {};
};

// Of a photo taken on a flight of known height.
struct ExpectedHeight {
  double z_m = 0, sigma_m = 0;
};

// Replaces positions in `rows` by those that a person decided for the photos; height, angles
// and their accuracy stay the row's. A photo without a row gets unknown angles and the height
// from `height_at` at its position, or the rows' median height with their spread as sigma. Throws
// InputError naming the photo where there is neither.
void ApplyDecidedPositions(
    const Measurements& measurements, const std::vector<std::string>& photos,
    const AssumedAccuracy& accuracy,
    const std::function<std::optional<ExpectedHeight>(const Eigen::Vector2d&)>& height_at,
    std::vector<OrientationRow>* rows);

// The photo's measured points whose ground coordinates are known. What was measured in the photo
// system is carried to the scan by `position`.
std::vector<exterior::MeasuredPoint> PointsOf(const Measurements& measurements,
                                              const std::string& photo,
                                              const exterior::FilmPosition& position);

// Adds "measurements", where there are any for the photo: results of others stay current.
void AddMeasurements(const std::string& text, Inputs* inputs);

// Accepted: what made the result weak allows ok. Rejected: it failed, and has neither transform nor
// pose. Both say who decided it. A failed result cannot be accepted.
void ApplyVerdict(const Measurements& measurements, InteriorResult* result);
void ApplyVerdict(const Measurements& measurements, ExteriorResult* result);

}  // namespace orient::block

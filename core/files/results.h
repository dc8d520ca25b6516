// What the stages say about one photo, and the JSON files that hold it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/files/finding.h"
#include "core/files/inputs.h"
#include "core/geometry/bounds.h"
#include "core/geometry/film_correction.h"
#include "core/geometry/pose.h"
#include "core/geometry/transform2d.h"

namespace orient {

enum class Polarity { kPositive, kNegative };
enum class MarkState { kUsed, kRejected, kMissing };
enum class PatchState { kMatched, kNotFound, kRejected, kNotVisible };

std::string_view Name(Polarity polarity);  // "positive", "negative"
std::string_view Name(MarkState state);    // "used", "rejected", "missing"
std::string_view Name(PatchState state);   // "matched", "not_found", "rejected", "not_visible"

// A window of the scan, pixels; around marks expected near its edge it may reach beyond the scan.
struct SearchedWindow {
  int col = 0, row = 0, width = 0, height = 0;
};

struct MarkResult {
  std::string id;
  MarkState state = MarkState::kMissing;
  std::optional<Eigen::Vector2d> pixel;  // absent for a missing mark
  std::optional<Eigen::Vector2d> sigma_px;
  std::optional<Eigen::Vector2d> residual_um;  // photo system, measured - computed
  std::optional<double> score;                 // NCC
  // Of a mark that is not used: where the transform expects it, and where it was looked for.
  std::optional<Eigen::Vector2d> expected = {};
  std::optional<SearchedWindow> window = {};
};

inline constexpr const char* kByMarkPositions = "mark positions";

// What one symbol, the data strip, a feature of the border or the marks' calibrated positions say
// of the scan orientation.
struct OrientationEvidence {
  std::string by;  // "symbol of mark 3", "data strip", "border 1", kByMarkPositions
  std::vector<std::pair<ScanOrientation, double>> nats;  // all 0: could not be read
};

// A reseau's crosses as a local correction: photo = photo_from_pixel * pixel + correction.
struct ReseauResult {
  FilmCorrection correction;
  int crosses = 0;             // that it rests on
  double noise_um = 0;         // of a cross's coordinate
  double left_out_rms_um = 0;  // of crosses predicted by the others, vectors
};

struct InteriorResult {
  std::string photo;
  Status status = Status::kFailed;
  // What the status was before the comparison with the other photos of the roll made it weak;
  // absent where that changed nothing.
  std::optional<Status> status_alone;
  int width = 0, height = 0;
  std::optional<double> pixel_size_um;
  std::optional<Polarity> polarity;
  std::optional<ScanOrientation> orientation;  // null while still open
  // What the marks leave open, the likeliest first; photo_from_pixel and the marks' ids are those
  // of the first. One element where the orientation is known, none when failed.
  std::vector<ScanOrientation> possible_orientations;
  // Log odds in nats of each of them (or of orientations_alone, if the roll decided) against the
  // likeliest one, hence 0 or negative; empty if nothing was looked for.
  std::vector<double> orientation_nats;
  std::vector<OrientationEvidence> orientation_evidence;  // empty where nothing was looked for
  // What the photo alone leaves open; empty where the other photos of the roll changed nothing.
  std::vector<ScanOrientation> orientations_alone;
  std::optional<Affine2d> photo_from_pixel;  // absent when failed
  std::optional<ReseauResult> reseau;        // absent without a reseau
  std::optional<double> sigma0_um;
  std::optional<double> margin;  // nats to the second-best assignment
  std::vector<MarkResult> marks;
  std::vector<std::string> cameras;  // the library's cameras that fit; empty where one was named
  Inputs made_from;                  // camera, options, scan; empty: not said
  Findings findings;  // why the status is what it is, and what else a person should know
};

struct LoopRound {
  int searched = 0;
  int matched = 0;
  double window_px = 0;
  double rms_px = 0;
  int reduction = 1;  // at which patches were matched: side of its pixels, in pixels of the scan
};

struct PatchResult {
  std::int64_t id = 0;
  std::optional<std::int64_t> source;  // of the patch database
  PatchState state = PatchState::kNotVisible;
  std::optional<Eigen::Vector3d> ground_m;  // of the patch
  std::optional<Eigen::Vector2d> predicted;
  std::optional<Eigen::Vector2d> pixel;
  std::optional<Eigen::Vector2d> sigma_px;
  std::optional<Eigen::Vector2d> residual_px;
  std::optional<double> ncc;
  Findings findings;  // why it was not matched, or is not used
};

// What a photo's own orientation was, where the block adjustment has changed it.
struct AloneResult {
  Status status = Status::kFailed;
  std::optional<Pose> pose;
  std::optional<Matrix6d> covariance;
  std::optional<double> sigma0_px;
  Findings findings;  // why the status is what it is, and what else a person should know
};

// A photo's sightings of tie points in the block adjustment.
struct TieCount {
  int measured = 0, used = 0;
  std::optional<double> rms_px;  // of the used ones' residuals
};

// Principal distance estimated with a photo's pose. Cannot be separated from the film's scale.
struct EstimatedPrincipalDistance {
  double value_mm = 0, sigma_mm = 0;
  double prior_mm = 0, prior_sigma_mm = 0;
};

// With what one-sigma uncertainty, of one coordinate, a pose projects ground points into the frame,
// where that is largest: in pixels of the scan, and in metres on level ground.
struct ProjectionSigma {
  double px = 0, m = 0;
};

// Where the orientation of a photo started: its approximation or the pose by its ground points.
struct StartingPose {
  Pose pose;
  Vector6d sigma = Vector6d::Zero();  // x y z, omega phi kappa; metres, radians; pi: unknown
};

struct ExteriorResult {
  std::string photo;
  Status status = Status::kFailed;
  int width = 0, height = 0;  // of the scan
  std::optional<Pose> pose;
  std::optional<Matrix6d> covariance;
  std::optional<StartingPose> approximation;
  std::optional<double> sigma0_px;                  // of one coordinate of a match, not of the pose
  std::optional<ProjectionSigma> projection_sigma;  // absent where it is unbounded or not known
  std::optional<double> target_m;              // accuracy on the ground that the status refers to
  std::optional<ScanOrientation> orientation;  // the scan orientation used
  std::optional<EstimatedPrincipalDistance> principal_distance;
  std::vector<Eigen::Vector3d> footprint_m;  // the frame's outline on the ground, closed ring
  std::vector<LoopRound> iterations;
  std::vector<PatchResult> patches;
  std::optional<AloneResult> alone;  // absent where the photo was oriented by itself only
  std::optional<TieCount> ties;
  Findings findings;  // why the status is what it is, and what else a person should know
  // In a stage's folder; a block's final results, made anew by every run, say none of it.
  Inputs made_from;                // camera, dem, scan, approximation ...; empty: not said
  std::optional<double> earth_k1;  // curvature and refraction that the run added to the lens
  std::optional<Bounds> asked_of_neighbours;  // ground area for which their patches were requested
};

// Takes back the pose and what follows from it; matches and findings stay.
void WithdrawPose(ExteriorResult* result);

// <directory>/<photo>.interior.json and .exterior.json, written beside and renamed. Reading throws
// InputError naming the file and the field.
void WriteInteriorResult(const std::string& directory, const InteriorResult& result);
void WriteExteriorResult(const std::string& directory, const ExteriorResult& result);
InteriorResult ReadInteriorResult(const std::string& path);
ExteriorResult ReadExteriorResult(const std::string& path);
std::string InteriorResultPath(const std::string& directory, const std::string& photo);
std::string ExteriorResultPath(const std::string& directory, const std::string& photo);
// All of a folder's interior results, sorted. Throws InputError where it cannot be listed.
std::vector<std::string> InteriorResultPaths(const std::string& directory);

}  // namespace orient

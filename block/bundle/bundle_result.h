// What a bundle block adjustment gives: poses, ground points, the state of every observation,
// tests, and precision.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/files/finding.h"
#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace orient::block {

enum class ObservationState {
  kUsed,
  kRejected,   // gross error found by snooping
  kHeldOut,    // of a check patch
  kAlone,      // its point has no second ray and no control
  kWeakAngle,  // the remaining rays of its point intersect at almost no angle
  kUnusable,   // behind the camera, or its photo takes no part
};
const char* Name(ObservationState state);

struct ObservationResult {
  ObservationState state = ObservationState::kUnusable;
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();  // measured - computed
  double w = 0;           // length of the residual over its standard deviation (chi, 1 or 2 d.o.f.)
  double redundancy = 0;  // r of its two coordinates together, 0..2; 0: no error of it would show
};

enum class PhotoState {
  kAdjusted,
  kNoDatum,       // its part has too little control and prior for position, attitude and scale
  kUndetermined,  // too few or poorly distributed observations
};
const char* Name(PhotoState state);

struct AdjustedPhoto {
  PhotoState state = PhotoState::kUndetermined;
  Pose pose;  // the approximation where it is not adjusted
  Matrix6d covariance = Matrix6d::Zero();
  int part = 0;                                    // index into BlockResult::parts
  int observations = 0;                            // used
  std::optional<Eigen::Vector3d> gnss_residual_m;  // measured - computed
  double gnss_w = 0, prior_w = 0;  // as w of an observation: chi of 3 and of 6 degrees of freedom
  bool gnss_rejected = false, prior_rejected = false;
  // Correction of the film's transform: d(a11 a12 a21 a22 t1 t2), mm.
  Vector6d interior_correction = Vector6d::Zero();
};

struct AdjustedPoint {
  bool adjusted = false;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  int rays = 0;  // used
  // Control: measured - computed, over its standard deviation (chi of three d.o.f.). The ground of
  // a control patch with good rays but a bad residual is rejected, and the point becomes a tie.
  Eigen::Vector3d control_residual_m = Eigen::Vector3d::Zero();
  double control_w = 0;
  bool control_rejected = false;
};

// Photos that are connected by ties or by control.
struct BlockPart {
  std::vector<std::size_t> photos;
  int control_points = 0;   // used
  bool has_datum = false;   // position, attitude and scale follow from control, GNSS and priors
  bool by_control = false;  // at least three control points not on one line
  std::optional<Finding> finding = {};  // absent if there is nothing to report
};

struct VarianceComponent {
  std::string group;       // tie image, control image, control ground, gnss, pose prior, measured
                           // image, surveyed ground, control heights
  double factor = 1;       // of the stated variances
  double redundancy = 0;   // degrees of freedom
  double sigma0_px = 0;    // image groups: of one coordinate of average stated weight
  bool estimated = false;  // false: too little redundancy, the stated variances stand
};

// Factors by which variances exceed the stated ones, for all groups of a kind, including those that
// have lost all of their observations.
struct VarianceFactors {
  double control = 1;  // the larger one of image and ground: of control that one photo sees they
                       // can hardly be told apart
  double gnss = 1, approximations = 1;
  double measured_image = 1, surveyed_ground = 1;  // by people or other programs
};

// A check patch: its ground point intersected from the photos, its image predicted.
struct CheckPatch {
  std::size_t point = 0;
  int rays = 0;
  std::optional<Eigen::Vector3d> ground_residual_m;  // control - intersected; two rays or more
  std::vector<std::size_t> observations;
  std::vector<Eigen::Vector2d> image_residuals_px;  // measured - predicted from the control
};

enum class CalibrationState { kEstimated, kInsignificant, kNotDetermined };
const char* Name(CalibrationState state);

inline constexpr const char* kPrincipalDistanceName = "principal_distance_mm";

struct CalibrationParameter {
  std::size_t camera = 0;
  std::string name;  // principal_distance_mm, principal_point_x_mm, ..._y_mm, k1, k2, k3
  double value = 0;  // to be added to the camera's; 0 where it is not estimated
  double sigma = 0;
  double t = 0;  // |value| / sigma when it was tested
  CalibrationState state = CalibrationState::kInsignificant;
};

struct StripGnss {
  std::string strip;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero(), shift_sigma_m = Eigen::Vector3d::Zero();
  // Where the model has it.
  std::optional<Eigen::Vector3d> drift_m, drift_sigma_m;
  bool of_all = false;  // the shift of all strips' positions against control, found significant
  int used = 0, observed = 0;  // positions
};

// The most photos for which a joint covariance of all poses is computed.
inline constexpr std::size_t kMostForFullCovariance = 300;

struct BlockTimings {  // wall clock, seconds
  double setup = 0, solve = 0, snooping = 0, covariance = 0;
  double ceres = 0;  // the part of solve that Ceres reports
  int solves = 0, iterations = 0;
};

// Of a block adjusted in sub-blocks (sub_blocks.h).
struct SubBlockSummary {
  int count = 0;
  int largest = 0;   // photos
  int compared = 0;  // poses of photos beside a core, each with that of the photo's own sub-block
  // Their differences, in standard deviations of the pose that counts, RMS over all six
  // elements: an overestimate of the effect of sub-blocks, as the other pose has less around it.
  double differences = 0;
};

struct BlockResult {
  // Poses, tests and what is used converged together; otherwise nothing here may be trusted.
  bool converged = false;
  std::vector<AdjustedPhoto> photos;            // as in the block
  std::vector<AdjustedPoint> points;            // as in the block
  std::vector<ObservationResult> observations;  // as in the block
  std::vector<BlockPart> parts;
  double sigma0 = 0;      // sqrt(v'Pv / redundancy) with the stated weights
  double redundancy = 0;  // degrees of freedom
  std::vector<VarianceComponent> components;
  VarianceFactors factors;
  std::vector<CheckPatch> checks;
  std::vector<Camera> cameras;  // with the calibration applied
  std::vector<CalibrationParameter> calibration;
  std::vector<StripGnss> strips;
  // Joint covariance of all adjusted poses, six rows each in the order of `covariance_photos`;
  // empty where it was not asked for or would be too large.
  Eigen::MatrixXd pose_covariance;
  std::vector<std::size_t> covariance_photos;
  std::optional<SubBlockSummary> sub_blocks;
  BlockTimings timings;
  Findings findings;  // what a person should know about the block as a whole
};

}  // namespace orient::block

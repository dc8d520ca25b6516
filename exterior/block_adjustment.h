// Bundle block adjustment: poses of all photos and ground points at once, from what the photos show
// of ties and of control, with what the result is worth. Pure: plain values in, plain values out.
//
// Robust start, then data snooping with local redundancies (Baarda 1968), variance components a
// group (Foerstner 1979, simplified), self-calibration with significance tests. Ceres solves
// (Triggs et al. 2000: Schur complement); covariances come from a sparse inverse of the reduced
// normal equations (Takahashi et al. 1973).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/gnss.h"
#include "core/geometry/photo_view.h"
#include "core/geometry/resection.h"

namespace orient {

struct BlockPhoto {
  std::string name;
  std::size_t camera = 0;  // index into BlockToAdjust::cameras
  Affine2d photo_from_pixel;
  std::shared_ptr<const FilmCorrection> film_correction = nullptr;
  Pose approximate;
  // What is known of the pose beside ties and control (the approximation with its accuracy, say);
  // never the result of patches that are control here: they would count twice.
  std::optional<PosePrior> prior;
  std::optional<GnssPosition> gnss;
  std::string strip;  // photos with the same name share shift and drift of GNSS
  // Covariance of photo_from_pixel (a11 a12 a21 a22 t1 t2; mm), zero for digital cameras.
  Matrix6d interior = Matrix6d::Zero();
  // Film that bends between its marks: one sigma in the photo. Zero for digital cameras.
  double film_sigma_mm = 0;
};

// What is known of a point on the ground: a control patch.
struct GroundControl {
  Eigen::Vector3d ground_m;
  Eigen::Matrix3d covariance_m2;  // of this point alone
  // How the point moves for each metre by which the heights under its source are wrong, and how
  // wrong they may be (one sigma): an error that neighbours of one source share. Zero: none.
  Eigen::Vector3d height_effect = Eigen::Vector3d::Zero();
  double height_sigma_m = 0;
  std::string source;  // patches of one source share height errors
};

// A tie (no control) or a control patch.
struct BlockPoint {
  std::int64_t id = 0;                           // the caller's
  std::optional<Eigen::Vector3d> approximate_m;  // intersected from the photos where absent
  std::optional<GroundControl> control;
  bool held_out = false;  // control that only checks: nothing of it enters the adjustment
};

struct ImageObservation {
  std::size_t photo = 0, point = 0;  // indices
  Eigen::Vector2d pixel;             // scan, measured
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();
};

struct BlockToAdjust {
  std::vector<Camera> cameras;
  std::vector<BlockPhoto> photos;
  std::vector<BlockPoint> points;
  std::vector<ImageObservation> observations;
};

struct BlockOptions {
  bool robust_start = true;  // Huber, then Cauchy, before the first test
  bool snooping = true;
  double significance = 0.001;  // of the test for gross errors: Baarda's alpha
  // Scale the groups' weights by what their residuals say; false: weights as given.
  bool variance_components = true;
  // In covariances a stated variance is never taken for less than this share of itself: 1 where
  // residuals cannot show all errors, because neighbouring observations share some. Weights and
  // tests go by what the residuals show all the same: else gross errors would pass.
  double least_precision_factor = 1e-4;
  // Lens k1 k2 k3, principal point and principal distance, one set a camera: what the block
  // determines and what is significant.
  bool self_calibration = false;
  double calibration_t = 3;  // |value| / sigma from which a parameter is significant
  GnssModel gnss = GnssModel::kPlain;
  double gnss_shift_sigma_m = 10;     // what a shift may be, one sigma
  double gnss_drift_sigma_m = 1;      // from a strip's middle to its ends
  double height_correlation_m = 500;  // distance at which height errors are hardly related
  // Errors that control patches share and residuals do not show (shadows and crowns to the same
  // side of all things), in shares of what each errs by itself: the same everywhere, and a field a
  // source that fades over height_correlation_m. They widen the covariances of poses, cameras,
  // GNSS parameters and ties (not of control's own ground and of checks) and weigh nothing.
  double control_shared_everywhere = 0, control_shared_smoothly = 0;
  double min_ray_angle_deg = 1.5;  // ties seen under less from everywhere say nothing
  bool full_covariance = true;     // of all poses, where there are at most 300 photos
  int max_rounds = 30;             // of test and adjustment
  int max_iterations = 50;         // of one adjustment
  int threads = 1;
  std::optional<std::string> Check() const;  // what is wrong with the options, if anything
};

enum class ObservationState {
  kUsed,
  kRejected,   // gross error found by snooping
  kHeldOut,    // of a check patch
  kAlone,      // its point has no second ray and no control
  kWeakAngle,  // the rays left of its point meet under next to no angle
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
  kUndetermined,  // too few or too badly placed observations
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
  // What the film's transform had to give: d(a11 a12 a21 a22 t1 t2), mm.
  Vector6d interior_correction = Vector6d::Zero();
};

struct AdjustedPoint {
  bool adjusted = false;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  int rays = 0;  // used
  // Control: measured - computed, over its standard deviation (chi of three d.o.f.). The ground of
  // a control patch whose rays are good and whose residual is not is rejected and the point a tie.
  Eigen::Vector3d control_residual_m = Eigen::Vector3d::Zero();
  double control_w = 0;
  bool control_rejected = false;
};

// Photos that hang together by ties or by control.
struct BlockPart {
  std::vector<std::size_t> photos;
  int control_points = 0;   // used
  bool has_datum = false;   // position, attitude and scale follow from control, GNSS and priors
  bool by_control = false;  // at least three control points not on one line
  std::string message;      // plain words; empty where nothing is to be said
};

struct VarianceComponent {
  std::string group;       // tie image, control image, control ground, gnss, pose prior
  double factor = 1;       // of the stated variances
  double redundancy = 0;   // degrees of freedom
  double sigma0_px = 0;    // image groups: of one coordinate of average stated weight
  bool estimated = false;  // false: too little redundancy, the stated variances stand
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
};

struct BlockTimings {  // wall clock, seconds
  double setup = 0, solve = 0, snooping = 0, covariance = 0;
  double ceres = 0;  // the part of solve that Ceres reports
  int solves = 0, iterations = 0;
};

struct BlockResult {
  // Poses, tests and what is used came to rest together; otherwise nothing here may be trusted.
  bool converged = false;
  std::vector<AdjustedPhoto> photos;            // as in the block
  std::vector<AdjustedPoint> points;            // as in the block
  std::vector<ObservationResult> observations;  // as in the block
  std::vector<BlockPart> parts;
  double sigma0 = 0;      // sqrt(v'Pv / redundancy) with the stated weights
  double redundancy = 0;  // degrees of freedom
  std::vector<VarianceComponent> components;
  std::vector<CheckPatch> checks;
  std::vector<Camera> cameras;  // with the calibration applied
  std::vector<CalibrationParameter> calibration;
  std::vector<StripGnss> strips;
  // Of all adjusted poses together, six rows each in the order of `covariance_photos`; empty where
  // it was not asked for or would be too large.
  Eigen::MatrixXd pose_covariance;
  std::vector<std::size_t> covariance_photos;
  BlockTimings timings;
  std::vector<std::string> messages;  // what a person should know, in plain sentences
};

// Throws std::invalid_argument for indices that point nowhere and covariances that are none.
BlockResult AdjustBlock(const BlockToAdjust& block, const BlockOptions& options = {});

// An adjusted photo as a map between ground and scan: pose, calibrated camera, corrected film.
PhotoView AdjustedView(const BlockToAdjust& block, const BlockResult& result, std::size_t photo);

}  // namespace orient

// What a bundle block adjustment starts from: photos, points, observations, and options.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/bounds.h"
#include "core/geometry/camera.h"
#include "core/geometry/film_correction.h"
#include "core/geometry/gnss.h"
#include "core/geometry/resection.h"
#include "core/geometry/transform2d.h"

namespace orient::block {

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
  // One sigma by which the source may be displaced as a whole, and as much again towards its
  // border: see BlockOptions::control_shared_everywhere. Zero: none.
  double source_sigma_m = 0;
};

// A tie (no control) or a control patch.
struct BlockPoint {
  std::int64_t id = 0;                           // the caller's
  std::optional<Eigen::Vector3d> approximate_m;  // intersected from the photos where absent
  std::optional<GroundControl> control;
  bool held_out = false;  // control that only checks: nothing of it enters the adjustment
  // Measured by a person or another program, the ground point by survey: groups of their own, and
  // none of the errors that patches share.
  bool by_hand = false;
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

  // Throws std::invalid_argument for indices out of range.
  void CheckIndices() const;
  // Of an observation as stated, the film's bending included; photo system, mm^2.
  Eigen::Matrix2d ImageCovariance(std::size_t observation) const;
};

struct BlockOptions {
  bool robust_start = true;  // Huber, then Cauchy, before the first test
  bool snooping = true;
  double significance = 0.001;  // of the test for gross errors: Baarda's alpha
  // Scale the groups' weights by what their residuals say; false: weights as given.
  bool variance_components = true;
  // In covariances a stated variance is never reduced below this fraction: 1 where residuals cannot
  // show all errors, because neighbouring observations share some. Weights and tests follow the
  // residuals all the same: otherwise gross errors would pass.
  double least_precision_factor = 1e-4;
  // Lens k1 k2 k3, principal point and principal distance, one set per camera: what the block
  // determines and what is significant.
  bool self_calibration = false;
  GnssModel gnss = GnssModel::kPlain;
  double gnss_shift_sigma_m = 10;     // what a shift may be, one sigma
  double height_correlation_m = 500;  // correlation length of height errors
  // Errors that control patches share and residuals do not show (shadows and crowns on the same
  // side of every object), as fractions of each patch's own error: the same everywhere, and a field
  // per source with correlation length height_correlation_m. They enlarge the covariances of poses,
  // cameras, GNSS parameters and ties (not of control's own ground and of checks) and do not affect
  // weights.
  double control_shared_everywhere = 0, control_shared_smoothly = 0;
  // The ground that each source's control covers, where that is more than this block shows.
  std::map<std::string, Bounds> source_areas;
  bool full_covariance = true;  // of all poses, where there are at most 300 photos
  int max_rounds = 30;          // of test and adjustment
  int max_iterations = 50;      // of one adjustment
  int threads = 1;
  // Larger blocks are adjusted in sub-blocks: see sub_blocks.h, and not AdjustBlock.
  std::size_t most_photos = 10'000;
  std::optional<std::string> Check() const;  // what is wrong with the options, if anything
};

}  // namespace orient::block

// The equations of a block: unknowns, rows, and which of them count at the moment. Private to
// block.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"
#include "block/bundle/costs.h"
#include "core/geometry/collinearity.h"

namespace orient::block {

// Groups of variance components.
enum class RowKind {
  kTieImage,
  kControlImage,
  kControlGround,
  kGnss,
  kPosePrior,
  kMeasuredImage,
  kSurveyedGround,
  kControlHeight,  // what the heights of a source, or of a cell of it, have in common
  kParameter
};
inline constexpr std::size_t kVarianceGroups = 8;  // all but the last

inline bool IsImage(RowKind kind) {
  return kind == RowKind::kTieImage || kind == RowKind::kControlImage ||
         kind == RowKind::kMeasuredImage;
}
// Unknowns with a prior: no gross errors.
inline bool IsUnknown(RowKind kind) {
  return kind == RowKind::kControlHeight || kind == RowKind::kParameter;
}
inline bool IsGround(RowKind kind) {
  return kind == RowKind::kControlGround || kind == RowKind::kSurveyedGround;
}

// Of a point's image observations, and of its ground where it is control.
inline RowKind ImageKindOf(const BlockPoint& point) {
  if (point.by_hand) return RowKind::kMeasuredImage;
  return point.control ? RowKind::kControlImage : RowKind::kTieImage;
}
inline RowKind GroundKindOf(const BlockPoint& point) {
  return point.by_hand ? RowKind::kSurveyedGround : RowKind::kControlGround;
}

struct BlockRows {
  std::unique_ptr<ceres::CostFunction> cost;  // null: an observation that takes no part
  RowKind kind = RowKind::kTieImage;
  bool active = false;
  int point = -1;  // index into points, or none
  int group_count = 0;
  std::array<int, 3> groups = {-1, -1, -1};  // indices into groups, in the order of the cost
  std::size_t source = 0;  // the observation, point or photo it comes from; parameters: the group

  int Residuals() const { return cost->num_residuals(); }
  bool OfPose() const { return kind == RowKind::kGnss || kind == RowKind::kPosePrior; }
};

// Value and derivatives at the present unknowns: of rows that look at a point, which are two, and
// of the others, up to six (those beyond their count are zero).
struct PointRows {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 3> by_point;
  std::array<Eigen::Matrix<double, 2, 6>, 3> by_group;
};
struct OtherRows {
  int count = 0;
  Vector6d residual = Vector6d::Zero();
  std::array<Matrix6d, 3> by_group;
};

// Shift, common to all, of GNSS positions stated to have nothing but noise (GnssModel::kPlain),
// against control: an unknown until a test finds it insignificant, see gnss_shift.h.
struct CommonGnssShift {
  int group = -1;  // -1: nothing to test, for want of control or of positions
  std::size_t unknown_row = 0, zero_row = 0;  // the first while it is an unknown, then the other
};

class BlockSystem {
 public:
  BlockSystem(const BlockToAdjust& block, const BlockOptions& options);
  BlockSystem(const BlockSystem&) = delete;
  BlockSystem& operator=(const BlockSystem&) = delete;

  const BlockToAdjust& block;
  const BlockOptions& options;

  // Unknowns: differences from the first values.
  std::vector<Vector6d> groups;
  std::vector<Eigen::Vector3d> points;
  std::vector<int> pose_group, film_group;  // of each photo; -1: none
  std::vector<int> lens_group;              // of each camera; -1: none
  std::vector<int> gnss_group;              // of each photo; -1: none
  int pose_groups = 0;                      // the first ones: one per photo
  std::vector<int> prior_row, gnss_row;     // of each photo; -1: none
  CommonGnssShift common_gnss_shift;

  // The image rows come first, one an observation; then the others.
  std::vector<BlockRows> rows;
  std::vector<std::vector<std::size_t>> image_rows_of_point;
  std::vector<int> control_row_of_point;           // the first of two; -1: none
  std::array<double, kVarianceGroups + 1> weight;  // 1 / sqrt(variance factor)

  std::vector<LensUnknowns> lens;  // of each camera

  double Factor(RowKind kind) const {
    const double w = weight.at(static_cast<std::size_t>(kind));
    return 1 / (w * w);
  }
  void SetFactor(RowKind kind, double factor);
  // The variance factor used for covariances: see BlockOptions::least_precision_factor.
  double PrecisionFactor(RowKind kind) const {
    return std::max(Factor(kind), options.least_precision_factor);
  }

  bool IsActive(std::size_t row) const { return rows[row].active; }
  // Active image rows of a point.
  int Rays(std::size_t point) const;
  bool HasControl(std::size_t point) const {
    return control_row_of_point[point] >= 0 &&
           rows[static_cast<std::size_t>(control_row_of_point[point])].active;
  }
  void SetControlActive(std::size_t point, bool active);
  bool EstimatesCommonGnssShift() const {
    return common_gnss_shift.group >= 0 && rows[common_gnss_shift.unknown_row].active;
  }
  void HoldCommonGnssShift();  // at zero

  PointRows LinearisePoint(const BlockRows& row) const;
  OtherRows LineariseOther(const BlockRows& row) const;
  // Pointers to a row's unknowns in the order of its cost.
  std::array<const double*, 4> Unknowns(const BlockRows& row) const;

  Pose PoseOf(std::size_t photo) const;               // in the block's coordinates
  Pose LocalPoseOf(std::size_t photo) const;          // relative to the origin
  Eigen::Vector3d GroundOf(std::size_t point) const;  // in the block's coordinates
  Eigen::Vector3d LocalGroundOf(std::size_t point) const;
  const Eigen::Vector3d& Origin() const { return origin_; }
  // Where an observation lies in the photo system.
  const Eigen::Vector2d& PhotoMm(std::size_t observation) const { return photo_mm_[observation]; }
  Ray LocalRay(std::size_t observation, bool* valid) const;
  Eigen::Matrix2d ImageCovariance(std::size_t observation) const {
    return block.ImageCovariance(observation);
  }
  // measured - computed, corrections of film and lens included.
  Eigen::Vector2d ResidualMm(std::size_t observation) const;
  // Correction to be added to the film's transform, d(a11 a12 a21 a22 t1 t2), mm.
  Vector6d InteriorCorrection(std::size_t photo) const;
  // A new first value; the unknowns of the point become zero.
  void SetStart(std::size_t point, const Eigen::Vector3d& local_m);

 private:
  int NewGroup();
  void FindOrigin();
  void AddPhotos();
  void AddImageRows();
  void AddControlRows();
  void AddPriorRows();
  void AddGnssRows();
  void AddGnssRow(std::size_t photo, int group);
  bool ControlTestsGnss() const;
  void AddUnknownRows();
  std::size_t AddUnknownRow(std::size_t group, const Vector6d& sigma);

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  std::vector<Vector6d> sigma_of_group_;                   // of those unknowns that have a prior
  std::size_t first_height_group_ = 0, past_heights_ = 0;  // groups of heights
  std::vector<ImageOfPhoto> images_;
  std::vector<Eigen::Vector3d> start_m_;  // of each point, local
  std::vector<Eigen::Vector2d> photo_mm_;
};

}  // namespace orient::block

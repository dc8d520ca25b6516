// The normal equations of a block with the ground points eliminated, and what follows from their
// inverse: covariances, local redundancies, and the test of every observation. Private to block.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "block/bundle/equations.h"
#include "block/bundle/sparse_blocks.h"

namespace orient::block {

// Baarda's test of one observation, its two coordinates (three of control and GNSS, six of a prior)
// together.
struct RowTest {
  double t = 0;  // v' Qvv^-1 v, chi-square of `dof` where the observation is no gross error
  int dof = 0;   // 0: nothing checks it
  double redundancy = 0;  // trace of Qvv P
  double square = 0;      // v' P v
};

struct BlockTests {
  std::vector<RowTest> of_row;      // as the system's rows; control ground: of_control
  std::vector<RowTest> of_control;  // as the points
  std::vector<Eigen::Matrix3d> point_covariance;
};

class BlockNormals {
 public:
  // At the system's present unknowns. `cauchy_scale`: of the loss on image and control rows that
  // led there, 0 for none. Rejected observations of points that are still there are tested, too, as
  // if they were new.
  BlockNormals(const BlockSystem& system, double cauchy_scale);

  const BlockCholesky& cholesky() const { return *cholesky_; }
  // Points that nothing fixes in some direction, though they have rows enough: left out.
  const std::vector<std::size_t>& weak_points() const { return weak_points_; }

  // Needs equations without open unknowns.
  BlockTests Test();
  // Change of the right side of the reduced equations for each metre (X, Y, Z) by which the given
  // ground of a control point moves: six rows per group in `groups`. False: the point is left out.
  bool RightSideOfControl(std::size_t point, std::vector<int>* groups,
                          Eigen::MatrixX3d* by_ground) const;
  // By how much a point moves for each unit of its groups' unknowns: six columns per group. False
  // where the point is left out.
  bool FollowsGroups(std::size_t point, std::vector<int>* groups,
                     Eigen::Matrix3Xd* by_groups) const;
  // Of one group of unknowns.
  Matrix6d Covariance(int group) const { return cholesky_->Inverse(group, group); }

 private:
  struct PointEquations;
  struct PointInverse;
  std::optional<PointEquations> EquationsOf(std::size_t point) const;
  void AddPoint(std::size_t point, SparseBlocks* reduced);
  void TestPoint(std::size_t point, BlockTests* tests) const;
  RowTest TestControl(const PointEquations& e, const PointInverse& inverse) const;
  PointInverse InverseOf(const PointEquations& e) const;
  void TestOther(std::size_t row, BlockTests* tests) const;
  double LossWeight(double square) const;
  double LossWeight(const BlockRows& row, const OtherRows& linear) const;

  const BlockSystem& system_;
  double cauchy_scale_;
  std::vector<std::size_t> weak_points_;
  std::unique_ptr<BlockCholesky> cholesky_;
};

}  // namespace orient::block

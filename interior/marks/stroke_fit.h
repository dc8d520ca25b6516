// A stroke's straight line by least squares through the tops of its profiles.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "interior/marks/stroke_profile.h"

namespace orient::interior {

// How surely there is a stroke along the line, and not the picture's own texture.
struct StrokeEvidence {
  // Of the profiles along both arms: with their top on the line, to 0.5 of the smoothing.
  double share = 0;
  // For the arm that shows less: log-likelihood ratio of one contrast along all of it against
  // contrasts that waver about zero, neighbouring profiles telling the same.
  double nats = 0;
};

// From the line as it is predicted; `centre` is the cross's predicted centre in `plane`. `plane`
// must outlive the fit.
class StrokeFit {
 public:
  StrokeFit(const Plane& plane, const Eigen::Vector2d& centre, const Stroke& stroke);

  // False where less than half of the stroke is seen, or nothing converges.
  bool Fit(double max_shift_px);

  const Stroke& Line() const { return line_; }

  // Variance of the line's height at x (from the centre), px^2.
  double VarianceAt(double x) const;

  StrokeEvidence Evidence() const;

 private:
  double FromCentre(size_t i) const { return columns_[i] + 0.5 - centre_.x(); }
  bool IsOnArm(size_t i) const;
  void TakeProfiles();
  void Weigh(double noise);
  Eigen::Vector2d RowOf(size_t i) const;
  double Left(size_t i, const Eigen::Vector2d& move) const;
  double OffLine(size_t i) const;
  bool Solve(const std::vector<bool>& used, Eigen::Vector2d* move);
  bool WithoutOutliers();
  bool Improve(double max_shift_px);
  Eigen::Vector2d Aliasing() const;
  Eigen::Matrix2d SpreadAtLag(int lag) const;
  Eigen::Matrix2d Response() const;
  double ArmNats(bool right) const;

  const Plane& plane_;
  Eigen::Vector2d centre_;
  Stroke line_;
  std::vector<int> columns_;
  std::vector<Profile> profiles_;
  std::vector<bool> use_;
  Eigen::Matrix2d normal_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d move_ = Eigen::Vector2d::Zero();
  double step_ = 0;
  size_t used_ = 0, possible_ = 0;
};

}  // namespace orient::interior

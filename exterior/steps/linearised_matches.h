// Matches as the linear equations of a pose, neighbours averaged where there are many. Internal to
// exterior.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/terrain/photo_view.h"
#include "exterior/steps/observation.h"

namespace orient::exterior {

// Two kinds of height errors: of what the patches were cut with, and of the surface where that does
// not hold them.
constexpr std::size_t kHeightKinds = 2;
template <typename Value>
using OfHeights = std::array<Value, kHeightKinds>;

// The linearised problem about one pose; two rows (col, row) an observation.
struct Linearised {
  Eigen::MatrixXd by_unknowns;  // the pose's six, and the principal distance where it is an unknown
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_interior;
  OfHeights<Eigen::VectorXd> by_height;  // px per standard deviation of the height error
  Eigen::VectorXd residuals;             // measured - computed, px

  Linearised(Eigen::Index rows, Eigen::Index unknowns)
      : by_unknowns(Eigen::MatrixXd::Zero(rows, unknowns)),
        by_interior(Eigen::MatrixXd::Zero(rows, 6)),
        residuals(Eigen::VectorXd::Zero(rows)) {
    by_height.fill(Eigen::VectorXd::Zero(rows));
  }
};

// Single matches, and the groups of them (shared_errors.h) whose weighted means are the
// observations.
struct GroupedMatches {
  const std::vector<PatchObservation>& all;
  std::vector<std::vector<std::size_t>> groups;
  std::vector<PatchObservation> means;  // of the groups
};

GroupedMatches Group(const std::vector<PatchObservation>& all);

// Of one coordinate; what an edge leaves open does not count.
double OwnVariance(const PatchObservation& match);
// Whether this covariance, in any unit, is that of an edge: a match fixed in one direction only.
bool IsOfEdge(const Eigen::Matrix2d& covariance);
// Block-diagonal, two rows an observation: of what was measured, and of what edges leave open along
// their direction, of which no residual tells.
struct OwnCovariances {
  Eigen::MatrixXd measured, open;
};
OwnCovariances OwnCovariancesOf(const std::vector<PatchObservation>& observations);

// The equations of the means: the single matches', averaged. `unknowns`: six, or seven with the
// principal distance. Empty where a match's ground is not seen.
std::optional<Linearised> Linearise(const PhotoView& view, const GroupedMatches& matches,
                                    Eigen::Index unknowns);

}  // namespace orient::exterior

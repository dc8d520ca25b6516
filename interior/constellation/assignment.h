// Which candidate is which mark: the most probable one-to-one assignment with nulls.
//
// The marks are one rigid constellation seen through a rotation, a scale and a small affinity. All
// priors are Gaussian and the model is linear in them, so the evidence of a set of candidates is
// the product of the innovations of a Kalman filter; branch and bound over the marks finds the best
// set exactly. Everything is measured against "each of these candidates is clutter", in nats.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/chi_square.h"
#include "core/geometry/transform2d.h"

namespace orient::interior {

struct AssignmentCandidate {
  Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();  // scan axes, origin at the scan's centre
  double score_nats = 0;  // log-likelihood ratio of its score; clipped to +-1.5
  double click_nats = 0;  // what a person's click there adds; not clipped
};

struct AssignmentMark {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  // nominal, scan axes
  std::vector<AssignmentCandidate> candidates;
  double window_mm2 = 1;  // area searched: with the number of candidates, the clutter's density
};

// One sigma each.
struct ConstellationPrior {
  Eigen::Vector2d shift_mm = Eigen::Vector2d(10, 10);
  double turn_rad = 0.04;
  double scale = 0.01;
  double affinity = 0.008;  // difference of the two scales, and shear
  double point_mm = 0.12;   // what an affine leaves in a true mark, measuring noise included
  double found = 0.85;      // probability that a mark's true place is among its candidates
};

struct Assignment {
  std::vector<int> choice;  // per mark: index of its candidate, -1 for none
  double nats = 0;          // log odds against all candidates being clutter (all -1: 0)
  int Matched() const;
};

struct AssignmentAnswer {
  Assignment best;
  // The best assignment that gives some mark another candidate than `best` does, within 30 nats of
  // it; all -1 where there is none.
  Assignment second;
  // False where the search was stopped before it was complete: `best` is then the best set seen.
  bool proven = true;
};

AssignmentAnswer AssignMarks(const std::vector<AssignmentMark>& marks,
                             const ConstellationPrior& prior);

// What the search maximises, for any set: log odds against all its candidates being clutter.
double NatsOfSet(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                 const std::vector<int>& choice);

// position = transform * place: the most probable one given the prior and the chosen candidates.
Affine2d TransformOf(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                     const std::vector<int>& choice);

// How many nats the assignment of one mark adds to the rest of `choice`.
double GainOfMark(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                  const std::vector<int>& choice, int mark);

// Squared distance of the mark's candidate from the prediction of the others, in their sigmas
// (chi-square with two degrees of freedom).
double LeaveOneOutChiSquare(const std::vector<AssignmentMark>& marks,
                            const ConstellationPrior& prior, const std::vector<int>& choice,
                            int mark);

inline const double kLeaveOneOutChiSquare = ChiSquareLimit(2, 2.73944481876837e-3);  // 11.8
inline constexpr double kMinGainNats = 3.0;

// `choice` without the marks that the others contradict (leave-one-out chi-square above 11.8) or
// that are not surely marks (gain below 3 nats): one at a time, the worst first, as a bad mark
// makes good ones look bad. Stops at two.
std::vector<int> WithoutContradicted(const std::vector<AssignmentMark>& marks,
                                     const ConstellationPrior& prior, std::vector<int> choice);

// For hundreds of marks, of which a few have fixed the transform. Beginning with `trusted`, every
// other mark gets the candidate that adds most to those chosen before it, if any adds something;
// then all marks are chosen anew, each as all others together predict it.
std::vector<int> ChooseAround(const std::vector<AssignmentMark>& marks,
                              const ConstellationPrior& prior, const std::vector<int>& trusted);

}  // namespace orient::interior

#include "interior/assignment.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

constexpr double kScoreLimit = 1.5;       // nats: grey values never outvote geometry
constexpr double kFarthestSecond = 30.0;  // nats: beyond it nobody asks
constexpr double kGate = 40.0;            // chi-square of an innovation: e^-20, null is likelier

// Shift x, y, turn, scale, difference of the scales, shear.
struct State {
  Vector6 mean = Vector6::Zero();
  Matrix6 covariance = Matrix6::Zero();
};

State PriorState(const ConstellationPrior& prior) {
  Vector6 sigma;
  sigma << prior.shift_mm, prior.turn_rad, prior.scale, prior.affinity, prior.affinity;
  return {Vector6::Zero(), sigma.cwiseAbs2().asDiagonal()};
}

Matrix26 Design(const Vector2d& place) {
  const double x = place.x(), y = place.y();
  Matrix26 h;
  h << 1, 0, -y, x, 0.5 * x, 0.5 * y, 0, 1, x, y, -0.5 * y, 0.5 * x;
  return h;
}

struct Innovation {
  Matrix26 h;
  Matrix2d inverse;
  Vector2d difference;
  double chi_square = 0;
  double log_density = 0;  // per mm^2
};

Innovation Predict(const State& state, const Vector2d& place, const Vector2d& seen,
                   double point_mm) {
  Innovation result;
  result.h = Design(place);
  const Matrix2d s = result.h * state.covariance * result.h.transpose() +
                     point_mm * point_mm * Matrix2d::Identity();
  result.inverse = s.inverse();
  result.difference = seen - place - result.h * state.mean;
  result.chi_square = result.difference.dot(result.inverse * result.difference);
  result.log_density =
      -0.5 * result.chi_square - std::log(2 * std::numbers::pi) - 0.5 * std::log(s.determinant());
  return result;
}

State Update(const State& state, const Innovation& innovation) {
  const Eigen::Matrix<double, 6, 2> gain =
      state.covariance * innovation.h.transpose() * innovation.inverse;
  return {state.mean + gain * innovation.difference,
          state.covariance - gain * innovation.h * state.covariance};
}

// The part of a match's gain that does not depend on where the others lie.
double FixedGain(const AssignmentMark& mark, const AssignmentCandidate& candidate,
                 const ConstellationPrior& prior) {
  const double clutter = static_cast<double>(mark.candidates.size()) / mark.window_mm2;
  return std::log(prior.found / (1 - prior.found)) - std::log(clutter) +
         std::clamp(candidate.score_nats, -kScoreLimit, kScoreLimit);
}

class Search {
 public:
  Search(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
         const std::vector<int>* other_than, double at_least)
      : marks_(marks), prior_(prior), other_than_(other_than) {
    best_.choice.assign(marks.size(), -1);
    best_.nats = at_least;
    rest_.assign(marks.size() + 1, 0.0);
    const double peak = -std::log(2 * std::numbers::pi * prior.point_mm * prior.point_mm);
    for (size_t i = marks.size(); i-- > 0;) {
      double most = 0;
      for (const auto& c : marks[i].candidates)
        most = std::max(most, FixedGain(marks[i], c, prior) + peak);
      rest_[i] = rest_[i + 1] + most;
    }
    choice_.assign(marks.size(), -1);
    Descend(0, PriorState(prior), 0.0, false);
  }
  const Assignment& Best() const { return best_; }

 private:
  struct Branch {
    int candidate;
    double gain;
    Innovation innovation;
  };

  std::vector<Branch> Branches(size_t mark, const State& state) const {
    std::vector<Branch> branches;
    for (size_t j = 0; j < marks_[mark].candidates.size(); ++j) {
      const AssignmentCandidate& c = marks_[mark].candidates[j];
      Innovation innovation = Predict(state, marks_[mark].place_mm, c.position_mm, prior_.point_mm);
      if (innovation.chi_square > kGate) continue;
      const double gain = FixedGain(marks_[mark], c, prior_) + innovation.log_density;
      branches.push_back({static_cast<int>(j), gain, innovation});
    }
    std::sort(branches.begin(), branches.end(),
              [](const Branch& a, const Branch& b) { return a.gain > b.gain; });
    return branches;
  }

  void Descend(size_t mark, const State& state, double nats, bool differs) {
    if (nats + rest_[mark] <= best_.nats) return;
    if (mark == marks_.size()) {
      if (other_than_ == nullptr || differs) best_ = {choice_, nats};
      return;
    }
    for (const Branch& branch : Branches(mark, state)) {
      const bool conflict = other_than_ != nullptr && (*other_than_)[mark] >= 0 &&
                            (*other_than_)[mark] != branch.candidate;
      choice_[mark] = branch.candidate;
      Descend(mark + 1, Update(state, branch.innovation), nats + branch.gain, differs || conflict);
    }
    choice_[mark] = -1;
    Descend(mark + 1, state, nats, differs);
  }

  const std::vector<AssignmentMark>& marks_;
  const ConstellationPrior& prior_;
  const std::vector<int>* other_than_;
  std::vector<double> rest_;
  std::vector<int> choice_;
  Assignment best_;
};

// What is known after all matched marks but one.
State StateWithout(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                   const std::vector<int>& choice, int without) {
  State state = PriorState(prior);
  for (size_t i = 0; i < marks.size(); ++i) {
    if (choice[i] < 0 || static_cast<int>(i) == without) continue;
    state = Update(state, Predict(state, marks[i].place_mm,
                                  marks[i].candidates[choice[i]].position_mm, prior.point_mm));
  }
  return state;
}

}  // namespace

int Assignment::Matched() const {
  return static_cast<int>(
      std::count_if(choice.begin(), choice.end(), [](int c) { return c >= 0; }));
}

AssignmentAnswer AssignMarks(const std::vector<AssignmentMark>& marks,
                             const ConstellationPrior& prior) {
  AssignmentAnswer answer;
  answer.best = Search(marks, prior, nullptr, 0.0).Best();
  const double at_least = answer.best.nats - kFarthestSecond;
  answer.second = Search(marks, prior, &answer.best.choice, at_least).Best();
  return answer;
}

double GainOfMark(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                  const std::vector<int>& choice, int mark) {
  if (choice.at(mark) < 0) throw std::invalid_argument("GainOfMark: the mark is not assigned");
  const AssignmentCandidate& c = marks[mark].candidates[choice[mark]];
  const State state = StateWithout(marks, prior, choice, mark);
  return FixedGain(marks[mark], c, prior) +
         Predict(state, marks[mark].place_mm, c.position_mm, prior.point_mm).log_density;
}

double LeaveOneOutChiSquare(const std::vector<AssignmentMark>& marks,
                            const ConstellationPrior& prior, const std::vector<int>& choice,
                            int mark) {
  if (choice.at(mark) < 0)
    throw std::invalid_argument("LeaveOneOutChiSquare: the mark is not assigned");
  const AssignmentCandidate& c = marks[mark].candidates[choice[mark]];
  const State state = StateWithout(marks, prior, choice, mark);
  return Predict(state, marks[mark].place_mm, c.position_mm, prior.point_mm).chi_square;
}

}  // namespace orient

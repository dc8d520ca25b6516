#include "interior/constellation/assignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix26 = Eigen::Matrix<double, 2, 6>;

constexpr double kScoreLimit = 1.5;       // nats: grey values never outvote geometry
constexpr double kFarthestSecond = 30.0;  // nats: larger margins make no difference

// Shift x, y, rotation, scale, difference of the two scales, shear.
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

// The predicted position of a mark, with which its candidates are compared.
struct Prediction {
  Matrix26 h;
  Matrix2d inverse;        // of the innovation's covariance
  Vector2d mean;           // mm
  double log_density = 0;  // of a candidate at the mean, per mm^2
};

Prediction Predict(const State& state, const Vector2d& place, double point_mm) {
  Prediction result;
  result.h = Design(place);
  const Matrix2d s = result.h * state.covariance * result.h.transpose() +
                     point_mm * point_mm * Matrix2d::Identity();
  result.inverse = s.inverse();
  result.mean = place + result.h * state.mean;
  result.log_density = -std::log(2 * std::numbers::pi) - 0.5 * std::log(s.determinant());
  return result;
}

double ChiSquare(const Prediction& predicted, const Vector2d& seen) {
  const Vector2d difference = seen - predicted.mean;
  return difference.dot(predicted.inverse * difference);
}

State Update(const State& state, const Prediction& predicted, const Vector2d& seen) {
  const Eigen::Matrix<double, 6, 2> gain =
      state.covariance * predicted.h.transpose() * predicted.inverse;
  return {state.mean + gain * (seen - predicted.mean),
          state.covariance - gain * predicted.h * state.covariance};
}

// The part of a match's gain that does not depend on where the others lie.
double FixedGain(const AssignmentMark& mark, const AssignmentCandidate& candidate,
                 const ConstellationPrior& prior) {
  const double clutter = static_cast<double>(mark.candidates.size()) / mark.window_mm2;
  return std::log(prior.found / (1 - prior.found)) - std::log(clutter) +
         std::clamp(candidate.score_nats, -kScoreLimit, kScoreLimit) + candidate.click_nats;
}

// The state once every mark but one is matched: no prediction is ever more precise.
State NarrowestState(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                     size_t without) {
  State state = PriorState(prior);
  for (size_t i = 0; i < marks.size(); ++i)
    if (i != without && !marks[i].candidates.empty())
      state = Update(state, Predict(state, marks[i].place_mm, prior.point_mm), Vector2d::Zero());
  return state;
}

// Branch and bound. A candidate stays open below a node as long as a set with it may still beat the
// best one known: the nats so far, its own gain here, and the most that all other open marks could
// add, if each were predicted as well as all marks together allow. By the chain rule the order of
// marks does not matter, so the mark with the fewest open candidates comes next.
class Search {
 public:
  Search(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
         const std::vector<int>* other_than)
      : marks_(marks), prior_(prior), other_than_(other_than), levels_(marks.size() + 2) {
    choice_.assign(marks.size(), -1);
    best_.choice = choice_;
  }

  void Run(double at_least) {
    best_.nats = at_least;
    std::vector<OpenMark>& open = levels_[0];
    for (size_t i = 0; i < marks_.size(); ++i) {
      if (marks_[i].candidates.empty()) continue;
      OpenMark mark{static_cast<int>(i), 0, 0, {}};
      mark.peak = Predict(NarrowestState(marks_, prior_, i), marks_[i].place_mm, prior_.point_mm)
                      .log_density;
      for (size_t j = 0; j < marks_[i].candidates.size(); ++j)
        mark.candidates.push_back(
            {static_cast<int>(j), FixedGain(marks_[i], marks_[i].candidates[j], prior_), 0});
      SetMost(&mark);
      open.push_back(std::move(mark));
    }
    Descend(0, PriorState(prior_), 0.0, other_than_ == nullptr);
  }

  const Assignment& Best() const { return best_; }
  bool Proven() const { return nodes_ < kMostNodes; }

 private:
  struct OpenCandidate {
    int index;
    double fixed;
    double gain;  // in the node's state
  };
  struct OpenMark {
    int index;
    double peak;  // log-density no prediction exceeds
    double most;  // nats, the most it may ever add
    std::vector<OpenCandidate> candidates;
  };

  static void SetMost(OpenMark* mark) {
    mark->most = 0;
    for (const OpenCandidate& c : mark->candidates)
      mark->most = std::max(mark->most, c.fixed + mark->peak);
  }

  bool Conflicts(int mark, int candidate) const {
    const int other = (*other_than_)[mark];
    return other >= 0 && other != candidate;
  }

  void SetGains(const State& state, OpenMark* mark) const {
    const Prediction predicted = Predict(state, marks_[mark->index].place_mm, prior_.point_mm);
    for (OpenCandidate& c : mark->candidates)
      c.gain = c.fixed + predicted.log_density -
               0.5 * ChiSquare(predicted, marks_[mark->index].candidates[c.index].position_mm);
  }

  // Closes candidates that cannot lead to a better set. True if any was closed: the bound for the
  // others is then lower, and they may be closed, too.
  bool Close(double nats, std::vector<OpenMark>* open) const {
    double rest = 0;
    for (const OpenMark& mark : *open) rest += mark.most;
    bool closed = false;
    for (OpenMark& mark : *open) {
      rest -= mark.most;
      const double needed = best_.nats - nats - rest;
      closed = std::erase_if(mark.candidates,
                             [&](const OpenCandidate& c) { return c.gain <= needed; }) > 0 ||
               closed;
      SetMost(&mark);
      rest += mark.most;
    }
    std::erase_if(*open, [](const OpenMark& m) { return m.candidates.empty(); });
    return closed;
  }

  bool MayStillDiffer(const std::vector<OpenMark>& open) const {
    for (const OpenMark& mark : open)
      for (const OpenCandidate& c : mark.candidates)
        if (Conflicts(mark.index, c.index)) return true;
    return false;
  }

  void Record(double nats, bool differs) {
    if (differs && nats > best_.nats) best_ = {choice_, nats};
  }

  // `levels_[level]` holds the open marks, as the parent left them.
  void Descend(size_t level, const State& state, double nats, bool differs) {
    if (++nodes_ >= kMostNodes) return;
    std::vector<OpenMark>& open = levels_[level];
    Record(nats, differs);
    for (OpenMark& mark : open) SetGains(state, &mark);
    while (Close(nats, &open)) {
    }
    if (open.empty() || (!differs && !MayStillDiffer(open))) return;
    const auto next =
        std::min_element(open.begin(), open.end(), [](const OpenMark& a, const OpenMark& b) {
          if (a.candidates.size() != b.candidates.size())
            return a.candidates.size() < b.candidates.size();
          return a.most > b.most;
        });
    OpenMark mark = std::move(*next);
    open.erase(next);
    std::sort(mark.candidates.begin(), mark.candidates.end(),
              [](const OpenCandidate& a, const OpenCandidate& b) { return a.gain > b.gain; });
    const Prediction predicted = Predict(state, marks_[mark.index].place_mm, prior_.point_mm);
    for (const OpenCandidate& c : mark.candidates) {
      const Vector2d& seen = marks_[mark.index].candidates[c.index].position_mm;
      choice_[mark.index] = c.index;
      levels_[level + 1] = open;
      Descend(level + 1, Update(state, predicted, seen), nats + c.gain,
              differs || Conflicts(mark.index, c.index));
    }
    choice_[mark.index] = -1;
    levels_[level + 1] = open;
    Descend(level + 1, state, nats, differs);
  }

  static constexpr int kMostNodes = 100000;

  const std::vector<AssignmentMark>& marks_;
  const ConstellationPrior& prior_;
  const std::vector<int>* other_than_;
  std::vector<std::vector<OpenMark>> levels_;
  std::vector<int> choice_;
  Assignment best_;
  int nodes_ = 0;
};

// Index of the candidate with the largest gain for a predicted mark; -1 if no gain is positive.
int Likeliest(const AssignmentMark& mark, const ConstellationPrior& prior,
              const Prediction& predicted) {
  int best = -1;
  double most = 0;
  for (size_t j = 0; j < mark.candidates.size(); ++j) {
    const AssignmentCandidate& c = mark.candidates[j];
    const double gain = FixedGain(mark, c, prior) + predicted.log_density -
                        0.5 * ChiSquare(predicted, c.position_mm);
    if (gain <= most) continue;
    most = gain;
    best = static_cast<int>(j);
  }
  return best;
}

// The state after all matched marks but one.
State StateWithout(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                   const std::vector<int>& choice, int without) {
  State state = PriorState(prior);
  for (size_t i = 0; i < marks.size(); ++i) {
    if (choice[i] < 0 || static_cast<int>(i) == without) continue;
    state = Update(state, Predict(state, marks[i].place_mm, prior.point_mm),
                   marks[i].candidates[choice[i]].position_mm);
  }
  return state;
}

// The same for every mark in turn at the cost of one: in information form a mark's contribution is
// a term of a sum, which can be subtracted again.
class StatesWithoutOne {
 public:
  StatesWithoutOne(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                   const std::vector<int>& choice)
      : marks_(marks), choice_(choice), weight_(1 / (prior.point_mm * prior.point_mm)) {
    information_ = PriorState(prior).covariance.diagonal().cwiseInverse().asDiagonal();
    for (size_t i = 0; i < marks.size(); ++i) Add(i, weight_, &information_, &vector_);
  }

  State Without(size_t i) const {
    Matrix6 information = information_;
    Vector6 vector = vector_;
    Add(i, -weight_, &information, &vector);
    const Matrix6 covariance = information.inverse();
    return {covariance * vector, covariance};
  }

 private:
  void Add(size_t i, double weight, Matrix6* information, Vector6* vector) const {
    if (choice_[i] < 0) return;
    const Matrix26 h = Design(marks_[i].place_mm);
    *information += weight * h.transpose() * h;
    *vector += weight * h.transpose() *
               (marks_[i].candidates[choice_[i]].position_mm - marks_[i].place_mm);
  }

  const std::vector<AssignmentMark>& marks_;
  const std::vector<int>& choice_;
  double weight_;
  Matrix6 information_ = Matrix6::Zero();
  Vector6 vector_ = Vector6::Zero();
};

}  // namespace

int Assignment::Matched() const {
  return static_cast<int>(
      std::count_if(choice.begin(), choice.end(), [](int c) { return c >= 0; }));
}

AssignmentAnswer AssignMarks(const std::vector<AssignmentMark>& marks,
                             const ConstellationPrior& prior) {
  AssignmentAnswer answer;
  Search best(marks, prior, nullptr);
  best.Run(0.0);
  answer.best = best.Best();
  answer.proven = best.Proven();
  if (!answer.proven) return answer;
  Search second(marks, prior, &answer.best.choice);
  second.Run(answer.best.nats - kFarthestSecond);
  answer.second = second.Best();
  answer.proven = second.Proven();
  return answer;
}

double NatsOfSet(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                 const std::vector<int>& choice) {
  State state = PriorState(prior);
  double nats = 0;
  for (size_t i = 0; i < marks.size(); ++i) {
    if (choice.at(i) < 0) continue;
    const AssignmentCandidate& c = marks[i].candidates.at(choice[i]);
    const Prediction predicted = Predict(state, marks[i].place_mm, prior.point_mm);
    nats += FixedGain(marks[i], c, prior) + predicted.log_density -
            0.5 * ChiSquare(predicted, c.position_mm);
    state = Update(state, predicted, c.position_mm);
  }
  return nats;
}

Affine2d TransformOf(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                     const std::vector<int>& choice) {
  const State state = StateWithout(marks, prior, choice, -1);
  Affine2d transform;
  transform.t = Design(Vector2d::Zero()) * state.mean;
  for (int axis = 0; axis < 2; ++axis)
    transform.A.col(axis) += Design(Vector2d::Unit(axis)) * state.mean - transform.t;
  return transform;
}

double GainOfMark(const std::vector<AssignmentMark>& marks, const ConstellationPrior& prior,
                  const std::vector<int>& choice, int mark) {
  if (choice.at(mark) < 0) throw std::invalid_argument("GainOfMark: the mark is not assigned");
  const AssignmentCandidate& c = marks[mark].candidates[choice[mark]];
  const Prediction predicted =
      Predict(StateWithout(marks, prior, choice, mark), marks[mark].place_mm, prior.point_mm);
  return FixedGain(marks[mark], c, prior) + predicted.log_density -
         0.5 * ChiSquare(predicted, c.position_mm);
}

double LeaveOneOutChiSquare(const std::vector<AssignmentMark>& marks,
                            const ConstellationPrior& prior, const std::vector<int>& choice,
                            int mark) {
  if (choice.at(mark) < 0)
    throw std::invalid_argument("LeaveOneOutChiSquare: the mark is not assigned");
  const State state = StateWithout(marks, prior, choice, mark);
  return ChiSquare(Predict(state, marks[mark].place_mm, prior.point_mm),
                   marks[mark].candidates[choice[mark]].position_mm);
}

std::vector<int> WithoutContradicted(const std::vector<AssignmentMark>& marks,
                                     const ConstellationPrior& prior, std::vector<int> choice) {
  while (std::count_if(choice.begin(), choice.end(), [](int c) { return c >= 0; }) > 2) {
    int worst = -1;
    double most = 1;
    for (int i = 0; i < static_cast<int>(marks.size()); ++i) {
      if (choice[i] < 0) continue;
      const double excess =
          std::max(LeaveOneOutChiSquare(marks, prior, choice, i) / kLeaveOneOutChiSquare,
                   1 + 0.1 * (kMinGainNats - GainOfMark(marks, prior, choice, i)));
      if (excess > most) {
        most = excess;
        worst = i;
      }
    }
    if (worst < 0) break;
    choice[worst] = -1;
  }
  return choice;
}

std::vector<int> ChooseAround(const std::vector<AssignmentMark>& marks,
                              const ConstellationPrior& prior, const std::vector<int>& trusted) {
  constexpr int kRounds = 2;
  std::vector<int> choice = trusted;
  State state = StateWithout(marks, prior, choice, -1);
  for (size_t i = 0; i < marks.size(); ++i) {
    if (choice[i] >= 0) continue;
    const Prediction predicted = Predict(state, marks[i].place_mm, prior.point_mm);
    choice[i] = Likeliest(marks[i], prior, predicted);
    if (choice[i] >= 0)
      state = Update(state, predicted, marks[i].candidates[choice[i]].position_mm);
  }
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<int> before = choice;
    const StatesWithoutOne states(marks, prior, before);
    for (size_t i = 0; i < marks.size(); ++i)
      choice[i] =
          Likeliest(marks[i], prior, Predict(states.Without(i), marks[i].place_mm, prior.point_mm));
  }
  return choice;
}

}  // namespace orient::interior

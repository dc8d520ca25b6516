#include "interior/constellation/softassign.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Weights = std::vector<std::vector<double>>;

constexpr double kCooling = 0.93;
constexpr double kOutlierWeight = 0.10539922456186433;  // e^-2.25: (3 sigma0)^2 / last_temperature
constexpr int kMostRounds = 30;                         // of Sinkhorn and of solves per temperature
constexpr double kSinkhornEnd = 1e-6;                   // largest change of a weight
constexpr double kTransformEnd = 1e-5;  // of the unit: largest change at a mark (the paper's)

struct Moments {
  double weight = 0;
  Vector2d place = Vector2d::Zero(), seen = Vector2d::Zero();  // weighted means
  Matrix2d place_place = Matrix2d::Zero();                     // about the means
  Matrix2d seen_place = Matrix2d::Zero();
};

Moments MomentsOf(const std::vector<SoftassignMark>& marks, const Weights& weights) {
  Moments moments;
  for (size_t i = 0; i < marks.size(); ++i)
    for (size_t a = 0; a < weights[i].size(); ++a) {
      moments.weight += weights[i][a];
      moments.place += weights[i][a] * marks[i].place;
      moments.seen += weights[i][a] * marks[i].candidates[a];
    }
  if (moments.weight <= 0) return moments;
  moments.place /= moments.weight;
  moments.seen /= moments.weight;
  for (size_t i = 0; i < marks.size(); ++i)
    for (size_t a = 0; a < weights[i].size(); ++a) {
      const Vector2d place = marks[i].place - moments.place;
      moments.place_place += weights[i][a] * place * place.transpose();
      moments.seen_place +=
          weights[i][a] * (marks[i].candidates[a] - moments.seen) * place.transpose();
    }
  return moments;
}

// The weighted least-squares transform; `previous` where the weights do not determine one.
Affine2d Solve(const std::vector<SoftassignMark>& marks, const Weights& weights,
               SoftassignModel model, const Affine2d& previous) {
  constexpr double kThinnest = 1e-6;  // marks on one line determine no affine
  const Moments m = MomentsOf(marks, weights);
  const double spread = m.place_place.trace();
  if (!(m.weight > 1e-12) || !(spread > 1e-12)) return previous;
  Affine2d solved;
  if (model == SoftassignModel::kSimilarity) {
    const double a = (m.seen_place(0, 0) + m.seen_place(1, 1)) / spread;
    const double b = (m.seen_place(1, 0) - m.seen_place(0, 1)) / spread;
    solved.A << a, -b, b, a;
  } else {
    if (m.place_place.determinant() < kThinnest * spread * spread) return previous;
    solved.A = m.seen_place * m.place_place.inverse();
  }
  solved.t = m.seen - solved.A * m.place;
  return solved;
}

Weights RawWeights(const std::vector<SoftassignMark>& marks, const Affine2d& transform,
                   double temperature) {
  Weights weights(marks.size());
  for (size_t i = 0; i < marks.size(); ++i)
    for (const Vector2d& seen : marks[i].candidates)
      weights[i].push_back(
          std::exp(-(seen - transform * marks[i].place).squaredNorm() / temperature));
  return weights;
}

void NormaliseMarks(double outlier, Weights* weights) {
  for (std::vector<double>& of_mark : *weights) {
    double sum = outlier;
    for (const double m : of_mark) sum += m;
    for (double& m : of_mark) m /= sum;
  }
}

// Marks and candidates in turn; each has an outlier that is scaled with it. A candidate is searched
// for one mark only, so that its sum has two terms.
void Sinkhorn(double outlier, Weights* weights) {
  std::vector<double> none(weights->size(), outlier);  // a mark's weight of "no candidate"
  Weights clutter;                                     // a candidate's weight of "no mark"
  for (const auto& of_mark : *weights) clutter.emplace_back(of_mark.size(), outlier);
  double change = 1;
  for (int round = 0; round < kMostRounds && change > kSinkhornEnd; ++round) {
    change = 0;
    for (size_t i = 0; i < weights->size(); ++i) {
      std::vector<double>& of_mark = (*weights)[i];
      const std::vector<double> before = of_mark;
      double sum = none[i];
      for (const double m : of_mark) sum += m;
      none[i] /= sum;
      for (size_t a = 0; a < of_mark.size(); ++a) {
        const double m = of_mark[a] / sum;
        of_mark[a] = m / (m + clutter[i][a]);
        clutter[i][a] /= m + clutter[i][a];
        change = std::max(change, std::abs(of_mark[a] - before[a]));
      }
    }
  }
}

// The largest weight of each mark, the outlier's included.
std::vector<int> CleanUp(const Weights& weights) {
  std::vector<int> choice;
  for (const std::vector<double>& of_mark : weights) {
    double most = 1;
    for (const double m : of_mark) most -= m;
    int chosen = -1;
    for (size_t a = 0; a < of_mark.size(); ++a)
      if (of_mark[a] > most) {
        most = of_mark[a];
        chosen = static_cast<int>(a);
      }
    choice.push_back(chosen);
  }
  return choice;
}

double LargestChange(const std::vector<SoftassignMark>& marks, const Affine2d& a,
                     const Affine2d& b) {
  double most = 0;
  for (const SoftassignMark& mark : marks)
    most = std::max(most, (a * mark.place - b * mark.place).norm());
  return most;
}

}  // namespace

SoftassignAnswer SoftassignAsPublished(const std::vector<SoftassignMark>& marks,
                                       const SoftassignOptions& options) {
  SoftassignAnswer answer;
  for (double t = options.first_temperature; t >= options.last_temperature; t *= kCooling) {
    answer.weights = RawWeights(marks, answer.transform, t);
    NormaliseMarks(kOutlierWeight, &answer.weights);
    if (answer.solves == 0) answer.first_weights = answer.weights;
    answer.transform = Solve(marks, answer.weights, options.model, answer.transform);
    ++answer.solves;
  }
  answer.choice = CleanUp(answer.weights);
  return answer;
}

SoftassignAnswer Softassign(const std::vector<SoftassignMark>& marks,
                            const SoftassignOptions& options) {
  SoftassignAnswer answer;
  for (double t = options.first_temperature; t >= options.last_temperature; t *= kCooling) {
    const bool last = t * kCooling < options.last_temperature;
    const SoftassignModel model = last ? options.model : SoftassignModel::kSimilarity;
    double change = 1;
    for (int round = 0; round < kMostRounds && change > kTransformEnd; ++round) {
      answer.weights = RawWeights(marks, answer.transform, t);
      Sinkhorn(kOutlierWeight, &answer.weights);
      if (answer.solves == 0) answer.first_weights = answer.weights;
      const Affine2d before = answer.transform;
      answer.transform = Solve(marks, answer.weights, model, before);
      change = LargestChange(marks, before, answer.transform);
      ++answer.solves;
    }
  }
  answer.choice = CleanUp(answer.weights);
  return answer;
}

}  // namespace orient::interior

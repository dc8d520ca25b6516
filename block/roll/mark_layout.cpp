#include "block/roll/mark_layout.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/base/median.h"
#include "core/geometry/transform2d.h"

namespace orient::block {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using Positions = std::vector<Vector2d>;

// Mark positions from the places in the scans, and each scan's similarity from position to place.
// Empty if the scans have too few marks in common.
struct Start {
  Positions position_mm;
  std::vector<Affine2d> place_from_position;
  double scale_difference = 0;  // MarkLayout::scale_difference
};

std::optional<Affine2d> PlaceFromPosition(const ScanOfMarks& scan, const Start& start,
                                          const std::vector<bool>& known) {
  std::vector<PointPair2d> pairs;
  for (size_t i = 0; i < known.size(); ++i)
    if (known[i] && scan.place_mm[i]) pairs.push_back({start.position_mm[i], *scan.place_mm[i]});
  const auto fit = FitSimilarity(pairs, false);
  return fit ? std::optional(fit->transform) : std::nullopt;
}

double ScaleOf(const Affine2d& transform) { return std::sqrt(std::abs(transform.A.determinant())); }

// The scans' own scales may be wrong, of a false resolution tag.
void TakeMedianScale(Start* start) {
  std::vector<double> scales;
  for (const Affine2d& transform : start->place_from_position) scales.push_back(ScaleOf(transform));
  const double median = UpperMedian(std::move(scales));
  for (Vector2d& position : start->position_mm) position *= median;
  for (Affine2d& transform : start->place_from_position) {
    transform.A /= median;
    start->scale_difference = std::max(start->scale_difference, std::abs(ScaleOf(transform) - 1));
  }
}

std::optional<Start> StartOf(const std::vector<ScanOfMarks>& scans) {
  const size_t marks = scans.front().place_mm.size();
  Start start{Positions(marks, Vector2d::Zero()), std::vector<Affine2d>(scans.size())};
  std::vector<bool> known(marks, false), joined(scans.size(), false);
  for (size_t round = 0; round < scans.size(); ++round) {
    for (size_t s = 0; s < scans.size(); ++s) {
      if (joined[s]) continue;
      const auto transform = round == 0 && s == 0 ? std::optional(Affine2d{})
                                                  : PlaceFromPosition(scans[s], start, known);
      if (!transform) continue;
      joined[s] = true;
      start.place_from_position[s] = *transform;
      const Affine2d back = transform->Inverse();
      for (size_t i = 0; i < marks; ++i) {
        if (known[i] || !scans[s].place_mm[i]) continue;
        start.position_mm[i] = back * *scans[s].place_mm[i];
        known[i] = true;
      }
    }
  }
  const auto all = [](const std::vector<bool>& flags) {
    return std::find(flags.begin(), flags.end(), false) == flags.end();
  };
  if (!all(known) || !all(joined)) return std::nullopt;
  TakeMedianScale(&start);
  return start;
}

// Normal equations of weighted rows.
class Equations {
 public:
  explicit Equations(Eigen::Index unknowns)
      : normal_(MatrixXd::Zero(unknowns, unknowns)), right_(VectorXd::Zero(unknowns)) {}

  using Row = std::vector<std::pair<Eigen::Index, double>>;
  // `what`: identifies an observation; none for a condition.
  void Add(const Row& row, double misclosure, double sigma,
           const std::optional<LayoutContradiction>& what = std::nullopt) {
    if (what) observations_.push_back({row, misclosure, sigma, *what});
    const double weight = 1 / (sigma * sigma);
    for (const auto& [i, a] : row) {
      right_[i] += weight * a * misclosure;
      for (const auto& [j, b] : row) normal_(i, j) += weight * a * b;
    }
  }
  // At the solution: the observation with the largest standardised residual above the limit.
  std::optional<LayoutContradiction> Worst() const {
    constexpr double kCritical = 5, kLeastRedundancy = 1e-4;
    const MatrixXd covariance = normal_.inverse();
    std::optional<LayoutContradiction> worst;
    double largest = kCritical;
    for (const Observation& o : observations_) {
      double explained = 0;
      for (const auto& [i, a] : o.row)
        for (const auto& [j, b] : o.row) explained += a * b * covariance(i, j);
      const double redundancy = 1 - explained / (o.sigma * o.sigma);
      if (redundancy < kLeastRedundancy) continue;
      const double w = std::abs(o.residual) / (o.sigma * std::sqrt(redundancy));
      if (w <= largest) continue;
      largest = w;
      worst = o.what;
      worst->off_mm = std::abs(o.residual) / redundancy;
    }
    return worst;
  }
  const MatrixXd& Normal() const { return normal_; }
  VectorXd Solution() const { return normal_.ldlt().solve(right_); }

 private:
  struct Observation {
    Row row;
    double residual, sigma;
    LayoutContradiction what;
  };
  MatrixXd normal_;
  VectorXd right_;
  std::vector<Observation> observations_;
};

// Unknowns: x and y of every mark, then of every scan a, b (A = [[a, -b], [b, a]]) and its shift.
class LayoutAdjustment {
 public:
  LayoutAdjustment(const std::vector<ScanOfMarks>& scans,
                   const std::vector<MarkDistance>& distances, double scan_sigma_mm, Start start)
      : scans_(scans),
        distances_(distances),
        scan_sigma_mm_(scan_sigma_mm),
        marks_(static_cast<Eigen::Index>(start.position_mm.size())),
        state_(std::move(start)) {}

  Equations Linearised() const {
    Equations equations(2 * marks_ + 4 * std::ssize(scans_));
    for (size_t s = 0; s < scans_.size(); ++s) AddScan(s, &equations);
    for (size_t d = 0; d < distances_.size(); ++d) AddDistance(d, &equations);
    AddDatum(&equations);
    return equations;
  }

  // Returns the largest change of a position, mm.
  double Step() {
    const VectorXd change = Linearised().Solution();
    for (Eigen::Index i = 0; i < marks_; ++i) state_.position_mm[i] += change.segment<2>(2 * i);
    for (Eigen::Index s = 0; s < std::ssize(scans_); ++s) {
      const Eigen::Vector4d c = change.segment<4>(2 * marks_ + 4 * s);
      Affine2d& transform = state_.place_from_position[s];
      transform.A += (Eigen::Matrix2d() << c[0], -c[1], c[1], c[0]).finished();
      transform.t += c.tail<2>();
    }
    return change.head(2 * marks_).cwiseAbs().maxCoeff();
  }

  double Residual(const MarkDistance& d) const {
    return d.distance_mm - (state_.position_mm[d.to] - state_.position_mm[d.from]).norm();
  }

  const Positions& position_mm() const { return state_.position_mm; }

 private:
  void AddScan(size_t s, Equations* equations) const {
    const Affine2d& transform = state_.place_from_position[s];
    const Eigen::Index at = 2 * marks_ + 4 * static_cast<Eigen::Index>(s);
    for (Eigen::Index i = 0; i < marks_; ++i) {
      if (!scans_[s].place_mm[i]) continue;
      const LayoutContradiction what{s, static_cast<size_t>(i), std::nullopt, 0};
      const Vector2d& p = state_.position_mm[i];
      const Vector2d misclosure = *scans_[s].place_mm[i] - transform * p;
      const Eigen::Matrix2d& A = transform.A;
      equations->Add(
          {{2 * i, A(0, 0)}, {2 * i + 1, A(0, 1)}, {at, p.x()}, {at + 1, -p.y()}, {at + 2, 1}},
          misclosure.x(), scan_sigma_mm_, what);
      equations->Add(
          {{2 * i, A(1, 0)}, {2 * i + 1, A(1, 1)}, {at, p.y()}, {at + 1, p.x()}, {at + 3, 1}},
          misclosure.y(), scan_sigma_mm_, what);
    }
  }

  void AddDistance(size_t index, Equations* equations) const {
    const MarkDistance& d = distances_[index];
    const Vector2d along = (state_.position_mm[d.to] - state_.position_mm[d.from]).normalized();
    const auto from = 2 * static_cast<Eigen::Index>(d.from);
    const auto to = 2 * static_cast<Eigen::Index>(d.to);
    equations->Add(
        {{from, -along.x()}, {from + 1, -along.y()}, {to, along.x()}, {to + 1, along.y()}},
        Residual(d), d.sigma_mm, LayoutContradiction{std::nullopt, std::nullopt, index, 0});
  }

  // Datum: the marks as a whole keep position, direction and, without distances, size, which the
  // observations do not determine.
  void AddDatum(Equations* equations) const {
    constexpr double kSigma_mm = 1e-5;
    Vector2d mean = Vector2d::Zero();
    for (const Vector2d& p : state_.position_mm) mean += p / static_cast<double>(marks_);
    Equations::Row x, y, direction, size;
    for (Eigen::Index i = 0; i < marks_; ++i) {
      const Vector2d r = (state_.position_mm[i] - mean) / 100;
      x.emplace_back(2 * i, 1);
      y.emplace_back(2 * i + 1, 1);
      direction.insert(direction.end(), {{2 * i, -r.y()}, {2 * i + 1, r.x()}});
      size.insert(size.end(), {{2 * i, r.x()}, {2 * i + 1, r.y()}});
    }
    for (const Equations::Row& row : {x, y, direction}) equations->Add(row, 0, kSigma_mm);
    if (distances_.empty()) equations->Add(size, 0, kSigma_mm);
  }

  const std::vector<ScanOfMarks>& scans_;
  const std::vector<MarkDistance>& distances_;
  double scan_sigma_mm_;
  Eigen::Index marks_;
  Start state_;
};

Vector2d MeanOf(const Positions& marks) {
  return std::accumulate(marks.begin(), marks.end(), Vector2d(Vector2d::Zero())) /
         static_cast<double>(marks.size());
}

double AngleOf(const Vector2d& v) { return std::atan2(v.y(), v.x()); }

// Pairs of marks that lie opposite each other, seen from `middle`; marks near it have none.
std::vector<std::pair<size_t, size_t>> Opposites(const Positions& marks, const Vector2d& middle) {
  constexpr double kNear = 0.2, kStraight = 12 * std::numbers::pi / 180;
  double largest = 0;
  for (const Vector2d& p : marks) largest = std::max(largest, (p - middle).norm());
  std::vector<std::pair<size_t, size_t>> pairs;
  for (size_t i = 0; i < marks.size(); ++i)
    for (size_t j = i + 1; j < marks.size(); ++j) {
      const Vector2d a = marks[i] - middle, b = middle - marks[j];
      if (std::min(a.norm(), b.norm()) < kNear * largest) continue;
      if (std::abs(std::remainder(AngleOf(a) - AngleOf(b), 2 * std::numbers::pi)) < kStraight)
        pairs.emplace_back(i, j);
    }
  return pairs;
}

// The middle of the marks' bounding box, which a missing mark moves little.
Vector2d MiddleOfBox(const Positions& marks) {
  Vector2d low = marks.front(), high = marks.front();
  for (const Vector2d& p : marks) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return (low + high) / 2;
}

// The middle of the longest side of three marks that stand at three corners of a rectangle; else
// empty.
std::optional<Vector2d> MiddleOfThree(const Positions& marks) {
  constexpr double kRightAngle = 0.2;  // cosine: 12 degrees off
  if (marks.size() != 3) return std::nullopt;
  for (size_t i = 0; i < 3; ++i) {
    const Vector2d &one = marks[(i + 1) % 3], &other = marks[(i + 2) % 3];
    const Vector2d a = (one - marks[i]).normalized(), b = (other - marks[i]).normalized();
    if (std::abs(a.dot(b)) < kRightAngle) return Vector2d((one + other) / 2);
  }
  return std::nullopt;
}

// Least-squares intersection of the lines between marks that lie opposite each other, seen from
// `middle`; empty if no two of them cross at a sufficient angle.
std::optional<Vector2d> MeetAbout(const Positions& marks, const Vector2d& middle) {
  constexpr double kLeastDeterminant = 0.1;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Vector2d right = Vector2d::Zero();
  for (const auto& [i, j] : Opposites(marks, middle)) {
    const Vector2d along = (marks[j] - marks[i]).normalized();
    const Vector2d across(-along.y(), along.x());
    normal += across * across.transpose();
    right += across * across.dot(marks[i]);
  }
  if (normal.determinant() < kLeastDeterminant) return std::nullopt;
  return Vector2d(normal.inverse() * right);
}

// The same starting from the centre of the marks' box, iterated from each intersection.
std::optional<Vector2d> Meet(const Positions& marks) {
  constexpr int kRounds = 3;
  if (const auto middle = MiddleOfThree(marks)) return middle;
  Vector2d middle = MiddleOfBox(marks);
  for (int round = 0; round < kRounds; ++round) {
    const auto met = MeetAbout(marks, middle);
    if (!met) return std::nullopt;
    middle = *met;
  }
  return middle;
}

// Mean rotation of the marks relative to axes and diagonals; 0 if any lies off these.
double TurnOf(const Positions& marks) {
  constexpr double kEighth = std::numbers::pi / 4, kAligned = 6 * std::numbers::pi / 180;
  double sum = 0, largest = 0;
  int count = 0;
  for (const Vector2d& p : marks) largest = std::max(largest, p.norm());
  for (const Vector2d& p : marks) {
    if (p.norm() < 0.2 * largest) continue;
    const double turn = std::remainder(AngleOf(p), kEighth);
    if (std::abs(turn) > kAligned) return 0;
    sum += turn;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

std::optional<MarkLayout> EstimateLayout(const std::vector<ScanOfMarks>& scans,
                                         const std::vector<MarkDistance>& distances,
                                         double scan_sigma_mm) {
  constexpr int kMostSteps = 50;
  constexpr double kConverged_mm = 1e-7;
  if (scans.empty() || scans.front().place_mm.size() < 3) return std::nullopt;
  auto start = StartOf(scans);
  if (!start) return std::nullopt;
  const double scale_difference = start->scale_difference;
  LayoutAdjustment adjustment(scans, distances, scan_sigma_mm, std::move(*start));
  double change = 1;
  for (int step = 0; step < kMostSteps && change > kConverged_mm; ++step)
    change = adjustment.Step();
  if (!(change <= kConverged_mm)) return std::nullopt;

  MarkLayout layout;
  layout.scale_difference = scale_difference;
  const auto meet = Meet(adjustment.position_mm());
  layout.origin_known = meet.has_value();
  const Vector2d origin = meet.value_or(MeanOf(adjustment.position_mm()));
  for (const Vector2d& p : adjustment.position_mm()) layout.position_mm.emplace_back(p - origin);
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-TurnOf(layout.position_mm)).toRotationMatrix();
  const Equations equations = adjustment.Linearised();
  const MatrixXd covariance = equations.Normal().inverse();
  layout.contradiction = equations.Worst();
  for (size_t i = 0; i < layout.position_mm.size(); ++i) {
    layout.position_mm[i] = turn * layout.position_mm[i];
    const auto at = 2 * static_cast<Eigen::Index>(i);
    layout.sigma_mm.emplace_back(
        (turn * covariance.block<2, 2>(at, at) * turn.transpose()).diagonal().cwiseSqrt());
  }
  for (const MarkDistance& d : distances)
    layout.distance_residual_mm.push_back(adjustment.Residual(d));
  return layout;
}

}  // namespace orient::block

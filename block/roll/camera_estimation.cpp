#include "block/roll/camera_estimation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/geometry/dense_solvers.h"

namespace orient::block {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// One sigma of the affinity that all scans of a photogrammetric scanner have in common.
constexpr double kCommonAffinity = 1.5e-4;
constexpr double kContradicted = 16;  // squared sigmas, two coordinates: one good mark in 3000
constexpr double kLeastNoise_mm = 1e-6;
constexpr int kFirstRounds = 15, kRounds = 4;
constexpr int kPose = 4;  // shift, rotation, scale; two more for the affinity

using Row2 = Eigen::Matrix<double, 2, 6>;

// d(position) / d(shift x, shift y, turn, scale, difference of scales, shear) at a place.
Row2 Effect(const Vector2d& p) {
  Row2 j;
  j << 1, 0, -p.y(), p.x(), 0.5 * p.x(), 0.5 * p.y(),  //
      0, 1, p.x(), p.y(), -0.5 * p.y(), 0.5 * p.x();
  return j;
}

// A mark as seen in a scan, and whether it is in use.
struct Sighting {
  size_t scan = 0;
  size_t mark = 0;
  Vector2d raw_mm = Vector2d::Zero();
  bool used = true;
};

class Adjustment {
 public:
  Adjustment(const std::vector<ScanOfMarks>& scans, const std::vector<Vector2d>& start,
             CommonAffinity common)
      : start_(start), position_(start), common_(common) {
    for (size_t s = 0; s < scans.size(); ++s) {
      if (scans[s].place_mm.size() != start.size())
        throw std::invalid_argument("EstimateCamera: scan " + scans[s].name +
                                    " does not have one place per mark");
      for (size_t i = 0; i < start.size(); ++i)
        if (scans[s].place_mm[i]) sightings_.push_back({s, i, *scans[s].place_mm[i], true});
    }
    by_scan_.resize(scans.size());
    transform_.resize(scans.size());
    for (size_t k = 0; k < sightings_.size(); ++k) by_scan_[sightings_[k].scan].push_back(k);
  }

  bool Prepare() {
    Count();
    for (size_t s = 0; s < by_scan_.size(); ++s) {
      if (Used(s).size() < 3) continue;
      Align(s);
    }
    return scans_ >= 3 && shown_.size() >= 4;
  }

  // Rejects until nothing is contradicted any more; false if too little is left.
  bool Run() {
    if (!Prepare()) return false;
    for (int rounds = kFirstRounds;; rounds = kRounds) {
      for (int round = 0; round < rounds; ++round) Solve();
      const auto worst = Worst();
      if (!worst) return true;
      sightings_[*worst].used = false;
      ++rejected_;
      Count();
      if (scans_ < 3 || shown_.size() < 4) return false;
    }
  }

  CameraEstimate Result() const {
    CameraEstimate result;
    const double infinity = std::numeric_limits<double>::infinity();
    result.position_mm = position_;
    result.sigma_mm.assign(start_.size(), Vector2d(infinity, infinity));
    result.shown = shown_;
    result.covariance_mm2 = noise_ * noise_ * cofactor_;
    if (common_ == CommonAffinity::kSmall) {
      const MatrixXd shape = Gauge(shown_, 6);
      result.covariance_mm2 += kCommonAffinity * kCommonAffinity * WithoutPose(shape.rightCols(2));
    }
    for (size_t k = 0; k < shown_.size(); ++k)
      result.sigma_mm[shown_[k]] =
          result.covariance_mm2.diagonal().segment<2>(2 * static_cast<long>(k)).cwiseSqrt();
    result.noise_um = 1e3 * noise_;
    result.affinity = affinity_;
    result.mean_difference = mean_affinity_[0];
    result.mean_shear = mean_affinity_[1];
    result.scans = scans_;
    result.measured = static_cast<int>(sightings_.size());
    result.rejected = rejected_;
    return result;
  }

 private:
  std::vector<size_t> Used(size_t scan) const {
    std::vector<size_t> used;
    for (const size_t k : by_scan_[scan])
      if (sightings_[k].used) used.push_back(k);
    return used;
  }

  // Which scans and marks take part. A mark seen once only follows its scan, and a scan with fewer
  // than three of the others tells nothing of them.
  void Count() {
    column_.assign(start_.size(), 0);
    for (bool settled = false; !settled;) {
      std::vector<int> seen(start_.size(), 0);
      scans_ = 0;
      for (size_t s = 0; s < by_scan_.size(); ++s) {
        const std::vector<size_t> used = TakingPart(s);
        scans_ += used.empty() ? 0 : 1;
        for (const size_t k : used) ++seen[sightings_[k].mark];
      }
      settled = true;
      for (size_t i = 0; i < seen.size(); ++i)
        if (column_[i] >= 0 && seen[i] < 2) {
          column_[i] = -1;
          settled = false;
        }
    }
    shown_.clear();
    for (size_t i = 0; i < column_.size(); ++i)
      if (column_[i] >= 0) {
        column_[i] = 2 * static_cast<long>(shown_.size());
        shown_.push_back(i);
      }
  }

  // The scan's sightings that take part: of shown marks, three at least.
  std::vector<size_t> TakingPart(size_t scan) const {
    std::vector<size_t> used = Used(scan);
    std::erase_if(used, [&](size_t k) { return column_[sightings_[k].mark] < 0; });
    if (used.size() < 3) used.clear();
    return used;
  }

  // A similarity onto the start positions: the linear model then holds.
  void Align(size_t scan) {
    const std::vector<size_t> used = Used(scan);
    MatrixXd j(2 * static_cast<long>(used.size()), kPose);
    VectorXd y(j.rows());
    for (size_t k = 0; k < used.size(); ++k) {
      const Sighting& seen = sightings_[used[k]];
      j.middleRows<2>(2 * static_cast<long>(k)) = Effect(seen.raw_mm).leftCols<kPose>();
      y.segment<2>(2 * static_cast<long>(k)) = start_[seen.mark] - seen.raw_mm;
    }
    VectorXd p = VectorXd::Zero(6);
    p.head<kPose>() = j.colPivHouseholderQr().solve(y);
    Move(scan, p);
  }

  struct Transform {
    Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
    Vector2d t = Vector2d::Zero();
    Vector2d affinity = Vector2d::Zero();  // all of it, since the start
  };

  // position = place + J p is itself an affine transform of the place.
  void Move(size_t scan, const VectorXd& p) {
    Eigen::Matrix2d step;
    step << 1 + p[3] + 0.5 * p[4], -p[2] + 0.5 * p[5],  //
        p[2] + 0.5 * p[5], 1 + p[3] - 0.5 * p[4];
    Transform& transform = transform_[scan];
    transform.A = step * transform.A;
    transform.t = step * transform.t + p.head<2>();
    transform.affinity += p.tail<2>();
  }

  Vector2d Placed(const Sighting& seen) const {
    return transform_[seen.scan].A * seen.raw_mm + transform_[seen.scan].t;
  }

  // Normalised columns of shift, rotation, scale (and affinity) of the whole constellation.
  MatrixXd Gauge(const std::vector<size_t>& marks, long columns) const {
    MatrixXd gauge(2 * static_cast<long>(marks.size()), columns);
    for (size_t k = 0; k < marks.size(); ++k)
      gauge.middleRows<2>(2 * static_cast<long>(k)) = Effect(start_[marks[k]]).leftCols(columns);
    return gauge;
  }

  // s s' without the part of s that a similarity absorbs.
  MatrixXd WithoutPose(const MatrixXd& s) const {
    const MatrixXd pose = Gauge(shown_, kPose);
    const MatrixXd left = s - pose * pose.colPivHouseholderQr().solve(s);
    return left * left.transpose();
  }

  long GaugeColumns() const { return common_ == CommonAffinity::kUnknown ? 6 : kPose; }

  // A scan's observations with the matrices that eliminate its own parameters.
  struct ScanPart {
    std::vector<size_t> sightings;
    MatrixXd j;        // 2k x 6
    MatrixXd inverse;  // (J'J + W)^-1
    VectorXd placed;   // 2k
  };

  ScanPart PartOf(size_t scan) const {
    ScanPart part;
    part.sightings = TakingPart(scan);
    const auto rows = 2 * static_cast<long>(part.sightings.size());
    part.j.resize(rows, 6);
    part.placed.resize(rows);
    for (size_t k = 0; k < part.sightings.size(); ++k) {
      const Vector2d place = Placed(sightings_[part.sightings[k]]);
      part.j.middleRows<2>(2 * static_cast<long>(k)) = Effect(place);
      part.placed.segment<2>(2 * static_cast<long>(k)) = place;
    }
    MatrixXd normal = part.j.transpose() * part.j;
    const double weight = AffinityWeight();
    normal(4, 4) += weight;
    normal(5, 5) += weight;
    part.inverse = SolveNormal(normal, MatrixXd::Identity(6, 6));
    return part;
  }

  // Weight of the prior that a film's own affinity is small, in units of the noise. Three marks
  // leave the affinity to the prior altogether.
  double AffinityWeight() const {
    const double ratio = noise_ / affinity_;
    return ratio * ratio;
  }

  void Solve() {
    const auto unknowns = 2 * static_cast<long>(shown_.size());
    const long gauge_columns = GaugeColumns();
    MatrixXd normal = MatrixXd::Zero(unknowns + gauge_columns, unknowns + gauge_columns);
    VectorXd right = VectorXd::Zero(unknowns + gauge_columns);
    std::vector<ScanPart> parts;
    for (size_t s = 0; s < by_scan_.size(); ++s) {
      parts.push_back(PartOf(s));
      AddScan(s, parts.back(), &normal, &right);
    }
    const MatrixXd gauge = Gauge(shown_, gauge_columns);
    const MatrixXd scaled = gauge * (gauge.colwise().norm().cwiseInverse().asDiagonal() *
                                     MatrixXd::Identity(gauge_columns, gauge_columns));
    normal.topRightCorner(unknowns, gauge_columns) = scaled;
    normal.bottomLeftCorner(gauge_columns, unknowns) = scaled.transpose();
    VectorXd start(unknowns);
    for (size_t k = 0; k < shown_.size(); ++k)
      start.segment<2>(2 * static_cast<long>(k)) = start_[shown_[k]];
    right.tail(gauge_columns) = scaled.transpose() * start;
    const MatrixXd inverse = InverseOf(normal);
    const VectorXd solution = inverse * right;
    cofactor_ = inverse.topLeftCorner(unknowns, unknowns);
    for (size_t k = 0; k < shown_.size(); ++k)
      position_[shown_[k]] = solution.segment<2>(2 * static_cast<long>(k));
    Update(parts);
  }

  // The prior applies to the scan's whole affinity, of which the parameters are only corrections.
  VectorXd PriorPull(size_t scan) const {
    VectorXd pull = VectorXd::Zero(6);
    pull.tail<2>() = -AffinityWeight() * (transform_[scan].affinity - PriorMean());
    return pull;
  }
  // An unknown common affinity is not a film's own: the prior is centred on the scans' mean.
  Vector2d PriorMean() const {
    return common_ == CommonAffinity::kUnknown ? mean_affinity_ : Vector2d::Zero();
  }

  // Minimises |m - placed - J p|^2 + W |a + p_a - mean|^2 over p: with H = (J'J + W)^-1,
  // p = H (J'(m - placed) + pull), and the residuals are linear in m.
  void AddScan(size_t scan, const ScanPart& part, MatrixXd* normal, VectorXd* right) const {
    const auto rows = part.j.rows();
    if (rows == 0) return;
    const MatrixXd free =
        MatrixXd::Identity(rows, rows) - part.j * part.inverse * part.j.transpose();
    const VectorXd constant = free * part.placed + part.j * (part.inverse * PriorPull(scan));
    for (size_t a = 0; a < part.sightings.size(); ++a) {
      const long row = column_[sightings_[part.sightings[a]].mark];
      right->segment<2>(row) += constant.segment<2>(2 * static_cast<long>(a));
      for (size_t b = 0; b < part.sightings.size(); ++b) {
        const long col = column_[sightings_[part.sightings[b]].mark];
        normal->block<2, 2>(row, col) +=
            free.block<2, 2>(2 * static_cast<long>(a), 2 * static_cast<long>(b));
      }
    }
  }

  // The scans' transforms, then noise and affinity from the residuals (expectation maximisation for
  // the affinity: its variance is that of the estimates plus their own uncertainty).
  void Update(const std::vector<ScanPart>& parts) {
    double squares = 0, affinity_squares = 0, prior_squares = 0;
    long observations = 0, scans = 0;
    Vector2d sum = Vector2d::Zero();
    const double weight = AffinityWeight();
    for (size_t s = 0; s < parts.size(); ++s) {
      const ScanPart& part = parts[s];
      if (part.sightings.empty()) continue;
      VectorXd target(part.placed.size());
      for (size_t k = 0; k < part.sightings.size(); ++k)
        target.segment<2>(2 * static_cast<long>(k)) = position_[sightings_[part.sightings[k]].mark];
      const VectorXd p =
          part.inverse * (part.j.transpose() * (target - part.placed) + PriorPull(s));
      squares += (target - part.placed - part.j * p).squaredNorm();
      Move(s, p);
      const Vector2d own = transform_[s].affinity - PriorMean();
      prior_squares += weight * own.squaredNorm();
      affinity_squares +=
          own.squaredNorm() + noise_ * noise_ * (part.inverse(4, 4) + part.inverse(5, 5));
      sum += transform_[s].affinity;
      observations += part.placed.size();
      ++scans;
    }
    // A scan's two affinities are unknowns and, by their prior, observations. What the start
    // positions fix is not an unknown; if the common affinity is, it enters as the prior's mean.
    const auto unknown = 2 * static_cast<long>(shown_.size()) - kPose;
    const double redundancy =
        std::max(1.0, static_cast<double>(observations - kPose * scans - unknown));
    noise_ = std::max(kLeastNoise_mm, std::sqrt((squares + prior_squares) / redundancy));
    affinity_ = std::max(1e-6, std::sqrt(affinity_squares / (2.0 * static_cast<double>(scans))));
    mean_affinity_ = sum / static_cast<double>(scans);
  }

  // The sighting with the largest residual relative to its precision; empty if none is too large.
  std::optional<size_t> Worst() const {
    std::optional<size_t> worst;
    double most = kContradicted;
    for (size_t s = 0; s < by_scan_.size(); ++s) {
      const ScanPart part = PartOf(s);
      const auto rows = part.j.rows();
      if (rows == 0) continue;
      const MatrixXd free =
          MatrixXd::Identity(rows, rows) - part.j * part.inverse * part.j.transpose();
      for (size_t k = 0; k < part.sightings.size(); ++k) {
        const auto at = 2 * static_cast<long>(k);
        const size_t mark = sightings_[part.sightings[k]].mark;
        const Vector2d left = position_[mark] - part.placed.segment<2>(at);
        const double redundancy = 0.5 * free.block<2, 2>(at, at).trace();
        if (redundancy < 0.05) continue;
        const double size = left.squaredNorm() / (redundancy * noise_ * noise_);
        if (size <= most) continue;
        most = size;
        worst = part.sightings[k];
      }
    }
    return worst;
  }

  const std::vector<Vector2d>& start_;
  std::vector<Vector2d> position_;
  CommonAffinity common_;
  std::vector<Sighting> sightings_;
  std::vector<std::vector<size_t>> by_scan_;
  std::vector<Transform> transform_;
  std::vector<size_t> shown_;
  std::vector<long> column_;  // of a shown mark's x among the unknowns
  MatrixXd cofactor_;
  double noise_ = 0.01, affinity_ = 0.01;
  Vector2d mean_affinity_ = Vector2d::Zero();
  int scans_ = 0, rejected_ = 0;
};

}  // namespace

std::optional<CameraEstimate> EstimateCamera(const std::vector<ScanOfMarks>& scans,
                                             const std::vector<Vector2d>& start_mm,
                                             CommonAffinity common) {
  Adjustment adjustment(scans, start_mm, common);
  if (!adjustment.Run()) return std::nullopt;
  return adjustment.Result();
}

}  // namespace orient::block

#include "block/inputs/strip_geometry.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/geometry/rotation.h"

namespace orient::block {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// How well flights keep to their plan, as shares of the base, the strip spacing and the flying
// height.
constexpr double kStepAlong = 0.07, kStepAcross = 0.04;    // of one base from the strip's base
constexpr double kBaseAlong = 0.12, kBaseAcross = 0.09;    // of a strip's base from the stated one
constexpr double kBackAlong = 0.1, kBackAcross = 0.06;     // of a base from the previous strip's
constexpr double kAbreast = 0.4, kAbreastOfPhoto = 0.3;    // of a base; plus this per extra photo
constexpr double kApart = 0.15, kApartOfOne = 0.1;         // of the strip spacing
constexpr double kClimb = 0.01, kClimbToNextStrip = 0.02;  // of the flying height
constexpr double kAnywhere = 0.75;                         // if the direction is unknown
const double kTilt_rad = RadFromDeg(3);
const double kCrab_rad = RadFromDeg(5), kCrabOfOtherStrip_rad = RadFromDeg(8);
constexpr double kLeastSigma_m = 0.01;

Vector2d Towards(double azimuth_rad) { return {std::sin(azimuth_rad), std::cos(azimuth_rad)}; }

// Along and across `direction` where there is one, otherwise `along` everywhere.
Matrix3d CovarianceOf(const std::optional<Vector2d>& direction, double along, double across,
                      double up) {
  Matrix3d covariance = Vector3d(along * along, along * along, up * up).asDiagonal();
  if (direction) {
    const Vector2d side(-direction->y(), direction->x());
    covariance.topLeftCorner<2, 2>() = along * along * *direction * direction->transpose() +
                                       across * across * side * side.transpose();
  }
  return covariance;
}

struct Solution {
  Vector3d value;
  Matrix3d covariance;
};

// Linear observations of points and vectors in space.
class LinearSystem {
 public:
  explicit LinearSystem(std::size_t unknowns)
      : normal_(Size(unknowns), Size(unknowns)), right_(Eigen::VectorXd::Zero(Size(unknowns))) {}

  // The sum of coefficient times unknown is observed as `value`.
  void Observe(const std::vector<std::pair<std::size_t, double>>& terms, const Vector3d& value,
               const Matrix3d& covariance) {
    const Matrix3d weight = covariance.inverse();
    for (const auto& [i, a] : terms) {
      right_.segment<3>(At(i)) += a * weight * value;
      for (const auto& [j, b] : terms)
        for (int row = 0; row < 3; ++row)
          for (int col = 0; col < 3; ++col)
            entries_.emplace_back(At(i) + row, At(j) + col, a * b * weight(row, col));
    }
  }

  void Solve() {
    normal_.setFromTriplets(entries_.begin(), entries_.end());
    solver_.compute(normal_);
    values_ = solver_.solve(right_);
  }

  Solution Of(std::size_t unknown) const {
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(normal_.rows(), 3);
    columns.middleRows<3>(At(unknown)) = Matrix3d::Identity();
    const Eigen::MatrixXd inverse = solver_.solve(columns);
    return {values_.segment<3>(At(unknown)), inverse.middleRows<3>(At(unknown))};
  }

 private:
  static Eigen::Index Size(std::size_t unknowns) { return 3 * static_cast<Eigen::Index>(unknowns); }
  static Eigen::Index At(std::size_t unknown) { return Size(unknown); }

  Eigen::SparseMatrix<double> normal_;
  Eigen::VectorXd right_, values_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
};

class StripAdjustment {
 public:
  StripAdjustment(const FlightPlan& plan, const std::map<std::string, OrientationRow>& located,
                  const Camera& camera, double height_m)
      : plan_(plan), located_(located), camera_(camera), height_m_(height_m) {
    for (const FlightStrip& strip : plan.strips) {
      first_.push_back(photos_);
      photos_ += strip.photos.size();
    }
  }

  // Solves twice if no direction is stated: the first solution finds it.
  void Run() {
    direction_ = StatedDirection();
    if (direction_ && plan_.next_strip && !TellsSide(*direction_))
      throw InputError(fmt::format(
          "[flight] next_strip names a direction along the strips, not beside them (azimuth_deg of "
          "[flight], or of strip {}); correct next_strip or azimuth_deg",
          plan_.strips.front().name));
    distances_ = DistancesOf(plan_, camera_, height_m_, XAlong());
    Solve();
    if (direction_) return;
    direction_ = FoundDirection();
    if (!direction_) return;
    distances_ = DistancesOf(plan_, camera_, height_m_, XAlong());
    Solve();
  }

  Solution Photo(std::size_t strip, std::size_t number) const {
    return system_->Of(first_[strip] + number);
  }

 private:
  std::size_t Base(std::size_t strip) const { return photos_ + strip; }
  std::size_t Side() const { return photos_ + plan_.strips.size(); }

  // Whether next_strip lies clearly to one side of strips that run along `direction`.
  bool TellsSide(const Vector2d& direction) const {
    constexpr double kLeastAcross = 0.4;
    return std::abs(Vector2d(-direction.y(), direction.x()).dot(*plan_.next_strip)) >= kLeastAcross;
  }

  // Direction of a strip relative to the first one, 1 or -1.
  double Sense(std::size_t strip) const { return plan_.back_and_forth && strip % 2 == 1 ? -1 : 1; }

  std::optional<Vector2d> StatedDirection(std::size_t strip) const {
    if (plan_.strips[strip].azimuth_rad) return Towards(*plan_.strips[strip].azimuth_rad);
    if (plan_.azimuth_rad) return Vector2d(Sense(strip) * Towards(*plan_.azimuth_rad));
    return std::nullopt;
  }

  // The flight's stated direction, or the strips' if all have the same. One strip's alone does not
  // apply to the others: it may be a cross strip.
  std::optional<Vector2d> StatedDirection() const {
    if (plan_.azimuth_rad) return Towards(*plan_.azimuth_rad);
    const double agree = std::cos(RadFromDeg(20));
    std::optional<Vector2d> common;
    for (std::size_t i = 0; i < plan_.strips.size(); ++i) {
      const auto stated = StatedDirection(i);
      if (!stated || (common && std::abs(common->dot(*stated)) < agree)) return std::nullopt;
      if (!common) common = Sense(i) * *stated;
    }
    return common;
  }

  // Whether the photos' x axis lies along the flight, as a located photo's kappa says.
  std::optional<bool> XAlong() const {
    constexpr double kMostSigma_rad = 0.35;
    for (std::size_t i = 0; i < plan_.strips.size(); ++i)
      for (const std::string& photo : plan_.strips[i].photos) {
        const auto known = located_.find(photo);
        if (known == located_.end() || !known->second.attitude_known ||
            (*known->second.sigma)[5] > kMostSigma_rad)
          continue;
        const double kappa = known->second.pose.opk_rad[2];
        const auto stated = StatedDirection(i);
        const auto& along = stated ? stated : direction_;
        if (!along) continue;
        return std::abs(along->dot(Vector2d(std::cos(kappa), std::sin(kappa)))) > std::sqrt(0.5);
      }
    return std::nullopt;
  }

  // Direction of the first strip, from the strip whose base is known best.
  std::optional<Vector2d> FoundDirection() const {
    constexpr double kLeastSigmas = 4;
    std::optional<Vector2d> found;
    double best = kLeastSigmas;
    for (std::size_t i = 0; i < plan_.strips.size(); ++i) {
      if (plan_.strips[i].azimuth_rad) continue;  // applies to that strip only
      const Solution base = system_->Of(Base(i));
      const double sigma = std::sqrt(base.covariance.topLeftCorner<2, 2>().trace() / 2);
      const double sigmas = base.value.head<2>().norm() / sigma;
      if (sigmas <= best) continue;
      best = sigmas;
      found = Sense(i) * base.value.head<2>().normalized();
    }
    return found;
  }

  void Solve() {
    system_.emplace(photos_ + plan_.strips.size() + 1);
    for (std::size_t i = 0; i < plan_.strips.size(); ++i) {
      ObserveStrip(i);
      if (i > 0) ObserveBeside(i);
    }
    ObserveSide();
    system_->Solve();
  }

  void ObserveStrip(std::size_t strip) {
    const double base = distances_.base_m;
    const std::vector<std::string>& photos = plan_.strips[strip].photos;
    for (std::size_t i = 0; i < photos.size(); ++i) {
      if (const auto known = located_.find(photos[i]); known != located_.end())
        system_->Observe({{first_[strip] + i, 1}}, known->second.pose.position_m,
                         known->second.sigma->head<3>()
                             .cwiseMax(kLeastSigma_m)
                             .cwiseAbs2()
                             .asDiagonal()
                             .toDenseMatrix());
      if (i > 0)
        system_->Observe(
            {{first_[strip] + i, 1}, {first_[strip] + i - 1, -1}, {Base(strip), -1}},
            Vector3d::Zero(),
            CovarianceOf(direction_, kStepAlong * base, kStepAcross * base, kClimb * height_m_));
    }
    const auto stated = StatedDirection(strip);
    Vector3d expected = Vector3d::Zero();
    if (stated) expected << base * *stated, 0;
    system_->Observe(
        {{Base(strip), 1}}, expected,
        CovarianceOf(stated,
                     (stated ? std::hypot(kBaseAlong, distances_.uncertain) : kAnywhere) * base,
                     kBaseAcross * base, kClimb * height_m_));
  }

  // Observes this strip relative to the one before.
  void ObserveBeside(std::size_t strip) {
    const double base = distances_.base_m, apart = distances_.apart_m;
    const double same_way = Sense(strip) * Sense(strip - 1);
    const auto own = [&](std::size_t i) { return plan_.strips[i].azimuth_rad.has_value(); };
    if (!own(strip) && !own(strip - 1))
      system_->Observe(
          {{Base(strip), 1}, {Base(strip - 1), -same_way}}, Vector3d::Zero(),
          CovarianceOf(direction_, kBackAlong * base, kBackAcross * base, kClimb * height_m_));
    const std::size_t here = plan_.strips[strip].photos.size();
    const std::size_t there = plan_.strips[strip - 1].photos.size();
    const auto more = static_cast<double>(here > there ? here - there : there - here);
    const double abreast = std::hypot(kAbreast, kAbreastOfPhoto * more) * base;
    std::vector<std::pair<std::size_t, double>> middles = {{first_[strip], 0.5},
                                                           {first_[strip] + here - 1, 0.5},
                                                           {first_[strip - 1], -0.5},
                                                           {first_[strip - 1] + there - 1, -0.5},
                                                           {Side(), -1}};
    system_->Observe(middles, Vector3d::Zero(),
                     CovarianceOf(direction_, direction_ ? abreast : std::max(abreast, apart),
                                  kApartOfOne * apart, kClimbToNextStrip * height_m_));
  }

  void ObserveSide() {
    const double apart = distances_.apart_m;
    Vector3d expected = Vector3d::Zero();
    double across = apart;
    if (direction_ && plan_.next_strip && TellsSide(*direction_)) {
      Vector2d side(-direction_->y(), direction_->x());
      if (side.dot(*plan_.next_strip) < 0) side = -side;
      expected << apart * side, 0;
      across = std::hypot(kApart, distances_.uncertain) * apart;
    }
    system_->Observe({{Side(), 1}}, expected,
                     CovarianceOf(direction_, direction_ ? kAbreast * distances_.base_m : apart,
                                  across, kClimbToNextStrip * height_m_));
  }

  const FlightPlan& plan_;
  const std::map<std::string, OrientationRow>& located_;
  const Camera& camera_;
  StripDistances distances_;
  const double height_m_;
  std::vector<std::size_t> first_;  // each strip's first photo
  std::size_t photos_ = 0;
  std::optional<Vector2d> direction_;  // of the first strip
  std::optional<LinearSystem> system_;
};

// Azimuth in which a strip is flown, if the plan states one; clockwise from north.
std::optional<double> AzimuthOf(const FlightPlan& plan, std::size_t strip) {
  const bool back = plan.back_and_forth && strip % 2 == 1;
  if (plan.strips[strip].azimuth_rad) return plan.strips[strip].azimuth_rad;
  if (plan.azimuth_rad) return *plan.azimuth_rad + (back ? std::numbers::pi : 0);
  return std::nullopt;
}

// Difference between two strips' kappas; unknown if only one of them has an azimuth.
std::optional<double> TurnBetween(const FlightPlan& plan, std::size_t from, std::size_t to) {
  if (from == to) return 0;
  const auto there = AzimuthOf(plan, from), here = AzimuthOf(plan, to);
  if (there && here) return *there - *here;  // azimuths are clockwise
  if (there || here) return std::nullopt;
  return plan.back_and_forth && (from + to) % 2 == 1 ? std::numbers::pi : 0;
}

// Takes a photo's kappa from the nearest located one, if any; otherwise it is unknown.
void TakeKappa(const FlightPlan& plan, const std::map<std::string, OrientationRow>& located,
               std::size_t strip, std::size_t number, OrientationRow* row) {
  row->attitude_known = false;
  (*row->sigma)[5] = std::numbers::pi;
  std::size_t nearest = SIZE_MAX;
  for (std::size_t s = 0; s < plan.strips.size(); ++s)
    for (std::size_t n = 0; n < plan.strips[s].photos.size(); ++n) {
      const auto known = located.find(plan.strips[s].photos[n]);
      if (known == located.end() || !known->second.attitude_known) continue;
      const std::size_t strips = s > strip ? s - strip : strip - s;
      const std::size_t photos = n > number ? n - number : number - n;
      const std::size_t far = strips * 10000 + photos;
      const auto turn = TurnBetween(plan, s, strip);
      if (far >= nearest || !turn) continue;
      nearest = far;
      row->attitude_known = true;
      row->pose.opk_rad[2] = NormalizeAngle(known->second.pose.opk_rad[2] + *turn);
      (*row->sigma)[5] =
          std::hypot(strips == 0 ? kCrab_rad : kCrabOfOtherStrip_rad, (*known->second.sigma)[5]);
    }
}

double FlyingHeightOf(const FlightPlan& plan, const Camera& camera,
                      const std::map<std::string, OrientationRow>& located, double ground_m) {
  if (const auto stated = plan.FlyingHeight(camera.principal_distance_mm)) return *stated;
  std::vector<double> heights;
  for (const auto& [photo, row] : located)
    if (row.pose.position_m.z() > ground_m) heights.push_back(row.pose.position_m.z() - ground_m);
  if (heights.empty())
    throw InputError("photo " + located.begin()->first +
                     ", from which its strip is located, lies below the ground; correct its "
                     "approximation");
  return UpperMedian(std::move(heights));
}

}  // namespace

StripDistances DistancesOf(const FlightPlan& plan, const Camera& camera, double height_m,
                           std::optional<bool> x_along) {
  const double scale = height_m / camera.principal_distance_mm;
  const double x = camera.frame_mm.x() * scale, y = camera.frame_mm.y() * scale;
  if (x_along)
    return {(1 - plan.overlap) * (*x_along ? x : y), (1 - plan.side_lap) * (*x_along ? y : x), 0};
  const double mean = std::sqrt(x * y);
  return {(1 - plan.overlap) * mean, (1 - plan.side_lap) * mean, std::abs(x - y) / (x + y)};
}

std::vector<OrientationRow> FillStrips(const FlightPlan& plan,
                                       const std::vector<OrientationRow>& located,
                                       const Camera& camera, double ground_m) {
  std::map<std::string, OrientationRow> known;
  for (const OrientationRow& row : located)
    for (const FlightStrip& strip : plan.strips)
      if (std::find(strip.photos.begin(), strip.photos.end(), row.photo) != strip.photos.end())
        known[row.photo] = row;
  if (known.empty())
    throw InputError(
        fmt::format("no photo of the strips (strip {}, photo {}, and so on) is located; give one "
                    "photo's position in a table of approximations",
                    plan.strips.front().name, plan.strips.front().photos.front()));
  const double height_m = FlyingHeightOf(plan, camera, known, ground_m);
  StripAdjustment strips(plan, known, camera, height_m);
  strips.Run();
  std::vector<OrientationRow> rows;
  for (std::size_t s = 0; s < plan.strips.size(); ++s)
    for (std::size_t n = 0; n < plan.strips[s].photos.size(); ++n) {
      if (known.contains(plan.strips[s].photos[n])) continue;
      const Solution place = strips.Photo(s, n);
      OrientationRow row;
      row.photo = plan.strips[s].photos[n];
      row.pose.position_m = place.value;
      row.sigma = Vector6d::Constant(kTilt_rad);
      row.sigma->head<3>() = place.covariance.diagonal().cwiseSqrt();
      TakeKappa(plan, known, s, n, &row);
      rows.push_back(std::move(row));
    }
  return rows;
}

}  // namespace orient::block

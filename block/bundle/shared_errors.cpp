#include "block/bundle/shared_errors.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include "block/bundle/outcome.h"
#include "core/geometry/bounds.h"

namespace orient::block {
namespace {

// A variance from so many draws is good to a tenth.
constexpr int kDraws = 200;
constexpr std::size_t kWaves = 16;

struct ControlPoint {
  const std::string* source = nullptr;
  Eigen::Vector2d place_m;
  double sigma_m = 0;  // of its ground and its image measurements, one coordinate
  double source_sigma_m = 0;
  Eigen::MatrixX3d by_ground;  // reduced right-hand side per metre of ground error
  std::vector<int> groups;     // of its rows, six each
};

// Variance of one ground coordinate from a single ray, on average; 0 if no ray contributes.
double ImageVariance(const BlockSystem& system, std::size_t point) {
  double sum = 0;
  int rays = 0;
  for (const std::size_t row : system.image_rows_of_point[point]) {
    if (!system.IsActive(row)) continue;
    const PointRows linear = system.LinearisePoint(system.rows[row]);
    sum += linear.by_point.leftCols<2>().squaredNorm() / 2;
    ++rays;
  }
  return sum > 0 ? rays / sum : 0;
}

// How much of the variance used to weight control's images and ground their residuals show. If the
// stated variances are far too large, so are the shared errors.
double ShownByResiduals(const BlockSystem& system, const BlockTests& tests) {
  const auto sums = SumsOf(system, tests);
  double square = 0, redundancy = 0;
  for (const RowKind kind : {RowKind::kControlImage, RowKind::kControlGround}) {
    square += sums.at(static_cast<std::size_t>(kind)).square;
    redundancy += sums.at(static_cast<std::size_t>(kind)).redundancy;
  }
  return redundancy >= kLeastGroupRedundancy ? square / redundancy : 1;
}

std::vector<ControlPoint> UsedControl(const BlockSystem& system, const BlockNormals& normals,
                                      double shown) {
  std::vector<ControlPoint> control;
  for (std::size_t i = 0; i < system.points.size(); ++i) {
    if (!system.HasControl(i) || system.block.points[i].by_hand) continue;
    const GroundControl& given = *system.block.points[i].control;
    ControlPoint point;
    point.source = &given.source;
    point.place_m = given.ground_m.head<2>();
    point.source_sigma_m = given.source_sigma_m;
    const double ground = given.covariance_m2.topLeftCorner<2, 2>().trace() / 2;
    point.sigma_m = std::sqrt(
        shown * (system.Factor(RowKind::kControlGround) * ground + ImageVariance(system, i)));
    if (!normals.RightSideOfControl(i, &point.groups, &point.by_ground)) continue;
    control.push_back(std::move(point));
  }
  return control;
}

// A smooth random field of unit variance: covariance exp(-(d / length)^2).
class Field {
 public:
  Field(double length_m, std::mt19937* random) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi);
    for (Eigen::Vector3d& wave : waves_)
      wave = {std::numbers::sqrt2 / length_m * normal(*random),
              std::numbers::sqrt2 / length_m * normal(*random), phase(*random)};
  }
  double At(const Eigen::Vector2d& place_m) const {
    double sum = 0;
    for (const Eigen::Vector3d& wave : waves_)
      sum += std::cos(wave.head<2>().dot(place_m) + wave.z());
    return sum * std::sqrt(2.0 / kWaves);
  }

 private:
  std::array<Eigen::Vector3d, kWaves> waves_;
};

// The ground that a source's control covers.
using Areas = std::map<std::string, Bounds>;

Areas AreasOf(const std::vector<ControlPoint>& control, Areas areas) {
  for (const ControlPoint& point : control)
    areas.try_emplace(*point.source, Bounds::OfNothing())
        .first->second.Include(point.place_m.x(), point.place_m.y());
  return areas;
}

// What the points of one source share: smooth fields, and its shift and linear deformation.
class SourceErrors {
 public:
  SourceErrors(const Bounds& area, double length_m, std::mt19937* random)
      : middle_((area.min_x + area.max_x) / 2, (area.min_y + area.max_y) / 2),
        half_m_(std::max({area.max_x - area.min_x, area.max_y - area.min_y, 1e-3}) / 2),
        fields_{Field(length_m, random), Field(length_m, random)} {
    std::normal_distribution<double> normal;
    for (double& element : linear_.reshaped()) element = normal(*random);
  }
  Eigen::Vector2d Smooth(const Eigen::Vector2d& place_m) const {
    return {fields_[0].At(place_m), fields_[1].At(place_m)};
  }
  Eigen::Vector2d Linear(const Eigen::Vector2d& place_m) const {
    return linear_ * ((place_m - middle_) / half_m_).homogeneous();
  }

 private:
  Eigen::Vector2d middle_;
  double half_m_;
  std::array<Field, 2> fields_;
  Eigen::Matrix<double, 2, 3> linear_;
};

// All unknowns' right-hand sides resulting from one draw of the errors.
Eigen::VectorXd Draw(const BlockSystem& system, const std::vector<ControlPoint>& control,
                     const Areas& areas, std::mt19937* random) {
  const BlockOptions& options = system.options;
  std::normal_distribution<double> normal;
  const Eigen::Vector2d everywhere(normal(*random), normal(*random));
  std::map<std::string, SourceErrors> sources;
  Eigen::VectorXd right =
      Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(system.groups.size()));
  for (const ControlPoint& point : control) {
    auto source = sources.find(*point.source);
    if (source == sources.end())
      source = sources
                   .emplace(*point.source, SourceErrors(areas.at(*point.source),
                                                        options.height_correlation_m, random))
                   .first;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    shift.head<2>() =
        point.sigma_m * (options.control_shared_everywhere * everywhere +
                         options.control_shared_smoothly * source->second.Smooth(point.place_m)) +
        point.source_sigma_m * source->second.Linear(point.place_m);
    const Eigen::VectorXd of_point = point.by_ground * shift;
    for (std::size_t g = 0; g < point.groups.size(); ++g)
      right.segment<6>(6 * static_cast<Eigen::Index>(point.groups[g])) +=
          of_point.segment<6>(6 * static_cast<Eigen::Index>(g));
  }
  return right;
}

Eigen::MatrixXd Moved(const BlockSystem& system, const BlockNormals& normals,
                      const std::vector<ControlPoint>& control) {
  const Areas areas = AreasOf(control, system.options.source_areas);
  std::mt19937 random(1);
  Eigen::MatrixXd moved(6 * static_cast<Eigen::Index>(system.groups.size()), kDraws);
  for (int draw = 0; draw < kDraws; ++draw)
    moved.col(draw) = normals.cholesky().Solve(Draw(system, control, areas, &random));
  return moved / std::sqrt(kDraws);
}

void AddToPoses(const BlockSystem& system, const Eigen::MatrixXd& moved, BlockResult* result) {
  const auto of_photo = [&](std::size_t i) {
    return moved.middleRows<6>(6 * static_cast<Eigen::Index>(system.pose_group[i]));
  };
  for (std::size_t i = 0; i < result->photos.size(); ++i)
    if (result->photos[i].state == PhotoState::kAdjusted)
      result->photos[i].covariance += of_photo(i) * of_photo(i).transpose();
  const auto& photos = result->covariance_photos;
  for (std::size_t a = 0; a < photos.size(); ++a)
    for (std::size_t b = 0; b < photos.size(); ++b)
      result->pose_covariance.block<6, 6>(6 * static_cast<Eigen::Index>(a),
                                          6 * static_cast<Eigen::Index>(b)) +=
          of_photo(photos[a]) * of_photo(photos[b]).transpose();
}

// Adds to the sigmas of the camera and GNSS parameters that the block estimated.
void AddToParameters(const BlockSystem& system, const Eigen::MatrixXd& moved, BlockResult* result) {
  const auto variances = [&](int group) -> Vector6d {
    return moved.middleRows<6>(6 * static_cast<Eigen::Index>(group)).rowwise().squaredNorm();
  };
  for (std::size_t i = 0; i < result->calibration.size(); ++i) {
    CalibrationParameter& parameter = result->calibration[i];
    if (parameter.state != CalibrationState::kEstimated) continue;
    const auto k = static_cast<Eigen::Index>(i % 6);
    parameter.sigma =
        std::hypot(parameter.sigma, std::sqrt(variances(system.lens_group[parameter.camera])[k]) *
                                        system.lens[parameter.camera].unit[k]);
  }
  for (StripGnss& strip : result->strips)
    for (std::size_t i = 0; i < system.block.photos.size(); ++i) {
      if (system.gnss_group[i] < 0) continue;
      if (!strip.of_all && system.block.photos[i].strip != strip.strip) continue;
      const Vector6d added = variances(system.gnss_group[i]);
      strip.shift_sigma_m = (strip.shift_sigma_m.cwiseAbs2() + added.head<3>()).cwiseSqrt();
      if (strip.drift_sigma_m)
        strip.drift_sigma_m = (strip.drift_sigma_m->cwiseAbs2() + added.tail<3>()).cwiseSqrt();
      break;
    }
}

// Ties follow the photos that show them.
void AddToTies(const BlockSystem& system, const BlockNormals& normals, const Eigen::MatrixXd& moved,
               BlockResult* result) {
  const auto add = [&](std::size_t point) {
    std::vector<int> groups;
    Eigen::Matrix3Xd by_groups;
    if (system.HasControl(point) || !normals.FollowsGroups(point, &groups, &by_groups)) return;
    Eigen::Matrix3Xd follows = Eigen::Matrix3Xd::Zero(3, moved.cols());
    for (std::size_t g = 0; g < groups.size(); ++g)
      follows += by_groups.middleCols<6>(6 * static_cast<Eigen::Index>(g)) *
                 moved.middleRows<6>(6 * static_cast<Eigen::Index>(groups[g]));
    result->points[point].covariance_m2 += follows * follows.transpose();
  };
  tbb::task_arena(system.options.threads).execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, system.points.size(), 256),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t i = range.begin(); i < range.end(); ++i) add(i);
                      });
  });
}

}  // namespace

Eigen::MatrixXd UnknownsMovedByControl(const BlockSystem& system, const BlockNormals& normals,
                                       const BlockTests& tests) {
  const BlockOptions& options = system.options;
  const bool of_sources =
      std::any_of(system.block.points.begin(), system.block.points.end(),
                  [](const BlockPoint& p) { return p.control && p.control->source_sigma_m > 0; });
  if (options.control_shared_everywhere <= 0 && options.control_shared_smoothly <= 0 && !of_sources)
    return {};
  const std::vector<ControlPoint> control =
      UsedControl(system, normals, ShownByResiduals(system, tests));
  return control.empty() ? Eigen::MatrixXd() : Moved(system, normals, control);
}

void AddSharedControlErrors(const BlockSystem& system, const BlockNormals& normals,
                            const BlockTests& tests, BlockResult* result) {
  const Eigen::MatrixXd moved = UnknownsMovedByControl(system, normals, tests);
  if (moved.size() == 0) return;
  AddToPoses(system, moved, result);
  AddToParameters(system, moved, result);
  AddToTies(system, normals, moved, result);
}

}  // namespace orient::block

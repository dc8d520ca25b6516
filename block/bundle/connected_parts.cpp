#include "block/bundle/connected_parts.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/geometry/dense_solvers.h"

namespace orient::block {
namespace {

// A block moves freely in seven ways: three shifts, three rotations, one scale.
using Matrix7d = Eigen::Matrix<double, 7, 7>;

// Derivatives of a position by these seven: shift, rotation and scale about the part's centre, the
// latter two in metres at the part's edge.
Eigen::Matrix<double, 3, 7> ByDatum(const Eigen::Vector3d& offset_m, double radius_m) {
  const Eigen::Vector3d x = offset_m / radius_m;
  Eigen::Matrix<double, 3, 7> by;
  by << Eigen::Matrix3d::Identity(),
      (Eigen::Matrix3d() << 0, x.z(), -x.y(), -x.z(), 0, x.x(), x.y(), -x.x(), 0).finished(), x;
  return by;
}

void AddPlace(const Eigen::Vector3d& offset_m, double radius_m, const Eigen::Matrix3d& covariance,
              Matrix7d* normal) {
  const auto by = ByDatum(offset_m, radius_m);
  *normal += by.transpose() * covariance.inverse() * by;
}

// Sigma (m) of the datum's least certain component; infinite if it is open.
double DatumSigma(const Matrix7d& normal) {
  const double least = EigenOfSymmetric(normal).values[0];
  return least > 0 ? 1 / std::sqrt(least) : INFINITY;
}

struct PartDatum {
  Matrix7d control = Matrix7d::Zero(), all = Matrix7d::Zero();
  double radius_m = 1;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
};

void FindExtent(const BlockSystem& system, const std::vector<std::size_t>& photos,
                PartDatum* datum) {
  for (const std::size_t i : photos) datum->centre_m += system.LocalPoseOf(i).position_m;
  datum->centre_m /= static_cast<double>(photos.size());
}

void AddPhotoPriors(const BlockSystem& system, std::size_t photo, PartDatum* datum) {
  const BlockPhoto& of = system.block.photos[photo];
  const Eigen::Vector3d offset = system.LocalPoseOf(photo).position_m - datum->centre_m;
  const auto counts = [&](int row) {
    return row >= 0 && system.IsActive(static_cast<std::size_t>(row));
  };
  if (counts(system.gnss_row[photo])) {
    Eigen::Matrix3d covariance = of.gnss->covariance_m2;
    if (system.options.gnss != GnssModel::kPlain)
      covariance += Eigen::Matrix3d::Identity() * std::pow(system.options.gnss_shift_sigma_m, 2);
    AddPlace(offset, datum->radius_m, covariance, &datum->all);
  }
  if (!counts(system.prior_row[photo])) return;
  AddPlace(offset, datum->radius_m, of.prior->covariance.topLeftCorner<3, 3>(), &datum->all);
  if (StatedElements(*of.prior).back() < 3) return;
  // Rotations about the ground axes, taken to be as uncertain as the angles.
  const Eigen::Matrix3d angles =
      of.prior->covariance.bottomRightCorner<3, 3>() * (datum->radius_m * datum->radius_m);
  datum->all.block<3, 3>(3, 3) += angles.inverse();
}

// The reason reported for a deficient part. `only`: the block has one part.
std::optional<Reason> WhatOf(const BlockPart& part, bool only) {
  if (!part.has_datum) return only ? Reason::kBlockWithoutDatum : Reason::kPartWithoutDatum;
  if (part.control_points == 0)
    return only ? Reason::kBlockWithoutControl : Reason::kPartWithoutControl;
  if (!part.by_control)
    return only ? Reason::kBlockPoorlyControlled : Reason::kPartPoorlyControlled;
  return only ? std::nullopt : std::optional(Reason::kPartNotConnected);
}

void FindDatum(const BlockSystem& system, const std::vector<std::size_t>& control, double reach_m,
               BlockPart* part) {
  PartDatum datum;
  datum.radius_m = std::max(reach_m, 1.0);
  FindExtent(system, part->photos, &datum);
  for (const std::size_t i : part->photos)
    datum.radius_m =
        std::max(datum.radius_m, (system.LocalPoseOf(i).position_m - datum.centre_m).norm());
  for (const std::size_t i : control)
    datum.radius_m = std::max(datum.radius_m, (system.LocalGroundOf(i) - datum.centre_m).norm());
  for (const std::size_t i : control)
    AddPlace(system.LocalGroundOf(i) - datum.centre_m, datum.radius_m,
             system.block.points[i].control->covariance_m2, &datum.control);
  datum.all = datum.control;
  for (const std::size_t i : part->photos) AddPhotoPriors(system, i, &datum);
  part->control_points = static_cast<int>(control.size());
  // A datum less certain than a tenth of the part's size is of no practical use.
  part->by_control = DatumSigma(datum.control) < 0.1 * datum.radius_m;
  part->has_datum = DatumSigma(datum.all) < datum.radius_m;
}

}  // namespace

std::string NamesOf(const BlockToAdjust& block, const std::vector<std::size_t>& photos) {
  constexpr std::size_t kNamed = 5;
  std::string names;
  for (std::size_t i = 0; i < std::min(photos.size(), kNamed); ++i) {
    if (i > 0) names += i + 1 == photos.size() ? " and " : ", ";
    names += block.photos[photos[i]].name;
  }
  if (photos.size() > kNamed) names += fmt::format(" and {} more", photos.size() - kNamed);
  return names;
}

std::optional<Finding> FindingOf(const BlockToAdjust& block, const BlockPart& part, bool only) {
  const auto reason = WhatOf(part, only);
  if (!reason) return std::nullopt;
  return Finding{.reason = *reason,
                 .value = static_cast<double>(part.photos.size()),
                 .where = only ? "" : NamesOf(block, part.photos)};
}

std::vector<BlockPart> FindParts(const BlockSystem& system, const std::vector<bool>& connects,
                                 const std::vector<bool>& takes_part) {
  Forest forest(system.block.photos.size());
  std::vector<std::size_t> photo_of_point(system.points.size(), system.block.photos.size());
  std::vector<double> reach_m(system.block.photos.size(), 0);  // to the farthest point seen
  for (std::size_t i = 0; i < system.points.size(); ++i)
    for (const std::size_t row : system.image_rows_of_point[i]) {
      if (!connects[row]) continue;
      const std::size_t photo = system.block.observations[row].photo;
      if (photo_of_point[i] < system.block.photos.size()) forest.Join(photo_of_point[i], photo);
      photo_of_point[i] = photo;
      const double distance_m =
          (system.LocalGroundOf(i) - system.LocalPoseOf(photo).position_m).norm();
      reach_m[photo] = std::max(reach_m[photo], distance_m);
    }
  std::vector<std::vector<std::size_t>> control(system.block.photos.size());
  for (std::size_t i = 0; i < system.points.size(); ++i)
    if (photo_of_point[i] < system.block.photos.size() && system.HasControl(i))
      control[forest.Root(photo_of_point[i])].push_back(i);
  std::vector<BlockPart> parts;
  std::vector<std::size_t> roots;
  std::vector<std::size_t> part_of_root(system.block.photos.size(), 0);
  for (std::size_t i = 0; i < system.block.photos.size(); ++i) {
    const std::size_t root = forest.Root(i);
    if (root == i) {
      part_of_root[i] = parts.size();
      parts.emplace_back();
      roots.push_back(root);
    }
    parts[part_of_root[root]].photos.push_back(i);
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    double reach = 0;
    for (const std::size_t photo : parts[i].photos) reach = std::max(reach, reach_m[photo]);
    FindDatum(system, control[roots[i]], reach, &parts[i]);
    const bool any = std::any_of(parts[i].photos.begin(), parts[i].photos.end(),
                                 [&](std::size_t photo) { return takes_part[photo]; });
    parts[i].has_datum = parts[i].has_datum && any;
    parts[i].finding = FindingOf(system.block, parts[i], parts.size() == 1);
  }
  return parts;
}

}  // namespace orient::block

#include "block/bundle/outcome.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

namespace orient::block {
namespace {

constexpr std::array<const char*, kVarianceGroups> kGroupNames = {
    "tie image",  "control image",  "control ground",  "gnss",
    "pose prior", "measured image", "surveyed ground", "control heights"};

void FillPhotos(const BlockSystem& system, const BlockJudgement& judgement,
                const BlockNormals& normals, BlockResult* result) {
  for (std::size_t i = 0; i < system.block.photos.size(); ++i) {
    AdjustedPhoto& photo = result->photos[i];
    photo.pose = system.block.photos[i].approximate;
    if (!judgement.takes_part()[i]) continue;
    photo.state = PhotoState::kAdjusted;
    photo.pose = system.PoseOf(i);
    photo.covariance = normals.Covariance(system.pose_group[i]);
    photo.interior_correction = system.InteriorCorrection(i);
  }
}

void FillObservations(const BlockSystem& system, const BlockJudgement& judgement,
                      const BlockTests& tests, BlockResult* result) {
  for (std::size_t i = 0; i < system.block.observations.size(); ++i) {
    ObservationResult& o = result->observations[i];
    o.state = judgement.states()[i];
    if (o.state == ObservationState::kHeldOut) continue;
    const BlockPhoto& photo = system.block.photos[system.block.observations[i].photo];
    o.residual_px = photo.photo_from_pixel.A.inverse() * system.ResidualMm(i);
    o.w = std::sqrt(tests.of_row[i].t);
    if (o.state != ObservationState::kUsed) continue;
    o.redundancy = tests.of_row[i].redundancy;
    ++result->photos[system.block.observations[i].photo].observations;
  }
}

void FillPoints(const BlockSystem& system, const BlockJudgement& judgement, const BlockTests& tests,
                BlockResult* result) {
  for (std::size_t i = 0; i < system.points.size(); ++i) {
    AdjustedPoint& point = result->points[i];
    point.ground_m = system.GroundOf(i);
    point.rays = system.Rays(i);
    point.adjusted = point.rays > 0;
    point.covariance_m2 = tests.point_covariance[i];
    point.control_rejected = judgement.control_rejected()[i];
    const auto& control = system.block.points[i].control;
    if (!control || !point.adjusted) continue;
    point.control_residual_m = control->ground_m - point.ground_m;
    point.control_w = std::sqrt(tests.of_control[i].t);
  }
}

double MeanSigmaPx(const BlockSystem& system, RowKind kind) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < system.block.observations.size(); ++i) {
    if (!system.IsActive(i) || system.rows[i].kind != kind) continue;
    const BlockPhoto& photo = system.block.photos[system.block.observations[i].photo];
    sum += system.ImageCovariance(i).trace() / 2 / std::abs(photo.photo_from_pixel.A.determinant());
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

void FillComponents(const BlockSystem& system, const BlockTests& tests, BlockResult* result) {
  const auto sums = SumsOf(system, tests);
  double square = 0;
  for (std::size_t k = 0; k < kVarianceGroups; ++k) {
    const auto kind = static_cast<RowKind>(k);
    square += sums.at(k).square * system.Factor(kind);
    result->redundancy += sums.at(k).redundancy;
    if (sums.at(k).rows == 0) continue;
    VarianceComponent component{GroupName(kind), system.Factor(kind), sums.at(k).redundancy};
    component.estimated =
        system.options.variance_components && sums.at(k).redundancy >= kLeastGroupRedundancy;
    if (IsImage(kind))
      component.sigma0_px = std::sqrt(component.factor) * MeanSigmaPx(system, kind);
    result->components.push_back(component);
  }
  if (result->redundancy > 0.5) result->sigma0 = std::sqrt(square / result->redundancy);
}

void FillPriors(const BlockSystem& system, const BlockTests& tests, BlockResult* result) {
  for (std::size_t i = 0; i < result->photos.size(); ++i) {
    AdjustedPhoto& photo = result->photos[i];
    if (system.prior_row[i] < 0 || photo.state != PhotoState::kAdjusted) continue;
    const auto row = static_cast<std::size_t>(system.prior_row[i]);
    photo.prior_w = std::sqrt(tests.of_row[row].t);
    photo.prior_rejected = !system.IsActive(row);
  }
}

void FillGnss(const BlockSystem& system, const BlockNormals& normals, const BlockTests& tests,
              BlockResult* result) {
  const bool plain = system.options.gnss == GnssModel::kPlain;
  struct Strip {
    int group = 0, used = 0, observed = 0;
  };
  std::map<std::string, Strip> strips;
  for (std::size_t i = 0; i < result->photos.size(); ++i) {
    AdjustedPhoto& photo = result->photos[i];
    if (system.gnss_row[i] < 0 || photo.state != PhotoState::kAdjusted) continue;
    const auto row = static_cast<std::size_t>(system.gnss_row[i]);
    const BlockPhoto& given = system.block.photos[i];
    if (plain ? result->converged && system.EstimatesCommonGnssShift()
              : system.gnss_group[i] >= 0) {
      Strip& strip = strips[plain ? "all photos" : given.strip];
      strip.group = system.gnss_group[i];
      strip.used += system.IsActive(row) ? 1 : 0;
      ++strip.observed;
    }
    const Eigen::LLT<Eigen::Matrix3d> root(given.gnss->covariance_m2);
    photo.gnss_residual_m =
        -(root.matrixL() *
          Eigen::Vector3d(system.LineariseOther(system.rows[row]).residual.head<3>())) /
        system.weight.at(static_cast<std::size_t>(RowKind::kGnss));
    photo.gnss_w = std::sqrt(tests.of_row[row].t);
    photo.gnss_rejected = !system.IsActive(row);
  }
  for (const auto& [name, of] : strips) {
    const Vector6d& value = system.groups[static_cast<std::size_t>(of.group)];
    const Vector6d sigma = normals.Covariance(of.group).diagonal().cwiseMax(0).cwiseSqrt();
    StripGnss strip{name,         value.head<3>(), sigma.head<3>(), std::nullopt,
                    std::nullopt, plain,           of.used,         of.observed};
    if (system.options.gnss == GnssModel::kShiftAndDrift) {
      strip.drift_m = value.tail<3>();
      strip.drift_sigma_m = sigma.tail<3>();
    }
    result->strips.push_back(std::move(strip));
  }
}

// All poses' covariance, one column at a time.
void FillFullCovariance(const BlockSystem& system, const BlockNormals& normals,
                        BlockResult* result) {
  std::vector<std::size_t> photos;
  for (std::size_t i = 0; i < result->photos.size(); ++i)
    if (result->photos[i].state == PhotoState::kAdjusted) photos.push_back(i);
  if (!system.options.full_covariance || photos.size() > kMostForFullCovariance) return;
  const auto unknowns = 6 * static_cast<Eigen::Index>(system.groups.size());
  const auto size = 6 * static_cast<Eigen::Index>(photos.size());
  const auto column_of = [&](std::size_t i) {
    return 6 * static_cast<Eigen::Index>(system.pose_group[i]);
  };
  result->pose_covariance.resize(size, size);
  for (Eigen::Index col = 0; col < size; ++col) {
    const std::size_t photo = photos[static_cast<std::size_t>(col / 6)];
    const Eigen::VectorXd solved =
        normals.cholesky().Solve(Eigen::VectorXd::Unit(unknowns, column_of(photo) + col % 6));
    for (std::size_t k = 0; k < photos.size(); ++k)
      result->pose_covariance.block<6, 1>(6 * static_cast<Eigen::Index>(k), col) =
          solved.segment<6>(column_of(photos[k]));
  }
  result->covariance_photos = std::move(photos);
}

}  // namespace

const char* GroupName(RowKind kind) { return kGroupNames.at(static_cast<std::size_t>(kind)); }

std::array<KindSums, kVarianceGroups> SumsOf(const BlockSystem& system, const BlockTests& tests) {
  std::array<KindSums, kVarianceGroups> sums;
  const auto add = [&](RowKind kind, const RowTest& test) {
    KindSums& sum = sums.at(static_cast<std::size_t>(kind));
    sum.square += test.square;
    sum.redundancy += test.redundancy;
    ++sum.rows;
  };
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const BlockRows& row = system.rows[i];
    if (row.active && row.kind != RowKind::kParameter && !IsGround(row.kind))
      add(row.kind, tests.of_row[i]);
  }
  for (std::size_t i = 0; i < system.points.size(); ++i)
    if (system.HasControl(i)) add(GroundKindOf(system.block.points[i]), tests.of_control[i]);
  return sums;
}

void FillOutcome(const BlockSystem& system, const BlockJudgement& judgement,
                 const BlockNormals& normals, const BlockTests& tests, BlockResult* result) {
  FillPhotos(system, judgement, normals, result);
  FillObservations(system, judgement, tests, result);
  FillPoints(system, judgement, tests, result);
  FillComponents(system, tests, result);
  FillPriors(system, tests, result);
  FillGnss(system, normals, tests, result);
  FillFullCovariance(system, normals, result);
}

}  // namespace orient::block

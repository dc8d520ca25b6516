// Surveyed points after the adjustment: the table of residuals that a block is judged by.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "block/bundle/bundle_result.h"
#include "block/stages/measured_points.h"

namespace orient::block {

struct PointRow {
  std::string name, role, state;  // control or check; used, rejected or held out
  int rays = 0;
  std::optional<Eigen::Vector3d> residual_m;  // given - adjusted; check: given - intersected
  std::optional<double> image_rms_px;         // of the sightings
};

// Of one role's points that count; CE90 and LE90 as of normal errors (NSSDA: 2.1460 times the mean
// RMSE of both axes; 1.6449 times that of heights).
struct PointAccuracy {
  std::string role;
  int points = 0;
  Eigen::Vector3d rmse_m = Eigen::Vector3d::Zero();
  double ce90_m = 0, le90_m = 0;
};

struct PointTable {
  std::vector<PointRow> rows;
  std::vector<PointAccuracy> accuracy;  // of control and check, where there are any
};

PointTable TableOfPoints(const std::vector<SurveyedPoint>& surveyed, const BlockToAdjust& block,
                         const BlockResult& result);

// <directory>/control_points.csv; removed where the table is empty.
std::string PointTablePath(const std::string& directory);
void WritePointTable(const std::string& directory, const PointTable& table);

// "control  6 points, RMSE 0.03 0.04 0.09 m, CE90 0.08 m, LE90 0.15 m"
std::vector<std::string> TextOf(const PointTable& table);

}  // namespace orient::block

#include "block/verdict/point_table.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "core/base/atomic_write.h"
#include "core/base/chi_square.h"
#include "core/base/csv_cell.h"
#include "core/base/median.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

PointRow RowOf(const SurveyedPoint& point, const BlockToAdjust& block, const BlockResult& result,
               const std::map<std::size_t, const CheckPatch*>& checks) {
  const BlockPoint& given = block.points[point.point];
  const AdjustedPoint& adjusted = result.points[point.point];
  PointRow row;
  row.name = point.name;
  row.role = given.held_out ? "check" : "control";
  if (given.held_out) {
    row.state = "held out";
    const auto check = checks.find(point.point);
    if (check != checks.end()) {
      row.rays = check->second->rays;
      row.residual_m = check->second->ground_residual_m;
    }
  } else {
    row.state = adjusted.control_rejected ? "rejected" : adjusted.adjusted ? "used" : "not used";
    row.rays = adjusted.rays;
    if (adjusted.adjusted) row.residual_m = given.control->ground_m - adjusted.ground_m;
  }
  return row;
}

void FillImageRms(const BlockToAdjust& block, const BlockResult& result,
                  const std::vector<SurveyedPoint>& surveyed, PointTable* table) {
  std::map<std::size_t, std::pair<double, int>> sums;
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    const ObservationState state = result.observations[i].state;
    if (state != ObservationState::kUsed && state != ObservationState::kHeldOut) continue;
    auto& [sum, count] = sums[block.observations[i].point];
    sum += result.observations[i].residual_px.squaredNorm();
    ++count;
  }
  for (std::size_t k = 0; k < surveyed.size(); ++k)
    if (const auto sum = sums.find(surveyed[k].point); sum != sums.end())
      table->rows[k].image_rms_px = std::sqrt(sum->second.first / sum->second.second);
}

PointAccuracy AccuracyOf(const std::string& role, const std::vector<PointRow>& rows) {
  PointAccuracy accuracy{.role = role};
  for (const PointRow& row : rows) {
    if (row.role != role || row.state == "rejected" || !row.residual_m) continue;
    accuracy.rmse_m += row.residual_m->cwiseAbs2();
    ++accuracy.points;
  }
  if (accuracy.points == 0) return accuracy;
  accuracy.rmse_m = (accuracy.rmse_m / accuracy.points).cwiseSqrt();
  accuracy.ce90_m = kCircularError90 * 0.5 * (accuracy.rmse_m.x() + accuracy.rmse_m.y());
  accuracy.le90_m = kLinearError90 * accuracy.rmse_m.z();
  return accuracy;
}

}  // namespace

PointTable TableOfPoints(const std::vector<SurveyedPoint>& surveyed, const BlockToAdjust& block,
                         const BlockResult& result) {
  std::map<std::size_t, const CheckPatch*> checks;
  for (const CheckPatch& check : result.checks) checks[check.point] = &check;
  PointTable table;
  for (const SurveyedPoint& point : surveyed)
    table.rows.push_back(RowOf(point, block, result, checks));
  FillImageRms(block, result, surveyed, &table);
  for (const char* role : {"control", "check"})
    if (PointAccuracy accuracy = AccuracyOf(role, table.rows); accuracy.points > 0)
      table.accuracy.push_back(std::move(accuracy));
  return table;
}

std::string PointTablePath(const std::string& directory) {
  return (fs::path(directory) / "control_points.csv").string();
}

void WritePointTable(const std::string& directory, const PointTable& table) {
  if (table.rows.empty()) {
    fs::remove(PointTablePath(directory));
    return;
  }
  std::string text = "point,role,state,rays,residual_x,residual_y,residual_z,image_rms_px\n";
  for (const PointRow& row : table.rows) {
    text += fmt::format("{},{},{},{}", CsvCell(row.name), row.role, row.state, row.rays);
    for (int axis = 0; axis < 3; ++axis)
      text += row.residual_m ? fmt::format(",{:.4f}", (*row.residual_m)[axis]) : ",";
    text += row.image_rms_px ? fmt::format(",{:.3f}\n", *row.image_rms_px) : ",\n";
  }
  WriteFileAtomically(PointTablePath(directory), text);
}

namespace {

// Check points with far larger residuals than the others: their clicks or coordinates are wrong.
std::vector<std::string> FarOff(const std::vector<PointRow>& rows) {
  constexpr std::size_t kLeast = 5;
  constexpr double kFar = 6;  // times the median
  std::vector<double> off_px;
  for (const PointRow& row : rows)
    if (row.role == "check" && row.image_rms_px) off_px.push_back(*row.image_rms_px);
  if (off_px.size() < kLeast) return {};
  const double limit_px = kFar * UpperMedian(std::move(off_px));
  std::vector<std::string> lines;
  for (const PointRow& row : rows)
    if (row.role == "check" && row.image_rms_px && *row.image_rms_px > limit_px)
      lines.push_back(
          fmt::format("far off {}: measured {:.1f} px (RMS) from where its coordinates project "
                      "into the photos, far more than other check points; check both",
                      row.name, *row.image_rms_px));
  return lines;
}

}  // namespace

std::vector<std::string> TextOf(const PointTable& table) {
  std::vector<std::string> lines;
  for (const PointAccuracy& one : table.accuracy)
    lines.push_back(
        fmt::format("{:7} {} points, RMSE x {:.3f}, y {:.3f}, z {:.3f} m, CE90 {:.3f} "
                    "m, LE90 {:.3f} m",
                    one.role, one.points, one.rmse_m.x(), one.rmse_m.y(), one.rmse_m.z(),
                    one.ce90_m, one.le90_m));
  for (const PointRow& row : table.rows)
    if (row.state == "rejected")
      lines.push_back(
          fmt::format("wrong   {}: its coordinates or image measurements contradict the block; "
                      "check both",
                      row.name));
  for (std::string& line : FarOff(table.rows)) lines.push_back(std::move(line));
  return lines;
}

}  // namespace orient::block

#include "block/inputs/pose_observations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "block/inputs/approximations.h"
#include "block/inputs/photo_metadata.h"
#include "core/base/error.h"

namespace orient::block {
namespace {

std::optional<PosePrior> PriorOf(const BlockFile& block, const OrientationRow& row) {
  const bool attitude = row.attitude_known && (row.sigma || block.attitude_sigma_rad);
  if (!row.sigma && !block.position_sigma_m && !attitude) return std::nullopt;
  Vector6d sigma =
      SigmaOfApproximation(row, block.position_sigma_m.value_or(kOpenPosition_m), std::nullopt);
  if (!row.sigma && block.attitude_sigma_rad)
    sigma.tail<3>().setConstant(*block.attitude_sigma_rad);
  if (!attitude) sigma.tail<3>().setConstant(kOpenAttitude_rad);
  return PosePrior{row.pose, sigma.cwiseAbs2().asDiagonal()};
}

// A GNSS position needs a height of its own; none is completed from a flying height.
void LeaveOutRowsWithoutHeight(OrientationTable* table) {
  std::vector<OrientationRow> whole;
  for (OrientationRow& row : table->rows)
    if (std::isnan(row.pose.position_m.z()))
      table->without_position.push_back(row.photo);
    else
      whole.push_back(std::move(row));
  table->rows = std::move(whole);
}

void RefuseNothingToObserve(const BlockFile& block, const PoseObservations& observations) {
  if (!block.observe_approximations || !observations.approximations.empty()) return;
  const std::string asked = "observe = true under [approximate_accuracy], but ";
  throw InputError(asked + (block.approximations.empty()
                                ? "the block has no table of approximations to observe; give one, "
                                  "or leave observe out"
                                : "the accuracy of the table of approximations is not stated; give "
                                  "position_m and attitude_deg there, or sigma columns in the "
                                  "table, or leave observe out"));
}

}  // namespace

std::vector<OrientationRow> ReadGnss(const BlockFile& block, Findings* remarks) {
  if (block.gnss.positions.empty()) return {};
  OrientationTable table =
      ReadApproximations(block.gnss.positions, block.crs, Heights::kMayBeAbsent);
  RequireCrs(block.crs, table, block.gnss.positions);
  table.ignored_angles.clear();  // no angles are used
  LeaveOutRowsWithoutHeight(&table);
  if (table.rows.empty())
    throw InputError(block.gnss.positions +
                     ": no row has a full position; give x, y and z in metres of the block's CRS");
  const Findings of_table = RemarksOn(table, block.gnss.positions);
  remarks->insert(remarks->end(), of_table.begin(), of_table.end());
  for (OrientationRow& row : table.rows) {
    if (!row.sigma && !block.gnss.sigma_m)
      throw InputError(block.gnss.positions + ": the accuracy of the position of " + row.photo +
                       " is not stated; give columns sigma_x,sigma_y,sigma_z or sigma_m under " +
                       "[gnss]");
    if (!row.sigma) row.sigma = SigmaOfApproximation(row, block.gnss.sigma_m, std::nullopt);
    row.attitude_known = false;
  }
  return table.rows;
}

void RefuseExchangedAxes(const BlockFile& block, const std::vector<OrientationRow>& table,
                         const std::vector<OrientationRow>& gnss) {
  constexpr double kMuchNearer = 10;
  std::map<std::string, Eigen::Vector2d> places;
  for (const OrientationRow& row : table) places[row.photo] = row.pose.position_m.head<2>();
  std::size_t in_both = 0, exchanged = 0;
  for (const OrientationRow& row : gnss) {
    const auto place = places.find(row.photo);
    if (place == places.end()) continue;
    const Eigen::Vector2d position = row.pose.position_m.head<2>();
    ++in_both;
    if (kMuchNearer * (position.reverse() - place->second).norm() <
        (position - place->second).norm())
      ++exchanged;
  }
  if (2 * exchanged <= in_both) return;
  throw InputError(
      fmt::format("{}: x and y (easting and northing) are exchanged here or in {}: {} of {} "
                  "positions agree only the other way round; exchange the names of the columns in "
                  "the table that is wrong",
                  block.gnss.positions, block.approximations, exchanged, in_both));
}

void AddGnssPositions(const std::vector<OrientationRow>& gnss,
                      std::vector<OrientationRow>* approximations) {
  std::set<std::string> have;
  for (const OrientationRow& row : *approximations) have.insert(row.photo);
  const Vector6d least = SigmaOfCameraGnss();
  for (const OrientationRow& row : gnss) {
    if (have.contains(row.photo)) continue;
    approximations->push_back(row);
    approximations->back().sigma = row.sigma.value_or(least).cwiseMax(least);
  }
}

PosePriors StatedApproximations(const BlockFile& block, const std::vector<OrientationRow>& table,
                                const std::set<std::string>& computed) {
  PosePriors stated;
  for (const OrientationRow& row : table) {
    auto prior = PriorOf(block, row);
    if (!prior) continue;
    if (computed.contains(row.photo)) prior->covariance(2, 2) = kOpenPosition_m * kOpenPosition_m;
    stated[row.photo] = *prior;
  }
  return stated;
}

PoseObservations ObservationsOf(const BlockFile& block, const PosePriors& stated,
                                const std::vector<OrientationRow>& gnss) {
  PoseObservations observations;
  observations.model = block.gnss.model;
  if (block.observe_approximations) observations.approximations = stated;
  RefuseNothingToObserve(block, observations);
  for (const OrientationRow& row : gnss)
    observations.gnss[row.photo] = {
        row.pose.position_m, row.sigma->head<3>().cwiseAbs2().asDiagonal().toDenseMatrix(), 0};
  for (const FlightStrip& strip : block.flight.strips)
    for (std::size_t i = 0; i < strip.photos.size(); ++i) {
      observations.strip[strip.photos[i]] = strip.name;
      const auto position = observations.gnss.find(strip.photos[i]);
      if (position == observations.gnss.end() || strip.photos.size() < 2) continue;
      position->second.along_strip =
          2 * static_cast<double>(i) / static_cast<double>(strip.photos.size() - 1) - 1;
    }
  return observations;
}

}  // namespace orient::block

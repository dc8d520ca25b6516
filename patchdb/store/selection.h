// Choosing patches by what is known about them, without their chips: for lists, queries and rules
// over millions of patches.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "patchdb/store/learning.h"
#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

// A patch without its chip and heights.
struct PatchSummary {
  std::int64_t id = 0, source_id = 0;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  double gsd_m = 0;
  int chip_px = 0;  // width
  int bits = 8, bands = 1;
  PatchLife life = PatchLife::kActive;
  std::string retired_reason;
  std::int64_t superseded_by = 0;  // 0: none
  int epoch = 1, views = 1;
  std::optional<std::string> created, source_date;
  std::string source_kind, source_name;
  std::optional<double> roundness, distinctness, persistence, relief_px, lean_px, quality;
  SuccessWeights weights;

  SuccessBelief Belief() const { return BeliefOf(quality, weights); }
};

// What is set must hold for a patch to be chosen; unknown values never hold: nothing is known of
// the success of a patch that was never searched for.
struct PatchFilter {
  std::optional<Bounds> bounds;
  // Inside by the even-odd rule over all rings; coordinates of the database's CRS.
  std::vector<std::vector<Eigen::Vector2d>> polygon;
  std::vector<std::int64_t> ids;
  std::optional<PatchLife> life;
  std::optional<std::string> source;  // its name
  std::optional<double> quality_below;
  std::optional<double> success_below;        // of the mean of the belief
  std::optional<double> min_failures;         // of failure_weight
  std::optional<std::string> older_than;      // of the source's date; ISO 8601
  std::optional<std::string> retired_before;  // ISO 8601 date

  bool HasRule() const;  // anything but life
};

// Calls `visit` for every patch chosen, ordered by id, from one state of the database; memory does
// not grow with their number. A damaged place or precision is NaN.
void VisitPatches(const PatchDatabase& database, const PatchFilter& filter,
                  const std::function<void(const PatchSummary&)>& visit);

// Ids of the patches chosen.
std::vector<std::int64_t> ChooseIds(const PatchDatabase& database, const PatchFilter& filter);

bool InsideRings(const std::vector<std::vector<Eigen::Vector2d>>& rings,
                 const Eigen::Vector2d& point);

}  // namespace orient::patchdb

// The rows that a merge reads and writes. Private to merge.cpp; the caller holds the transaction.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

struct NearPatch {
  std::int64_t id = 0;
  double distance_m = 0, gsd_m = 0;
  int chip_px = 0;
  bool is_active = true;
  std::optional<std::string> source_date;
};

class MergeRows {
 public:
  MergeRows(PatchDatabase& target, const PatchDatabase& other) : target_(target), other_(other) {}

  // The target's id of a source of the other database that patches are taken from, and whether it
  // is new there; the id of one that only shows patches.
  std::pair<std::int64_t, bool> SourceFor(const PatchSource& source);
  std::int64_t SourceIdFor(std::int64_t other_id);

  // With state, epoch and dates as in the other database; patch.id is its id there.
  std::int64_t AddPatch(const Patch& patch, std::int64_t source_id);
  void ChangePatch(const Patch& patch, std::int64_t id, std::int64_t source_id);
  // State, reason, dates and epoch of `patch`.
  void SetLife(const Patch& patch, std::int64_t id);
  // Measured evidence is kept: of two rows of one source the target's, if it has a pixel,
  // unless it is to be replaced.
  void AddEvidence(std::int64_t patch_id, const PatchEvidence& evidence, bool replace);
  // The patch has another ground point now, to which its residuals do not refer.
  void ForgetResiduals(std::int64_t patch_id);
  void CountViews(std::int64_t patch_id);
  // Attempts of a patch there become those of one here, the newer of two in one photo stays;
  // `epochs` is added to theirs. Learns from them. Returns how many are new.
  std::int64_t TakeAttempts(std::int64_t other_id, std::int64_t id, std::int64_t epochs);
  int Supersede(std::int64_t old_id, std::int64_t new_id);

  // Within radius_m, nearest first; active, retired and superseded ones.
  std::vector<NearPatch> PatchesNear(const Eigen::Vector3d& ground_m, double radius_m) const;

  // Records which patch of the target corresponds to a patch of the other database.
  void Remember(const Patch& patch, std::int64_t id);
  // superseded_by of all that were remembered.
  void LinkSuccessors();

 private:
  PatchDatabase& target_;
  const PatchDatabase& other_;
  std::map<std::int64_t, std::int64_t> id_here_, successor_there_;
  std::map<std::int64_t, PatchSource> sources_there_;
};

}  // namespace orient::patchdb

#include "patchdb/maintenance/merge_rows.h"

#include "patchdb/store/connection.h"
#include "patchdb/store/learn.h"
#include "patchdb/store/patch_rows.h"
#include "patchdb/store/row_values.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {
namespace {

constexpr const char* kSetLife =
    "UPDATE patches SET state = ?2, retired_reason = ?3, retired_on = ?4, epoch = ?5, "
    "superseded_by = NULL WHERE id = ?1";
constexpr const char* kSetCreated = "UPDATE patches SET created = ?2 WHERE id = ?1";
constexpr const char* kSetSource = "UPDATE patches SET source_id = ?2 WHERE id = ?1";
constexpr const char* kSupersede =
    "UPDATE patches SET state = 'retired', retired_reason = 'superseded by a newer view', "
    "retired_on = date('now'), superseded_by = ?2 WHERE id = ?1 AND id <> ?2 AND state = 'active'";
// Links a successor, but never in a circle.
constexpr const char* kLink =
    "UPDATE patches SET superseded_by = ?2 WHERE id = ?1 AND id <> ?2 AND state = 'retired' AND "
    "superseded_by IS NULL AND id NOT IN (WITH RECURSIVE chain(id) AS (SELECT ?2 UNION SELECT "
    "p.superseded_by FROM chain JOIN patches AS p ON p.id = chain.id WHERE p.superseded_by IS NOT "
    "NULL) SELECT id FROM chain)";
constexpr const char* kNear =
    "SELECT p.id, p.state, s.date, ST_MinX(p.geom), ST_MinY(p.geom), p.gsd_m, substr(p.chip, 17, "
    "4) FROM rtree_patches_geom AS r JOIN patches AS p ON p.id = r.id JOIN sources AS s ON s.id = "
    "p.source_id WHERE r.maxx >= ?1 AND r.minx <= ?2 AND r.maxy >= ?3 AND r.miny <= ?4";
constexpr const char* kJoinEvidence =
    "INSERT INTO evidence (patch_id, source_id, col_px, row_px, residual_col_px, residual_row_px) "
    "VALUES (?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT (patch_id, source_id) DO UPDATE SET (col_px, "
    "row_px, residual_col_px, residual_row_px) = (?3, ?4, ?5, ?6) WHERE evidence.col_px IS NULL "
    "AND excluded.col_px IS NOT NULL";
constexpr const char* kForgetResiduals =
    "UPDATE evidence SET residual_col_px = NULL, residual_row_px = NULL WHERE patch_id = ?1";
#define ORIENT_ATTEMPT_COLUMNS                                                              \
  "photo, state, ncc, residual_col_px, residual_row_px, reason, photo_date, photo_status, " \
  "recorded, epoch, predicted_col_px, predicted_row_px, found_col_px, found_row_px, "       \
  "neighbours_sought, neighbours_matched, photo_digest"
constexpr int kAttemptColumns = 17, kAttemptEpoch = 9;
constexpr const char* kAttemptsThere =
    "SELECT " ORIENT_ATTEMPT_COLUMNS " FROM attempts WHERE patch_id = ?18";
// The newer attempt is kept; of two without a date, the target's.
constexpr const char* kTakeAttempt =
    "INSERT INTO attempts (" ORIENT_ATTEMPT_COLUMNS
    ", patch_id) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, "
    "?17, ?18) ON CONFLICT (patch_id, photo, photo_digest) DO UPDATE SET (" ORIENT_ATTEMPT_COLUMNS
    ") = (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17) "
    "WHERE coalesce(excluded.recorded, '') > coalesce(attempts.recorded, '')";
#undef ORIENT_ATTEMPT_COLUMNS

void BindColumn(const SQLite::Column& column, int index, SQLite::Statement& statement) {
  if (column.isInteger())
    statement.bind(index, column.getInt64());
  else if (column.isFloat())
    statement.bind(index, column.getDouble());
  else if (column.isText())
    statement.bind(index, column.getString());
}

}  // namespace

std::pair<std::int64_t, bool> MergeRows::SourceFor(const PatchSource& source) {
  const bool is_new = !target_.FindSource(source).harvested;
  return {target_.StoreSource(source, true).id, is_new};
}

std::int64_t MergeRows::SourceIdFor(std::int64_t other_id) {
  if (sources_there_.empty())
    for (const PatchSource& source : other_.Sources()) sources_there_[source.id] = source;
  const auto source = sources_there_.find(other_id);
  if (source != sources_there_.end()) return target_.StoreSource(source->second, false).id;
  throw InputError(other_.Path() + " is damaged: source " + std::to_string(other_id) +
                   " is not there; 'orient patchdb check --repair' may help");
}

std::int64_t MergeRows::AddPatch(const Patch& patch, std::int64_t source_id) {
  Connection& connection = target_.Sql();
  const Query insert = connection.Prepare(sql::kAddPatch);
  BindPatch(patch, target_.SrsId(), *insert);
  insert->bind(kPatchValues + 1, source_id);
  insert->exec();
  const std::int64_t id = connection.Database().getLastInsertRowid();
  SetLife(patch, id);
  if (patch.created) {
    const Query created = connection.Prepare(kSetCreated);
    created->bind(1, id);
    created->bind(2, *patch.created);
    created->exec();
  }
  for (const PatchEvidence& evidence : patch.evidence) AddEvidence(id, evidence, false);
  if (!patch.evidence.empty()) CountViews(id);
  target_.GrowExtent(patch.ground_m.head<2>());
  Remember(patch, id);
  return id;
}

void MergeRows::SetLife(const Patch& patch, std::int64_t id) {
  const Query life = target_.Sql().Prepare(kSetLife);
  life->bind(1, id);
  life->bind(2, Name(patch.life));
  if (patch.life == PatchLife::kRetired) {
    life->bind(3, patch.retired_reason);
    if (patch.retired_on) life->bind(4, *patch.retired_on);
  }
  life->bind(5, patch.epoch);
  life->exec();
}

void MergeRows::ChangePatch(const Patch& patch, std::int64_t id, std::int64_t source_id) {
  const Query update = target_.Sql().Prepare(sql::kChangePatch);
  BindPatch(patch, target_.SrsId(), *update);
  update->bind(kPatchValues + 1, id);
  update->exec();
  const Query source = target_.Sql().Prepare(kSetSource);
  source->bind(1, id);
  source->bind(2, source_id);
  source->exec();
  target_.GrowExtent(patch.ground_m.head<2>());
}

void MergeRows::AddEvidence(std::int64_t patch_id, const PatchEvidence& evidence, bool replace) {
  const Query insert = target_.Sql().Prepare(replace ? sql::kAddEvidence : kJoinEvidence);
  BindEvidence(patch_id, evidence.source_id, evidence, *insert);
  insert->exec();
}

void MergeRows::ForgetResiduals(std::int64_t patch_id) {
  const Query update = target_.Sql().Prepare(kForgetResiduals);
  update->bind(1, patch_id);
  update->exec();
}

void MergeRows::CountViews(std::int64_t patch_id) {
  const Query count = target_.Sql().Prepare(sql::kCountViews);
  count->bind(1, patch_id);
  count->exec();
}

std::int64_t MergeRows::TakeAttempts(std::int64_t other_id, std::int64_t id, std::int64_t epochs) {
  const Query rows = other_.Sql().Prepare(kAttemptsThere);
  rows->bind(18, other_id);
  std::int64_t taken = 0;
  while (rows->executeStep()) {
    const Query insert = target_.Sql().Prepare(kTakeAttempt);
    for (int i = 0; i < kAttemptColumns; ++i) BindColumn(rows->getColumn(i), i + 1, *insert);
    insert->bind(kAttemptEpoch + 1, std::int64_t{rows->getColumn(kAttemptEpoch).getInt()} + epochs);
    insert->bind(18, id);
    taken += insert->exec();
  }
  if (taken > 0) LearnAnew(target_.Sql(), id, true);
  return taken;
}

int MergeRows::Supersede(std::int64_t old_id, std::int64_t new_id) {
  const Query update = target_.Sql().Prepare(kSupersede);
  update->bind(1, old_id);
  update->bind(2, new_id);
  return update->exec();
}

std::vector<NearPatch> MergeRows::PatchesNear(const Eigen::Vector3d& ground_m,
                                              double radius_m) const {
  const Query rows = target_.Sql().Prepare(kNear);
  rows->bind(1, ground_m.x() - radius_m);
  rows->bind(2, ground_m.x() + radius_m);
  rows->bind(3, ground_m.y() - radius_m);
  rows->bind(4, ground_m.y() + radius_m);
  std::vector<NearPatch> near;
  while (rows->executeStep()) {
    // The index holds floats, rounded outwards: half a metre at 5000 km.
    const double distance_m = std::hypot(rows->getColumn(3).getDouble() - ground_m.x(),
                                         rows->getColumn(4).getDouble() - ground_m.y());
    if (!(distance_m <= radius_m)) continue;
    near.push_back({rows->getColumn(0).getInt64(), distance_m, rows->getColumn(5).getDouble(),
                    PngWidth(rows->getColumn(6)), rows->getColumn(1).getString() == "active",
                    TextOf(rows->getColumn(2))});
  }
  std::stable_sort(near.begin(), near.end(), [](const NearPatch& a, const NearPatch& b) {
    return a.distance_m < b.distance_m;
  });
  return near;
}

void MergeRows::Remember(const Patch& patch, std::int64_t id) {
  id_here_[patch.id] = id;
  if (patch.superseded_by != 0) successor_there_[patch.id] = patch.superseded_by;
}

void MergeRows::LinkSuccessors() {
  std::erase_if(successor_there_, [this](const auto& link) {
    const auto here = id_here_.find(link.first), next = id_here_.find(link.second);
    if (here == id_here_.end() || next == id_here_.end()) return false;
    const Query update = target_.Sql().Prepare(kLink);
    update->bind(1, here->second);
    update->bind(2, next->second);
    update->exec();
    return true;
  });
}

}  // namespace orient::patchdb

#include "patchdb/maintenance/merge_rows.h"

#include "patchdb/connection.h"
#include "patchdb/learn.h"
#include "patchdb/patch_rows.h"
#include "patchdb/statements.h"

namespace orient {
namespace {

constexpr const char* kSourceDate = "SELECT id, date FROM sources WHERE kind = ?1 AND name = ?2";
constexpr const char* kSetLife =
    "UPDATE patches SET state = ?2, retired_reason = ?3, retired_on = iif(?2 = 'retired', "
    "date('now'), NULL), epoch = ?4, created = coalesce(?5, created) WHERE id = ?1";
constexpr const char* kSetSource = "UPDATE patches SET source_id = ?2 WHERE id = ?1";
constexpr const char* kSupersede =
    "UPDATE patches SET state = 'retired', retired_reason = 'superseded by a newer view', "
    "retired_on = date('now'), superseded_by = ?2 WHERE id = ?1 AND id <> ?2 AND state = 'active'";
constexpr const char* kLink =
    "UPDATE patches SET superseded_by = ?2 WHERE id = ?1 AND id <> ?2 AND state = 'retired' AND "
    "superseded_by IS NULL";
constexpr const char* kNear =
    "SELECT p.id, p.state, s.date, r.minx, r.miny FROM rtree_patches_geom AS r JOIN patches AS p "
    "ON "
    "p.id = r.id JOIN sources AS s ON s.id = p.source_id WHERE r.maxx >= ?1 AND r.minx <= ?2 AND "
    "r.maxy >= ?3 AND r.miny <= ?4 AND p.superseded_by IS NULL";
#define ORIENT_ATTEMPT_COLUMNS                                                              \
  "photo, state, ncc, residual_col_px, residual_row_px, reason, photo_date, photo_status, " \
  "recorded, epoch, predicted_col_px, predicted_row_px, found_col_px, found_row_px, "       \
  "neighbours_sought, neighbours_matched"
constexpr int kAttemptColumns = 16;
constexpr const char* kAttemptsThere =
    "SELECT " ORIENT_ATTEMPT_COLUMNS " FROM attempts WHERE patch_id = ?17";
// The newer stays; of two without a date the one that is here.
constexpr const char* kTakeAttempt =
    "INSERT INTO attempts (" ORIENT_ATTEMPT_COLUMNS
    ", patch_id) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, "
    "?17) ON CONFLICT (patch_id, photo) DO UPDATE SET (" ORIENT_ATTEMPT_COLUMNS
    ") = (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16) "
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
  Connection& connection = target_.Sql();
  PatchSource here = source;
  for (int number = 2;; ++number) {
    const Query row = connection.Prepare(kSourceDate);
    row->bind(1, Name(here.kind));
    row->bind(2, here.name);
    if (!row->executeStep()) break;
    const auto date = row->getColumn(1).isNull()
                          ? std::nullopt
                          : std::optional<std::string>(row->getColumn(1).getString());
    if (date == here.date) {
      const std::int64_t id = row->getColumn(0).getInt64();
      source_here_[source.id] = id;
      return {id, false};
    }
    here.name = source.name + " (" + std::to_string(number) + ")";
  }
  const Query insert = connection.Prepare(sql::kAddSource);
  BindSource(here, *insert);
  insert->exec();
  const std::int64_t id = connection.Database().getLastInsertRowid();
  source_here_[source.id] = id;
  return {id, true};
}

std::int64_t MergeRows::SourceIdFor(std::int64_t other_id) {
  const auto known = source_here_.find(other_id);
  if (known != source_here_.end()) return known->second;
  for (const PatchSource& source : other_.Sources())
    if (source.id == other_id) return SourceFor(source).first;
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
  const Query life = connection.Prepare(kSetLife);
  life->bind(1, id);
  life->bind(2, Name(patch.life));
  if (patch.life == PatchLife::kRetired) life->bind(3, patch.retired_reason);
  life->bind(4, patch.epoch);
  if (patch.created) life->bind(5, *patch.created);
  life->exec();
  for (const PatchEvidence& evidence : patch.evidence) AddEvidence(id, evidence);
  if (!patch.evidence.empty()) CountViews(id);
  target_.GrowExtent(patch.ground_m.head<2>());
  Remember(patch.id, id);
  if (patch.superseded_by != 0) successor_there_[patch.id] = patch.superseded_by;
  return id;
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

void MergeRows::AddEvidence(std::int64_t patch_id, const PatchEvidence& evidence) {
  const Query insert = target_.Sql().Prepare(sql::kAddEvidence);
  BindEvidence(patch_id, evidence.source_id, evidence, *insert);
  insert->exec();
}

void MergeRows::CountViews(std::int64_t patch_id) {
  const Query count = target_.Sql().Prepare(sql::kCountViews);
  count->bind(1, patch_id);
  count->exec();
}

std::int64_t MergeRows::TakeAttempts(std::int64_t other_id, std::int64_t id) {
  const Query rows = other_.Sql().Prepare(kAttemptsThere);
  rows->bind(17, other_id);
  std::int64_t taken = 0;
  while (rows->executeStep()) {
    const Query insert = target_.Sql().Prepare(kTakeAttempt);
    for (int i = 0; i < kAttemptColumns; ++i) BindColumn(rows->getColumn(i), i + 1, *insert);
    insert->bind(17, id);
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

std::vector<NearPatch> MergeRows::DatedPatchesNear(const Eigen::Vector3d& ground_m,
                                                   double radius_m) const {
  const Query rows = target_.Sql().Prepare(kNear);
  rows->bind(1, ground_m.x() - radius_m);
  rows->bind(2, ground_m.x() + radius_m);
  rows->bind(3, ground_m.y() - radius_m);
  rows->bind(4, ground_m.y() + radius_m);
  std::vector<std::pair<double, NearPatch>> found;
  while (rows->executeStep()) {
    const double distance_m = std::hypot(rows->getColumn(3).getDouble() - ground_m.x(),
                                         rows->getColumn(4).getDouble() - ground_m.y());
    // The index holds floats, good to a part in ten million.
    if (distance_m > radius_m + 1e-6 * ground_m.head<2>().norm()) continue;
    NearPatch near{rows->getColumn(0).getInt64(), rows->getColumn(1).getString() == "active", {}};
    if (!rows->getColumn(2).isNull()) near.source_date = rows->getColumn(2).getString();
    found.emplace_back(distance_m, near);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<NearPatch> near;
  near.reserve(found.size());
  for (auto& [distance, patch] : found) near.push_back(std::move(patch));
  return near;
}

std::vector<std::int64_t> MergeRows::PatchesNear(const Eigen::Vector3d& ground_m,
                                                 double radius_m) const {
  std::vector<std::int64_t> ids;
  for (const NearPatch& near : DatedPatchesNear(ground_m, radius_m)) ids.push_back(near.id);
  return ids;
}

int MergeRows::LinkSuccessors() {
  int linked = 0;
  for (const auto& [patch, successor] : successor_there_) {
    const auto here = id_here_.find(patch), next = id_here_.find(successor);
    if (here == id_here_.end() || next == id_here_.end()) continue;
    const Query update = target_.Sql().Prepare(kLink);
    update->bind(1, here->second);
    update->bind(2, next->second);
    linked += update->exec();
  }
  return linked;
}

}  // namespace orient

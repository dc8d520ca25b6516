#include "patchdb/maintenance/life.h"

#include "patchdb/store/connection.h"
#include "patchdb/store/learn.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {
namespace {

constexpr const char* kRestore =
    "UPDATE patches SET state = 'active', retired_reason = NULL, retired_on = NULL, "
    "superseded_by = NULL, epoch = epoch + 1 WHERE id = ?1 AND state = 'retired'";
constexpr const char* kForgetAttempts =
    "DELETE FROM attempts WHERE patch_id = (SELECT id FROM patches WHERE id = ?1 AND state = "
    "'retired')";
constexpr const char* kForgetEvidence =
    "DELETE FROM evidence WHERE patch_id = (SELECT id FROM patches WHERE id = ?1 AND state = "
    "'retired')";
constexpr const char* kMarkDoomed =
    "INSERT OR IGNORE INTO temp.doomed SELECT id FROM patches WHERE id = ?1 AND state = 'retired'";
constexpr const char* kForgetSuccessors =
    "UPDATE patches SET superseded_by = NULL WHERE superseded_by IN (SELECT id FROM temp.doomed)";
constexpr const char* kDelete = "DELETE FROM patches WHERE id IN (SELECT id FROM temp.doomed)";

int Execute(Connection& connection, const char* sql, std::int64_t id) {
  const Query statement = connection.Prepare(sql);
  statement->bind(1, id);
  return statement->exec();
}

}  // namespace

int RetirePatches(PatchDatabase& database, const std::vector<std::int64_t>& ids,
                  const std::string& reason) {
  return database.Write("retiring patches", [&](Connection& connection) {
    int changed = 0;
    for (const std::int64_t id : ids) {
      const Query retire = connection.Prepare(sql::kRetire);
      retire->bind(1, id);
      retire->bind(2, reason);
      changed += retire->exec();
    }
    return changed;
  });
}

int RestorePatches(PatchDatabase& database, const std::vector<std::int64_t>& ids) {
  return database.Write("restoring patches", [&](Connection& connection) {
    int changed = 0;
    for (const std::int64_t id : ids) {
      if (Execute(connection, kRestore, id) == 0) continue;
      ++changed;
      LearnAnew(connection, id, false);
    }
    return changed;
  });
}

int DeleteRetiredPatches(PatchDatabase& database, const std::vector<std::int64_t>& ids) {
  return database.Write("deleting patches", [&](Connection& connection) {
    SQLite::Database& file = connection.Database();
    file.exec("CREATE TEMP TABLE IF NOT EXISTS doomed (id INTEGER PRIMARY KEY)");
    file.exec("DELETE FROM temp.doomed");
    for (const std::int64_t id : ids) {
      Execute(connection, kForgetAttempts, id);
      Execute(connection, kForgetEvidence, id);
      Execute(connection, kMarkDoomed, id);
    }
    file.exec(kForgetSuccessors);
    return file.exec(kDelete);
  });
}

}  // namespace orient::patchdb

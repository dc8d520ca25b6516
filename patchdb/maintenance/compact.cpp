#include "patchdb/maintenance/compact.h"

#include <filesystem>

#include "patchdb/store/connection.h"

namespace orient::patchdb {
namespace {

bool HasOldPages(Connection& connection) {
  return connection.Number("PRAGMA page_size") != kPageSize;
}

// SQLite changes the page size only without a write-ahead log: while this object exists, the file
// has a rollback journal instead, which also undoes what a killed program left half done.
class WithoutLog {
 public:
  explicit WithoutLog(SQLite::Database& file) : file_(file) {
    file_.exec("PRAGMA journal_mode = DELETE");
  }
  ~WithoutLog() {
    try {
      file_.exec("PRAGMA journal_mode = WAL");
    } catch (const std::exception&) {
      // Another program is reading: the next one that opens the file for writing switches back.
    }
  }
  WithoutLog(const WithoutLog&) = delete;
  WithoutLog& operator=(const WithoutLog&) = delete;

 private:
  SQLite::Database& file_;
};

// False where another program has the file open.
bool RenewPages(SQLite::Database& file) {
  try {
    const WithoutLog without_log(file);
    file.exec("PRAGMA page_size = " + std::to_string(kPageSize));
    file.exec("VACUUM");
    return true;
  } catch (const SQLite::Exception& error) {
    if (error.getErrorCode() != SQLITE_BUSY && error.getErrorCode() != SQLITE_LOCKED) throw;
    return false;
  }
}

}  // namespace

CompactResult CompactDatabase(PatchDatabase& database) {
  namespace fs = std::filesystem;
  return WithFile(database.Sql(), "compacting", [&] {
    CompactResult result;
    Connection& connection = database.Sql();
    SQLite::Database& file = connection.Database();
    file.exec("PRAGMA wal_checkpoint(TRUNCATE)");
    result.before = fs::file_size(database.Path());
    if (!HasOldPages(connection) || !RenewPages(file)) file.exec("VACUUM");
    result.old_pages = HasOldPages(connection);
    file.exec("PRAGMA optimize");
    file.exec("PRAGMA wal_checkpoint(TRUNCATE)");
    result.after = fs::file_size(database.Path());
    return result;
  });
}

}  // namespace orient::patchdb

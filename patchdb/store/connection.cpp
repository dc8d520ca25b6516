#include "patchdb/store/connection.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cctype>
#include <filesystem>
#include <iomanip>
#include <sstream>
#include <string_view>

#include "core/base/environment_error.h"
#include "patchdb/store/geopackage_geometry.h"
#include "patchdb/store/lock_holder.h"

namespace orient::patchdb {
namespace {

int OpenFlags(Connection::Mode mode) {
  switch (mode) {
    case Connection::Mode::kCreate:
      return SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE;
    case Connection::Mode::kWrite:
      return SQLite::OPEN_READWRITE;
    case Connection::Mode::kRead:
      break;
  }
  return SQLite::OPEN_READONLY;
}

// Whether part of what was written is not in the file itself.
bool HasLog(const std::string& path) {
  for (const char* suffix : {"-wal", "-journal"}) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path + suffix, error);
    if (!error && size > 0) return true;
  }
  return false;
}

// SQLite's URI for a file that no program can be writing.
std::string ImmutableUri(const std::string& path) {
  std::ostringstream uri;
  uri << "file:" << std::hex << std::uppercase << std::setfill('0');
  for (const char c : path)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '/' || c == '.' || c == '-')
      uri << c;
    else
      uri << '%' << std::setw(2) << static_cast<int>(static_cast<unsigned char>(c));
  uri << "?immutable=1";
  return uri.str();
}

// A reader cannot remove the log that SQLite made for it, or that a killed writer left.
void RemoveLog(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path + "-wal", error)) return;
  try {
    SQLite::Database(path, SQLite::OPEN_READWRITE).exec("PRAGMA schema_version");
  } catch (const std::exception&) {
    // We may not write the file; the next program that does removes the log.
  }
}

// Undoes what a killed writer left half done outside of the write-ahead log (patchdb/maintenance/
// compact.cpp): a read-only connection cannot.
void RollBack(const std::string& path, int wait_ms) {
  SQLite::Database(path, SQLite::OPEN_READWRITE, wait_ms).exec("BEGIN IMMEDIATE; ROLLBACK");
}

// Triggers here maintain the spatial index, the content token and the feature count. One that does
// anything else is foreign, whatever its name, as is one that queries endlessly.
// `within`: the trigger, or a named part of a statement. Triggers with other names than
// these are not admitted (migration.h).
int AuthorizeTrigger(void*, int action, const char* table, const char*, const char*,
                     const char* within) {
  const std::string_view trigger = within == nullptr ? "" : within;
  const bool is_trigger = trigger.starts_with("rtree_") || trigger.starts_with("trigger_") ||
                          trigger.starts_with("orient_content_");
  if (!is_trigger || action == SQLITE_READ || action == SQLITE_FUNCTION) return SQLITE_OK;
  const bool changes =
      action == SQLITE_INSERT || action == SQLITE_UPDATE || action == SQLITE_DELETE;
  const std::string_view name = table == nullptr ? "" : table;
  const bool kept =
      name == "rtree_patches_geom" || name == "orient_content" || name == "gpkg_ogr_contents";
  return changes && kept ? SQLITE_OK : SQLITE_DENY;
}

// Whether the file and its log may be opened, so that only the machine can be the cause.
bool MayBeOpened(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const auto may = [](const std::string& what, int how) {
    return faccessat(AT_FDCWD, what.c_str(), how, AT_EACCESS) == 0;
  };
  return may(path, R_OK | W_OK) && may(folder.empty() ? "." : folder, W_OK | X_OK);
}

// Error number of the last failed system call; 0: none.
int ErrorOf(sqlite3* database, int which_file) {
  sqlite3_file* file = nullptr;
  int error = 0;
  if (sqlite3_file_control(database, "main", which_file, &file) == SQLITE_OK && file != nullptr &&
      file->pMethods != nullptr)
    file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &error);
  return error;
}

}  // namespace

void ThrowErrorOfFile(const std::string& path, const char* doing, const SQLite::Exception& error) {
  switch (error.getErrorCode()) {
    case SQLITE_NOTADB:
      throw InputError(path +
                       " is not a patch database; name one made with 'orient patchdb create'");
    case SQLITE_BUSY: {
      const std::string holder = LockHolder(path);
      throw InputError(fmt::format(
          "{}: {} fails: the database is being written by {}; try again when it has finished", path,
          doing, holder.empty() ? "another program" : holder));
    }
    case SQLITE_FULL:
      throw EnvironmentError(
          fmt::format("{}: {} fails: the disk is full; nothing was stored", path, doing));
    case SQLITE_IOERR:
      throw EnvironmentError(
          fmt::format("{}: {} fails: the disk is full, or cannot be read or written ({})", path,
                      doing, error.what()));
    case SQLITE_CORRUPT:
      throw InputError(fmt::format(
          "{}: {} fails: the file is damaged ({}); take a copy of it from elsewhere, or save what "
          "can be read with 'orient patchdb export --subset'",
          path, doing, error.what()));
    case SQLITE_AUTH:
      throw InputError(fmt::format(
          "{}: {} fails: it holds a trigger that does not belong to a patch database; copy the "
          "patches without it: 'orient patchdb export FILE --subset NEW'",
          path, doing));
    case SQLITE_NOMEM:
      throw EnvironmentError(
          fmt::format("{}: {} fails: out of memory; use fewer --jobs", path, doing));
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
      if (MayBeOpened(path))
        throw EnvironmentError(fmt::format(
            "{}: {} fails: {}, though you may write it; is the disk full, are too many files open?",
            path, doing, error.what()));
      throw InputError(fmt::format(
          "{}: {} fails: {}; the file and its folder must be readable, and writable for commands "
          "that write or where a program that was killed left a -wal file",
          path, doing, error.what()));
    default:
      throw InputError(fmt::format("{}: {} fails: {}", path, doing, error.what()));
  }
}

Connection::Connection(const std::string& path, Mode mode, double wait_s)
    : path_(path), mode_(mode) {
  WithFile(*this, "opening the database", [&] {
    const int wait_ms = static_cast<int>(1000 * wait_s);
    database_ = std::make_unique<SQLite::Database>(path, OpenFlags(mode), wait_ms);
    try {
      Set();
    } catch (const SQLite::Exception& error) {
      // Even a reader needs space for the log's index, unless no program can be writing.
      const int code = error.getErrorCode();  // SQLITE_IOERR, below: if the disk is full
      const bool no_place =
          code == SQLITE_CANTOPEN || code == SQLITE_READONLY || code == SQLITE_IOERR;
      if (mode != Mode::kRead || !no_place) throw;
      database_.reset();
      immutable_ = !HasLog(path);
      if (!immutable_) RollBack(path, wait_ms);
      database_ = std::make_unique<SQLite::Database>(
          immutable_ ? ImmutableUri(path) : path,
          SQLite::OPEN_READONLY | (immutable_ ? SQLite::OPEN_URI : 0), wait_ms);
      Set();
    }
  });
}

// A file from elsewhere may hold any view, trigger or table. Views are never run, triggers only by
// writers (migration.h says which) and only as far as they do what ours do, and values larger than
// any in a patch database are refused.
void Connection::Harden() {
  constexpr int kMostBytes = 64 << 20;
  sqlite3* handle = database_->getHandle();
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_ENABLE_TRIGGER, mode_ == Mode::kRead ? 0 : 1, nullptr);
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, kMostBytes);
  sqlite3_set_authorizer(handle, AuthorizeTrigger, nullptr);
}

void Connection::Set() {
  RegisterSpatialFunctions(database_->getHandle());
  Harden();
  // Writing needs its triggers to reach the R-tree, which SQLite does not count as innocuous.
  if (mode_ == Mode::kRead) database_->exec("PRAGMA trusted_schema = OFF");
  database_->exec("PRAGMA cell_size_check = ON");
  // Takes effect only in a file that is still empty.
  if (mode_ == Mode::kCreate) database_->exec("PRAGMA page_size = " + std::to_string(kPageSize));
  // Permanently: to change it, a writer would have to wait for every reader.
  if (mode_ != Mode::kRead) database_->exec("PRAGMA journal_mode = WAL");
  database_->exec("PRAGMA foreign_keys = ON");
  database_->exec("PRAGMA schema_version");  // the first access to the file
  // SQLite opens a write-protected file for reading, and reports that only at the first write.
  if (mode_ != Mode::kRead && sqlite3_db_readonly(database_->getHandle(), "main") == 1)
    throw SQLite::Exception("it may only be read", SQLITE_READONLY);
}

Connection::~Connection() {
  statements_.clear();
  if (!database_) return;
  try {
    if (mode_ != Mode::kRead) {
      database_->setBusyTimeout(0);
      database_->exec("PRAGMA wal_checkpoint(TRUNCATE)");
    }
    database_.reset();
  } catch (const std::exception&) {
    // A reader holds an older state: the last one to close moves the log into the file.
  }
  if (mode_ == Mode::kRead && !immutable_) RemoveLog(path_);
}

Query Connection::Prepare(const char* sql) {
  auto found = statements_.find(sql);
  if (found == statements_.end())
    found = statements_.emplace(sql, SQLite::Statement(*database_, sql)).first;
  found->second.reset();
  found->second.clearBindings();
  return Query(found->second);
}

bool Connection::DeviceFailed() const {
  if (!database_) return false;
  sqlite3* handle = database_->getHandle();
  return IsOfEnvironment(ErrorOf(handle, SQLITE_FCNTL_FILE_POINTER)) ||
         IsOfEnvironment(ErrorOf(handle, SQLITE_FCNTL_JOURNAL_POINTER));
}

std::int64_t Connection::Number(const char* sql) {
  SQLite::Statement statement(*database_, sql);
  return statement.executeStep() ? statement.getColumn(0).getInt64() : 0;
}

}  // namespace orient::patchdb

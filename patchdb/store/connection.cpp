#include "patchdb/store/connection.h"

#include <cctype>
#include <filesystem>
#include <iomanip>
#include <sstream>

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

// What was written is not all in the file itself.
bool HasLog(const std::string& path) {
  for (const char* suffix : {"-wal", "-journal"}) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path + suffix, error);
    if (!error && size > 0) return true;
  }
  return false;
}

// SQLite's URI of a file that nobody can be writing.
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

// A reader may not remove the log that it had SQLite make, or that a killed writer left.
void RemoveLog(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path + "-wal", error)) return;
  try {
    SQLite::Database(path, SQLite::OPEN_READWRITE).exec("PRAGMA schema_version");
  } catch (const std::exception&) {
    // Not ours to write; whoever writes next removes it.
  }
}

// What a writer that was killed left half done outside of the write-ahead log (patchdb/maintenance/
// compact.cpp): a read-only connection may not undo it.
void RollBack(const std::string& path, int wait_ms) {
  SQLite::Database(path, SQLite::OPEN_READWRITE, wait_ms).exec("BEGIN IMMEDIATE; ROLLBACK");
}

}  // namespace

InputError ErrorOfFile(const std::string& path, const char* doing, const SQLite::Exception& error) {
  std::string text = path;
  switch (error.getErrorCode()) {
    case SQLITE_NOTADB:
      return InputError(path +
                        " is not a patch database; name one made with 'orient patchdb create'");
    case SQLITE_BUSY: {
      const std::string holder = LockHolder(path);
      text += ": ";
      text += doing;
      text += " fails: the database is being written by ";
      text += holder.empty() ? "another program" : holder;
      text += "; try again when it has finished";
      return InputError(text);
    }
    case SQLITE_FULL:
      text += ": ";
      text += doing;
      text += " fails: the disk is full; nothing was stored";
      return InputError(text);
    case SQLITE_IOERR:
      text += ": ";
      text += doing;
      text += " fails: the disk is full, or cannot be read or written (";
      text += error.what();
      text += ")";
      return InputError(text);
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
      text += ": ";
      text += doing;
      text += " fails: ";
      text += error.what();
      text +=
          "; the file and its folder must be readable, and writable for commands that write or "
          "where a program that was killed left a -wal file";
      return InputError(text);
    default:
      text += ": ";
      text += doing;
      text += " fails: ";
      text += error.what();
      return InputError(text);
  }
}

Connection::Connection(const std::string& path, Mode mode, double wait_s)
    : path_(path), mode_(mode) {
  WithFile(path, "opening the database", [&] {
    const int wait_ms = static_cast<int>(1000 * wait_s);
    database_ = std::make_unique<SQLite::Database>(path, OpenFlags(mode), wait_ms);
    try {
      Set();
    } catch (const SQLite::Exception& error) {
      // Even a reader needs a place for the log's index, unless nobody can be writing.
      const int code = error.getErrorCode();  // the last: of a disk that is full
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

void Connection::Set() {
  RegisterSpatialFunctions(database_->getHandle());
  // A file from elsewhere may hold any view. Writing needs its triggers to reach the R-tree,
  // which SQLite does not count as innocuous.
  if (mode_ == Mode::kRead) database_->exec("PRAGMA trusted_schema = OFF");
  database_->exec("PRAGMA cell_size_check = ON");
  // Of effect in a file that is still empty only.
  if (mode_ == Mode::kCreate) database_->exec("PRAGMA page_size = " + std::to_string(kPageSize));
  // For good: to change it a writer would have to wait for every reader.
  if (mode_ != Mode::kRead) database_->exec("PRAGMA journal_mode = WAL");
  database_->exec("PRAGMA foreign_keys = ON");
  database_->exec("PRAGMA schema_version");  // the first look into the file
  // SQLite opens what it may not write for reading, and says so at the first row to be written.
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
    // A reader holds an older state: the one that closes last does it.
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

std::int64_t Connection::Number(const char* sql) {
  SQLite::Statement statement(*database_, sql);
  return statement.executeStep() ? statement.getColumn(0).getInt64() : 0;
}

}  // namespace orient::patchdb

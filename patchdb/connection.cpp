#include "patchdb/connection.h"

#include "patchdb/geopackage_geometry.h"
#include "patchdb/lock_holder.h"

namespace orient {
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
      text += "; try again when it is through";
      return InputError(text);
    }
    case SQLITE_FULL:
      text += ": ";
      text += doing;
      text += " fails: the disk is full; nothing of it was stored";
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
    database_ =
        std::make_unique<SQLite::Database>(path, OpenFlags(mode), static_cast<int>(1000 * wait_s));
    RegisterSpatialFunctions(database_->getHandle());
    // A file from elsewhere may hold any view. Writing needs its triggers to reach the R-tree,
    // which SQLite does not count as innocuous.
    if (mode == Mode::kRead) database_->exec("PRAGMA trusted_schema = OFF");
    database_->exec("PRAGMA cell_size_check = ON");
    if (mode == Mode::kWrite) database_->exec("PRAGMA journal_mode = WAL");
    database_->exec("PRAGMA foreign_keys = ON");
  });
}

Connection::~Connection() {
  statements_.clear();
  if (mode_ != Mode::kWrite || !database_) return;
  try {
    database_->setBusyTimeout(0);
    database_->exec("PRAGMA journal_mode = DELETE");
  } catch (const std::exception&) {
    // Another program has the file open: it stays in WAL mode, which is valid too.
  }
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

}  // namespace orient

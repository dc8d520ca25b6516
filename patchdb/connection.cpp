#include "patchdb/connection.h"

#include "patchdb/geopackage_geometry.h"

namespace orient {
namespace {

constexpr int kBusyTimeoutMs = 10000;

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

Connection::Connection(const std::string& path, Mode mode) : path_(path), mode_(mode) {
  WithFile(path, "opening the database", [&] {
    database_ = std::make_unique<SQLite::Database>(path, OpenFlags(mode), kBusyTimeoutMs);
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

// One SQLite connection as the patch database wants it: busy timeout, write-ahead log, foreign
// keys, the spatial functions, and prepared statements. Private to patchdb.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace orient::patchdb {

inline constexpr double kDefaultWait_s = 30;
// Of a new file: a dozen patches of some 2.5 kB a page. Of SQLite's own pages of 4 kB a third would
// stay empty.
inline constexpr int kPageSize = 32768;

// A prepared statement in use. Reset when it dies: an unfinished SELECT would hold its snapshot.
class Query {
 public:
  explicit Query(SQLite::Statement& statement) : statement_(&statement) {}
  ~Query() { statement_->tryReset(); }
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;
  SQLite::Statement* operator->() const { return statement_; }
  SQLite::Statement& operator*() const { return *statement_; }

 private:
  SQLite::Statement* statement_;
};

class Connection {
 public:
  enum class Mode { kCreate, kRead, kWrite };
  // `wait_s`: how long a statement waits for another program's transaction.
  Connection(const std::string& path, Mode mode, double wait_s = kDefaultWait_s);
  // Moves the log into the file, so that the last one that closes leaves one file that is whole.
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  const std::string& Path() const { return path_; }
  SQLite::Database& Database() { return *database_; }
  // Prepared once a text; without bindings.
  Query Prepare(const char* sql);
  std::int64_t Number(const char* sql);  // of the first row and column; NULL is 0
  // Whether the file could not be read: SQLite then calls it damaged.
  bool DeviceFailed() const;

 private:
  void Harden();
  void Set();

  std::string path_;
  Mode mode_;
  bool immutable_ = false;
  std::unique_ptr<SQLite::Database> database_;
  std::map<std::string, SQLite::Statement> statements_;
};

// What a user can do about an error of SQLite: InputError (who holds the file, that it is damaged),
// EnvironmentError where the disk is full or cannot be read, or memory is out.
[[noreturn]] void ThrowErrorOfFile(const std::string& path, const char* doing,
                                   const SQLite::Exception& error);

// Runs `work`; what SQLite throws becomes an error naming the file and what was being done.
template <typename Work>
auto WithFile(const std::string& path, const char* doing, Work&& work) {
  try {
    return work();
  } catch (const SQLite::Exception& error) {
    ThrowErrorOfFile(path, doing, error);
  }
}

// The same with a file that is open.
template <typename Work>
auto WithFile(const Connection& connection, const char* doing, Work&& work) {
  try {
    return work();
  } catch (const SQLite::Exception& error) {
    const bool device = error.getErrorCode() == SQLITE_CORRUPT && connection.DeviceFailed();
    ThrowErrorOfFile(connection.Path(), doing,
                     device ? SQLite::Exception(error.what(), SQLITE_IOERR) : error);
  }
}

}  // namespace orient::patchdb

#include "patchdb/patch_database.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "core/error.h"
#include "patchdb/connection.h"
#include "patchdb/patch_rows.h"
#include "patchdb/schema.h"
#include "patchdb/statements.h"

namespace orient {
namespace fs = std::filesystem;
namespace {

constexpr int kFirstPrivateSrsId = 100000;  // for a CRS without an EPSG code

int AddCrs(Connection& connection, const Crs& crs) {
  const auto epsg = crs.Epsg();
  const int id = epsg.value_or(kFirstPrivateSrsId);
  const Query statement = connection.Prepare(sql::kAddCrs);
  statement->bind(1, crs.Name().empty() ? "unnamed" : crs.Name());
  statement->bind(2, id);
  statement->bind(3, epsg ? "EPSG" : "NONE");
  statement->bind(4, id);
  statement->bind(5, crs.Wkt1());
  statement->bind(6, "ground coordinates of the patches");
  statement->exec();
  return id;
}

// Runs the steps after `version`; the caller holds the transaction.
void RunSchemaSteps(Connection& connection, int version) {
  for (const SchemaStep& step : SchemaSteps()) {
    if (step.version <= version) continue;
    connection.Database().exec(step.sql);
    const Query record = connection.Prepare(sql::kAddSchemaStep);
    record->bind(1, step.version);
    record->bind(2, step.description);
    record->exec();
  }
}

void WriteNewDatabase(const std::string& path, const Crs& crs) {
  Connection connection(path, Connection::Mode::kCreate);
  SQLite::Database& database = connection.Database();
  database.exec("PRAGMA application_id = " + std::to_string(kGeoPackageApplicationId));
  database.exec("PRAGMA user_version = " + std::to_string(kGeoPackageVersion));
  SQLite::Transaction transaction(database);
  RunSchemaSteps(connection, 0);
  const int srs_id = AddCrs(connection, crs);
  for (const char* sql : {sql::kRegisterPatches, sql::kRegisterPatchGeometry}) {
    const Query statement = connection.Prepare(sql);
    statement->bind(1, srs_id);
    statement->exec();
  }
  database.exec(sql::kRegisterAttributes);
  transaction.commit();
}

// The version of the file's schema. Throws InputError where it is no patch database, or newer.
int CheckedSchemaVersion(Connection& connection, const std::string& path) {
  if (connection.Number("PRAGMA application_id") != kGeoPackageApplicationId)
    throw InputError(path + " is not a GeoPackage; give a file made by 'orient patchdb create'");
  if (connection.Number(sql::kHasSchemaTable) != 1)
    throw InputError(path + " is a GeoPackage but not a patch database (it has no table " +
                     "orient_schema); give a file made by 'orient patchdb create'");
  const auto version = connection.Number(sql::kSchemaVersion);
  if (version < 1) throw InputError(path + " is damaged: table orient_schema is empty");
  if (version > CurrentSchemaVersion())
    throw InputError(path + " has schema version " + std::to_string(version) +
                     ", this program knows " + std::to_string(CurrentSchemaVersion()) +
                     " at most; use a newer Orient");
  return static_cast<int>(version);
}

void BringUpToDate(Connection& connection, int version, const std::string& path,
                   PatchDatabase::Mode mode) {
  if (version == CurrentSchemaVersion()) return;
  if (mode == PatchDatabase::Mode::kRead)
    throw InputError(path + " has the older schema version " + std::to_string(version) +
                     ", this program uses " + std::to_string(CurrentSchemaVersion()) +
                     "; any command that writes to it brings it up to date");
  SQLite::Transaction transaction(connection.Database());
  RunSchemaSteps(connection, version);
  transaction.commit();
}

struct GroundSystem {
  int srs_id;
  Crs crs;
};

GroundSystem ReadGroundSystem(Connection& connection, const std::string& path) {
  const Query row = connection.Prepare(sql::kGroundCrs);
  if (!row->executeStep()) throw InputError(path + " is damaged: it does not name its CRS");
  return {row->getColumn(0).getInt(), Crs::Parse(row->getColumn(1).getString(), path)};
}

Bounds BoundsOf(const std::vector<Patch>& patches) {
  const Eigen::Vector3d& first = patches.front().ground_m;
  Bounds bounds{first.x(), first.y(), first.x(), first.y()};
  for (const Patch& patch : patches) {
    bounds.min_x = std::min(bounds.min_x, patch.ground_m.x());
    bounds.min_y = std::min(bounds.min_y, patch.ground_m.y());
    bounds.max_x = std::max(bounds.max_x, patch.ground_m.x());
    bounds.max_y = std::max(bounds.max_y, patch.ground_m.y());
  }
  return bounds;
}

// The first four parameters of the statements that ask for a rectangle.
void BindBounds(const Bounds& bounds, SQLite::Statement& statement) {
  statement.bind(1, bounds.min_x);
  statement.bind(2, bounds.max_x);
  statement.bind(3, bounds.min_y);
  statement.bind(4, bounds.max_y);
}

std::vector<Patch> ReadPatches(SQLite::Statement& rows, const std::string& path) {
  std::vector<Patch> patches;
  try {
    while (rows.executeStep()) patches.push_back(ReadPatchRow(rows));
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what());
  }
  return patches;
}

}  // namespace

struct PatchDatabase::Impl {
  std::string path;
  Mode mode;
  mutable Connection connection;
  GroundSystem ground;

  Impl(const std::string& file, Mode open_mode)
      : path(file),
        mode(open_mode),
        connection(file,
                   open_mode == Mode::kRead ? Connection::Mode::kRead : Connection::Mode::kWrite),
        ground(Prepare()) {}

  GroundSystem Prepare() {
    BringUpToDate(connection, CheckedSchemaVersion(connection, path), path, mode);
    return ReadGroundSystem(connection, path);
  }

  void RequireWriting() const {
    if (mode == Mode::kRead) throw std::invalid_argument(path + " was opened read-only");
  }

  void InsertSource(PatchSource& source);
  std::vector<std::int64_t> InsertPatches(const std::vector<Patch>& patches,
                                          std::int64_t source_id);
  void GrowExtent(const std::vector<Patch>& patches);
};

void PatchDatabase::Impl::InsertSource(PatchSource& source) {
  const Query insert = connection.Prepare(sql::kAddSource);
  insert->bind(1, orient::Name(source.kind));
  insert->bind(2, source.name);
  if (source.date) insert->bind(3, *source.date);
  insert->bind(4, source.gsd_m);
  insert->exec();
  source.id = connection.Database().getLastInsertRowid();
}

std::vector<std::int64_t> PatchDatabase::Impl::InsertPatches(const std::vector<Patch>& patches,
                                                             std::int64_t source_id) {
  std::vector<std::int64_t> ids;
  for (const Patch& patch : patches) {
    const Query insert = connection.Prepare(sql::kAddPatch);
    BindPatch(patch, source_id, ground.srs_id, *insert);
    insert->exec();
    ids.push_back(connection.Database().getLastInsertRowid());
  }
  return ids;
}

void PatchDatabase::Impl::GrowExtent(const std::vector<Patch>& patches) {
  if (patches.empty()) return;
  const Bounds bounds = BoundsOf(patches);
  const Query update = connection.Prepare(sql::kGrowExtent);
  update->bind(1, bounds.min_x);
  update->bind(2, bounds.min_y);
  update->bind(3, bounds.max_x);
  update->bind(4, bounds.max_y);
  update->exec();
}

PatchDatabase::PatchDatabase(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PatchDatabase::PatchDatabase(PatchDatabase&&) noexcept = default;
PatchDatabase& PatchDatabase::operator=(PatchDatabase&&) noexcept = default;
PatchDatabase::~PatchDatabase() = default;

PatchDatabase PatchDatabase::Create(const std::string& path, const Crs& crs) {
  std::error_code error;
  if (fs::exists(path, error))
    throw InputError(path + " exists already; give another name or delete it first");
  // Made beside and renamed: a crash leaves no half database under the name that was asked for.
  const std::string unfinished = path + ".unfinished";
  fs::remove(unfinished, error);
  try {
    WithFile(path, "making the database", [&] { WriteNewDatabase(unfinished, crs); });
  } catch (const InputError&) {
    fs::remove(unfinished, error);
    throw;
  }
  fs::rename(unfinished, path, error);
  if (error) throw InputError(path + " cannot be made: " + error.message());
  return Open(path, Mode::kWrite);
}

PatchDatabase PatchDatabase::Open(const std::string& path, Mode mode) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw InputError(path + " does not exist; make it with 'orient patchdb create'");
  if (!fs::is_regular_file(path, error)) throw InputError(path + " is not a file");
  return WithFile(path, "opening the database",
                  [&] { return PatchDatabase(std::make_unique<Impl>(path, mode)); });
}

const Crs& PatchDatabase::GroundCrs() const { return impl_->ground.crs; }

PatchDatabaseInfo PatchDatabase::Info() const {
  return WithFile(impl_->path, "reading its summary", [&] {
    PatchDatabaseInfo info;
    info.crs_name = impl_->ground.crs.Name();
    info.schema_version = static_cast<int>(impl_->connection.Number(sql::kSchemaVersion));
    const Query counts = impl_->connection.Prepare(sql::kCounts);
    if (counts->executeStep()) {
      info.patches = counts->getColumn(0).getInt64();
      info.sources = counts->getColumn(1).getInt64();
      info.attempts = counts->getColumn(2).getInt64();
    }
    const Query extent = impl_->connection.Prepare(sql::kExtent);
    if (extent->executeStep() && !extent->getColumn(0).isNull())
      info.extent = {extent->getColumn(0).getDouble(), extent->getColumn(1).getDouble(),
                     extent->getColumn(2).getDouble(), extent->getColumn(3).getDouble()};
    return info;
  });
}

void PatchDatabase::AddSource(PatchSource& source, std::vector<Patch>& patches) {
  impl_->RequireWriting();
  for (const Patch& patch : patches) CheckPatch(patch);
  if (HasSource(source.kind, source.name))
    throw InputError(impl_->path + " holds patches of " + Name(source.kind) + " '" + source.name +
                     "' already; a source is harvested once");
  WithFile(impl_->path, "storing patches", [&] {
    SQLite::Transaction transaction(impl_->connection.Database(),
                                    SQLite::TransactionBehavior::IMMEDIATE);
    PatchSource stored = source;
    impl_->InsertSource(stored);
    const auto ids = impl_->InsertPatches(patches, stored.id);
    impl_->GrowExtent(patches);
    transaction.commit();
    source.id = stored.id;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      patches[i].id = ids[i];
      patches[i].source_id = stored.id;
    }
  });
}

std::vector<Patch> PatchDatabase::FindPatchesIn(const Bounds& bounds, int max_count) const {
  constexpr double kEveryPatch = 65536;
  return WithFile(impl_->path, "finding patches", [&] {
    const Query count = impl_->connection.Prepare(sql::kCountPatchesIn);
    BindBounds(bounds, *count);
    const double found = count->executeStep() ? count->getColumn(0).getDouble() : 0;
    const Query rows = impl_->connection.Prepare(sql::kPatchesIn);
    BindBounds(bounds, *rows);
    rows->bind(5, std::ceil(kEveryPatch * std::min(1.0, max_count / std::max(found, 1.0))));
    auto patches = ReadPatches(*rows, impl_->path);
    // The R-tree holds floats, rounded outwards: near the border it returns a little too much.
    std::erase_if(patches, [&](const Patch& patch) {
      return !bounds.Contains(patch.ground_m.x(), patch.ground_m.y());
    });
    return patches;
  });
}

std::vector<Patch> PatchDatabase::ListPatches(std::int64_t after_id, int count) const {
  return WithFile(impl_->path, "listing patches", [&] {
    const Query rows = impl_->connection.Prepare(sql::kPatchesAfter);
    rows->bind(1, after_id);
    rows->bind(2, count);
    return ReadPatches(*rows, impl_->path);
  });
}

std::vector<PatchSource> PatchDatabase::Sources() const {
  return WithFile(impl_->path, "listing sources", [&] {
    const Query rows = impl_->connection.Prepare(sql::kSources);
    std::vector<PatchSource> sources;
    while (rows->executeStep()) sources.push_back(ReadSourceRow(*rows));
    return sources;
  });
}

bool PatchDatabase::HasSource(SourceKind kind, const std::string& name) const {
  return WithFile(impl_->path, "looking for a source", [&] {
    const Query row = impl_->connection.Prepare(sql::kSourceId);
    row->bind(1, Name(kind));
    row->bind(2, name);
    return row->executeStep();
  });
}

void PatchDatabase::RecordAttempts(const std::vector<MatchAttempt>& attempts) {
  impl_->RequireWriting();
  WithFile(impl_->path, "recording attempts", [&] {
    SQLite::Transaction transaction(impl_->connection.Database(),
                                    SQLite::TransactionBehavior::IMMEDIATE);
    for (const MatchAttempt& attempt : attempts) {
      const Query insert = impl_->connection.Prepare(sql::kRecordAttempt);
      BindAttempt(attempt, *insert);
      insert->exec();
    }
    transaction.commit();
  });
}

}  // namespace orient

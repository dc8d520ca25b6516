#include "patchdb/store/patch_database.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/base/new_file.h"
#include "core/base/partial_files.h"
#include "core/base/reading_side_by_side.h"
#include "patchdb/store/connection.h"
#include "patchdb/store/learn.h"
#include "patchdb/store/migration.h"
#include "patchdb/store/patch_rows.h"
#include "patchdb/store/row_values.h"
#include "patchdb/store/schema.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {
namespace fs = std::filesystem;
namespace {

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
  Bounds bounds = Bounds::OfNothing();
  for (const Patch& patch : patches) bounds.Include(patch.ground_m.x(), patch.ground_m.y());
  return bounds;
}

// Binds the first four parameters of statements that query a rectangle.
void BindBounds(const Bounds& bounds, SQLite::Statement& statement) {
  statement.bind(1, bounds.min_x);
  statement.bind(2, bounds.max_x);
  statement.bind(3, bounds.min_y);
  statement.bind(4, bounds.max_y);
}

// Chips are unpacked while SQLite reads on: the one takes about as long as the other.
std::vector<Patch> ReadPatches(SQLite::Statement& rows, const std::string& path) {
  const auto next = [&rows](PackedPatch* packed) {
    if (!rows.executeStep()) return false;
    *packed = ReadPatchRow(rows);
    return true;
  };
  try {
    return WorkWhileReading<PackedPatch>(
        next, [](PackedPatch packed) { return Unpack(std::move(packed), false); });
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what());
  }
}

// Removes SQLite's own files beside a database that was not completed.
struct RemoverOfLogs {
  std::string path;
  ~RemoverOfLogs() {
    std::error_code ignored;
    for (const char* suffix : {"-wal", "-shm", "-journal"}) fs::remove(path + suffix, ignored);
  }
};

}  // namespace

struct PatchDatabase::Impl {
  std::string path;
  Mode mode;
  mutable Connection connection;
  GroundSystem ground;

  Impl(const std::string& file, Mode open_mode, double wait_s)
      : path(file),
        mode(open_mode),
        connection(file,
                   open_mode == Mode::kRead ? Connection::Mode::kRead : Connection::Mode::kWrite,
                   wait_s),
        ground(WithFile(connection, "opening the database", [&] { return Prepare(); })) {}

  GroundSystem Prepare() {
    const int version = CheckedSchemaVersion(connection, path);
    if (mode == Mode::kRead && !ReadableAsItIs(version))
      throw InputError(
          fmt::format("{} has the older schema version {}, this program uses {}; 'orient patchdb "
                      "check FILE --repair' upgrades it (on a copy if the file may not be written)",
                      path, version, CurrentSchemaVersion()));
    if (mode == Mode::kWrite) {
      RefuseForeignTriggers(connection, version, path);
      BringUpToDate(connection, version, path);
    }
    return ReadGroundSystem(connection, path);
  }

  void RequireWriting() const {
    if (mode == Mode::kRead) throw std::invalid_argument(path + " was opened read-only");
  }

  std::int64_t InsertPatch(const Patch& patch, std::int64_t source_id);
  void InsertEvidence(std::int64_t patch_id, const std::vector<PatchEvidence>& evidence);
  void GrowExtent(const Bounds& bounds);
  double Count(const char* sql, const Bounds& bounds) const;
};

double PatchDatabase::Impl::Count(const char* sql, const Bounds& bounds) const {
  const Query row = connection.Prepare(sql);
  BindBounds(bounds, *row);
  return row->executeStep() ? row->getColumn(0).getDouble() : 0;
}

std::int64_t PatchDatabase::Impl::InsertPatch(const Patch& patch, std::int64_t source_id) {
  const Query insert = connection.Prepare(sql::kAddPatch);
  BindPatch(patch, ground.srs_id, *insert);
  insert->bind(kPatchValues + 1, source_id);
  insert->exec();
  return connection.Database().getLastInsertRowid();
}

void PatchDatabase::Impl::InsertEvidence(std::int64_t patch_id,
                                         const std::vector<PatchEvidence>& evidence) {
  if (evidence.empty()) return;
  for (const PatchEvidence& view : evidence) {
    const Query insert = connection.Prepare(sql::kAddEvidence);
    BindEvidence(patch_id, view.source_id, view, *insert);
    insert->exec();
  }
  const Query count = connection.Prepare(sql::kCountViews);
  count->bind(1, patch_id);
  count->exec();
}

void PatchDatabase::Impl::GrowExtent(const Bounds& bounds) {
  if (bounds.min_x > bounds.max_x) return;
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
  return Create(path, crs, [](PatchDatabase&) {});
}

PatchDatabase PatchDatabase::Create(const std::string& path, const Crs& crs,
                                    const std::function<void(PatchDatabase&)>& fill) {
  std::error_code error;
  if (fs::exists(path, error))
    throw InputError(path + " exists already; give another name or delete it first");
  RemovePartialFiles(fs::absolute(path).parent_path().string());
  NewFile file(path);
  const RemoverOfLogs remover{file.PartialPath()};
  WithFile(path, "creating the database", [&] { WriteNewDatabase(file.PartialPath(), crs); });
  {
    PatchDatabase database = Open(file.PartialPath(), Mode::kWrite);
    fill(database);
    // Everything must be in the one file, or it is an error: it is given its name next.
    WithFile(database.Sql(), "creating the database",
             [&] { database.Sql().Database().exec("PRAGMA journal_mode = DELETE"); });
  }
  file.KeepAsNew();
  try {
    return Open(path, Mode::kWrite);
  } catch (const std::runtime_error&) {  // so that repeating the same command can succeed
    fs::remove(path, error);
    throw;
  }
}

PatchDatabase PatchDatabase::Open(const std::string& path, Mode mode, double wait_s) {
  std::error_code error;
  if (!fs::exists(path, error))
    throw InputError(path + " does not exist; create it with 'orient patchdb create'");
  if (fs::is_directory(path, error))
    throw InputError(path + " is a folder; name one of the patch databases in it");
  if (!fs::is_regular_file(path, error)) throw InputError(path + " is not a file");
  return PatchDatabase(std::make_unique<Impl>(path, mode, wait_s));
}

const std::string& PatchDatabase::Path() const { return impl_->path; }
Connection& PatchDatabase::Sql() const { return impl_->connection; }
int PatchDatabase::SrsId() const { return impl_->ground.srs_id; }
const Crs& PatchDatabase::GroundCrs() const { return impl_->ground.crs; }

PatchDatabaseInfo PatchDatabase::Info() const {
  return WithFile(impl_->connection, "reading its summary", [&] {
    PatchDatabaseInfo info;
    info.crs_name = impl_->ground.crs.Name();
    info.schema_version = static_cast<int>(impl_->connection.Number(sql::kSchemaVersion));
    const Query counts = impl_->connection.Prepare(sql::kCounts);
    if (counts->executeStep()) {
      info.patches = counts->getColumn(0).getInt64();
      info.sources = counts->getColumn(1).getInt64();
      info.attempts = counts->getColumn(2).getInt64();
      info.retired = counts->getColumn(3).getInt64();
    }
    const Query extent = impl_->connection.Prepare(sql::kExtent);
    if (extent->executeStep() && !extent->getColumn(0).isNull())
      info.extent = {extent->getColumn(0).getDouble(), extent->getColumn(1).getDouble(),
                     extent->getColumn(2).getDouble(), extent->getColumn(3).getDouble()};
    return info;
  });
}

void PatchDatabase::AddSource(PatchSource& source, std::vector<Patch>& patches) {
  StoreHarvest(source, patches, [](std::int64_t id) { return id; });
}

void PatchDatabase::AddSource(PatchSource& source, std::vector<Patch>& patches,
                              const std::vector<PatchSource>& witnesses) {
  std::vector<std::int64_t> ids(witnesses.size());  // 0: not asked for yet
  StoreHarvest(source, patches, [&](std::int64_t place) {
    std::int64_t& id = ids.at(static_cast<std::size_t>(place));
    if (id == 0) id = StoreSource(witnesses[static_cast<std::size_t>(place)], false).id;
    return id;
  });
}

void PatchDatabase::StoreHarvest(PatchSource& source, std::vector<Patch>& patches,
                                 const std::function<std::int64_t(std::int64_t)>& witness_id) {
  for (const Patch& patch : patches) CheckPatch(patch);
  PatchSource stored = source;
  std::vector<std::int64_t> ids;
  std::vector<std::vector<PatchEvidence>> evidence;
  Write("storing patches", [&](Connection&) {
    if (FindSource(source).harvested)
      throw InputError(impl_->path + " holds patches of " + Name(source.kind) + " '" + source.name +
                       "' already; a source is harvested once");
    stored = StoreSource(source, true);
    for (const Patch& patch : patches) {
      ids.push_back(impl_->InsertPatch(patch, stored.id));
      evidence.push_back(patch.evidence);
      for (PatchEvidence& of : evidence.back()) of.source_id = witness_id(of.source_id);
      impl_->InsertEvidence(ids.back(), evidence.back());
    }
    impl_->GrowExtent(BoundsOf(patches));
    return 0;
  });
  source = stored;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    patches[i].id = ids[i];
    patches[i].source_id = stored.id;
    patches[i].evidence = std::move(evidence[i]);
  }
}

PatchSource PatchDatabase::StoreSource(const PatchSource& source, bool harvested) {
  PatchSource stored = source;
  const KnownSource known = FindSource(source);
  stored.name = known.name;
  stored.id = known.id.value_or(0);
  if (known.id && (known.harvested || !harvested)) return stored;
  const Query store = impl_->connection.Prepare(known.id ? sql::kChangeSource : sql::kAddSource);
  BindSource(stored, harvested, *store);
  if (known.id) store->bind(kSourceValues + 1, *known.id);
  store->exec();
  if (!known.id) stored.id = impl_->connection.Database().getLastInsertRowid();
  return stored;
}

std::vector<Patch> PatchDatabase::FindPatchesIn(const Bounds& bounds, int max_count) const {
  constexpr double kEveryPatch = 65536;
  return WithFile(impl_->connection, "finding patches", [&] {
    // Retired ones are told apart only if it matters, as the index alone does not know them.
    double found = impl_->Count(sql::kCountPatchesIn, bounds);
    if (found > max_count) found = impl_->Count(sql::kCountActivePatchesIn, bounds);
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

std::int64_t PatchDatabase::CountPatchesIn(const Bounds& bounds) const {
  return WithFile(impl_->connection, "counting patches", [&] {
    return static_cast<std::int64_t>(impl_->Count(sql::kCountActivePatchesIn, bounds));
  });
}

std::vector<Patch> PatchDatabase::ListPatches(std::int64_t after_id, int count) const {
  return WithFile(impl_->connection, "listing patches", [&] {
    const Query rows = impl_->connection.Prepare(sql::kPatchesAfter);
    rows->bind(1, after_id);
    rows->bind(2, count);
    return ReadPatches(*rows, impl_->path);
  });
}

std::optional<Patch> PatchDatabase::ReadPatch(std::int64_t id) const {
  return WithFile(impl_->connection, "reading a patch", [&]() -> std::optional<Patch> {
    const Query row = impl_->connection.Prepare(sql::kPatch);
    row->bind(1, id);
    if (!row->executeStep()) return std::nullopt;
    Patch patch;
    try {
      patch = Unpack(ReadPatchRow(*row), true);
    } catch (const InputError& error) {
      throw InputError(impl_->path + ": " + error.what());
    }
    const Query evidence = impl_->connection.Prepare(sql::kEvidenceOf);
    evidence->bind(1, id);
    while (evidence->executeStep()) patch.evidence.push_back(ReadEvidenceRow(*evidence));
    return patch;
  });
}

std::optional<Eigen::Vector2d> PatchDatabase::PlaceSought(const MatchAttempt& attempt) const {
  return WithFile(impl_->connection, "reading a patch's place",
                  [&] { return patchdb::PlaceSought(impl_->connection, attempt); });
}

std::vector<PatchSource> PatchDatabase::Sources() const {
  return WithFile(impl_->connection, "listing sources", [&] {
    const Query rows = impl_->connection.Prepare(sql::kSources);
    std::vector<PatchSource> sources;
    while (rows->executeStep()) sources.push_back(ReadSourceRow(*rows));
    return sources;
  });
}

KnownSource PatchDatabase::FindSource(const PatchSource& source) const {
  return WithFile(impl_->connection, "looking for a source", [&] {
    KnownSource known{std::nullopt, false, source.name};
    for (int number = 2;; ++number) {
      const Query row = impl_->connection.Prepare(sql::kSourceNamed);
      row->bind(1, Name(source.kind));
      row->bind(2, known.name);
      if (!row->executeStep()) return known;
      const auto date = TextOf(row->getColumn(1)), digest = TextOf(row->getColumn(2));
      if (digest && source.digest ? digest == source.digest : date == source.date) {
        known.id = row->getColumn(0).getInt64();
        known.harvested = row->getColumn(3).getInt() != 0;
        return known;
      }
      known.name = fmt::format("{} ({})", source.name, number);
    }
  });
}

void PatchDatabase::GrowExtent(const Eigen::Vector2d& place_m) {
  impl_->GrowExtent({place_m.x(), place_m.y(), place_m.x(), place_m.y()});
}

int PatchDatabase::Write(const char* doing, const std::function<int(Connection&)>& work) {
  impl_->RequireWriting();
  return WithFile(impl_->connection, doing, [&] {
    SQLite::Transaction transaction(impl_->connection.Database(),
                                    SQLite::TransactionBehavior::IMMEDIATE);
    const int changed = work(impl_->connection);
    transaction.commit();
    return changed;
  });
}

int PatchDatabase::RecordAttempts(const std::vector<MatchAttempt>& attempts,
                                  const std::vector<SoughtElsewhere>& elsewhere) {
  return Write("recording attempts",
               [&](Connection& connection) { return Learn(connection, attempts, elsewhere); });
}

}  // namespace orient::patchdb

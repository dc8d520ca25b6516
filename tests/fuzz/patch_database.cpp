// Untrusted patch databases: packed values, rows, whole files.
#include <sqlite3.h>

#include <cmath>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "patchdb/maintenance/check.h"
#include "patchdb/maintenance/life.h"
#include "patchdb/maintenance/merge.h"
#include "patchdb/maintenance/statistics.h"
#include "patchdb/regions/control_patches.h"
#include "patchdb/store/connection.h"
#include "patchdb/store/content_digest.h"
#include "patchdb/store/geopackage_geometry.h"
#include "patchdb/store/learn.h"
#include "patchdb/store/patch_blobs.h"
#include "tests/fuzz/reader.h"
#include "tests/support/made_up_patches.h"

namespace orient::fuzz {
namespace {
using namespace patchdb;  // NOLINT: the whole file is about patch databases

Bytes BytesOf(Input input) { return {input.begin(), input.end()}; }

// Accepted values are packed again as the same bytes.
const Register kPatchValue("patch_value", [](Input input) {
  Values values(input);
  const std::size_t kind = values.Below(5);
  const int size = values.Take<std::int16_t>();
  const auto step_m = values.Take<double>(), base_m = values.Take<double>();
  const auto quantum_m = values.Take<float>();
  const Bytes bytes = BytesOf(values.Rest());
  switch (kind) {
    case 0:
      Require(EncodeHeights(DecodeHeights(bytes, size, step_m)) == bytes, "heights");
      break;
    case 1: {
      const HeightGrid heights = UnpackHeights({bytes, base_m, quantum_m}, size, step_m);
      Require(heights.heights_m.size() == std::size_t(size) * std::size_t(size), "their number");
      heights.At(0, 0);
      heights.At(base_m, step_m);
      break;
    }
    case 2:
      DecodeCovariance(bytes);
      break;
    case 3:
      Require(EncodeVector(DecodeVector(bytes)) == bytes, "a vector");
      break;
    default:
      if (const auto point = DecodePointZ(bytes.data(), bytes.size()))
        DecodePointZ(EncodePointZ(*point, 4326).data(), 8);
  }
});

// The databases that the index lists do not exist.
const Register kRegionIndex("region_index", [](Input input) {
  FileWith("regions/regions.json", Text(input));
  const std::string folder = Folder() + "/regions";
  const RegionIndex index = ReadRegionIndex(folder);
  for (const std::string& file : RegionFiles(folder, index))
    Require(std::filesystem::path(file).parent_path() == folder, "a file of the folder");
  if (!index.regions.empty())
    Require(!Accepted([&] { return (RequireCurrent(folder, index), true); }), "no such files");
  const ControlPatches patches = ControlPatches::Open(folder);
  patches.ReadPatch(3'000'000'000);
  patches.Sources();
});

void Fill(PatchDatabase& database) {
  PatchSource source = MadeUpSource("1990.tif", "1990-07-01");
  std::vector<Patch> patches = MadeUpPatches(3, 2, 100);
  database.AddSource(source, patches);
  PatchSource other = MadeUpSource("2005.tif");
  std::vector<Patch> later = MadeUpPatches(2, 1, 60);
  later[0].evidence = {{source.id, Eigen::Vector2d(3, 4), Eigen::Vector2d(0.1, 0.2)}};
  database.AddSource(other, later);
  std::vector<MatchAttempt> attempts;
  for (const Patch& patch : patches)
    attempts.push_back(MadeUpAttempt(patch.id, "photo", patch.id % 2 == 0));
  database.RecordAttempts(attempts);
  RetirePatches(database, {patches[0].id}, "test");
}

// All queries of a database; a refusal is an answer, too. A check takes ten times as long as all
// others.
void Ask(PatchDatabase& database, bool check) {
  if (check) Accepted([&] { return CheckDatabase(database, {}); });
  Accepted([&] { return database.Info(); });
  Accepted([&] { return database.Sources(); });
  Accepted([&] { return database.ListPatches(0, 100); });
  Accepted([&] { return database.FindPatchesIn({0, 0, 1e7, 1e7}, 4); });
  for (const std::int64_t id : {1, 2, 7}) Accepted([&] { return database.ReadPatch(id); });
  PatchFilter filter;
  filter.success_below = 0.9;
  Accepted([&] { return ChooseIds(database, filter); });
  Accepted([&] { return CountEverything(database); });
  Accepted([&] { return CountDensity(database, 1000); });
  Accepted([&] { return ContentOf(database); });
}

// A database that is opened once; changes to its rows are rolled back.
struct OpenDatabase {
  PatchDatabase database =
      PatchDatabase::Create(Folder() + "/rows.gpkg", MadeUpCrs(), [](auto& of) { Fill(of); });
  std::vector<std::pair<std::string, std::vector<std::string>>> tables;

  OpenDatabase() {
    Do("PRAGMA foreign_keys = OFF");
    Do("PRAGMA ignore_check_constraints = ON");
    for (const char* table :
         {"patches", "sources", "attempts", "evidence", "gpkg_contents", "gpkg_geometry_columns",
          "gpkg_spatial_ref_sys", "orient_schema", "orient_content", "rtree_patches_geom"}) {
      tables.push_back({table, {}});
      SQLite::Statement columns(Sql(), std::string("PRAGMA table_info(") + table + ")");
      while (columns.executeStep()) tables.back().second.push_back(columns.getColumn(1));
    }
  }
  SQLite::Database& Sql() { return database.Sql().Database(); }
  void Do(const std::string& sql) { Sql().exec(sql); }

  // Writes a value of any type to a column, in one row or in all.
  void Change(Values* values) {
    const auto& [table, columns] = tables[values->Below(tables.size())];
    const std::string& column = columns[values->Below(columns.size())];
    const std::size_t row = values->Below(8);
    const std::string where = row == 0 ? "" : " WHERE rowid = " + std::to_string(row);
    SQLite::Statement update(Sql(), "UPDATE " + table + " SET " + column + " = ?1" + where);
    switch (values->Below(5)) {
      case 0:
        update.bind(1);
        break;
      case 1:
        update.bind(1, values->Take<std::int64_t>());
        break;
      case 2:
        update.bind(1, values->Take<double>());
        break;
      case 3:
        update.bind(1, std::string(Text(values->Bytes(values->Take<std::uint8_t>()))));
        break;
      default: {
        const Input blob = values->Bytes(values->Take<std::uint16_t>());
        update.bind(1, blob.data(), static_cast<int>(blob.size()));
      }
    }
    update.exec();
  }
};

const Register kPatchRows("patch_rows", [](Input input) {
  static OpenDatabase open;
  Values values(input);
  const bool check = values.Below(16) == 0;
  open.Do("BEGIN");
  for (int i = 0; i < 8 && !values.Rest().empty(); ++i) {
    try {
      open.Change(&values);
    } catch (const SQLite::Exception&) {  // SQLite itself rejects some
    }
  }
  Ask(open.database, check);
  for (const std::int64_t id : {1, 2, 7}) LearnAnew(open.database.Sql(), id, true);
  open.Do("ROLLBACK");
});

// The bytes of a small, undamaged database.
const std::string& WholeFile() {
  static const std::string bytes = [] {
    const std::string path = Folder() + "/whole.gpkg";
    PatchDatabase::Create(path, MadeUpCrs(), [](auto& of) { Fill(of); });
    SQLite::Database raw(path, SQLite::OPEN_READWRITE);
    for (const char* change : {"PRAGMA journal_mode = DELETE", "PRAGMA page_size = 1024", "VACUUM"})
      raw.exec(change);
    return ReadFile(path);
  }();
  return bytes;
}

void Damage(Values* values, std::string* file) {
  while (!values->Rest().empty()) {
    const std::size_t at = values->Take<std::uint32_t>() % file->size();
    const Input bytes = values->Bytes(values->Below(32) + 1);
    const std::size_t count = std::min(bytes.size(), file->size() - at);
    std::memcpy(file->data() + at, bytes.data(), count);
  }
}

const Register kPatchFile("patch_file", [](Input input) {
  Values values(input);
  const std::size_t verb = values.Below(6);
  std::string file = WholeFile();
  Damage(&values, &file);
  const std::string path = FileWith("damaged.gpkg", file);
  for (const char* log : {"-wal", "-shm", "-journal"}) std::filesystem::remove(path + log);
  auto database = Accepted([&] {
    return PatchDatabase::Open(
        path, verb < 2 || verb == 5 ? PatchDatabase::Mode::kRead : PatchDatabase::Mode::kWrite);
  });
  if (!database) return;
  Ask(*database, verb == 5);
  if (verb == 1) {
    const std::string whole = FileWith("target.gpkg", WholeFile());
    PatchDatabase target = PatchDatabase::Open(whole, PatchDatabase::Mode::kWrite);
    Accepted([&] { return MergeDatabase(target, *database, {}); });
    Require(CheckDatabase(target, {}).empty(), "a merge leaves a sound database");
  }
  if (verb == 2) Accepted([&] { return CheckDatabase(*database, {true, true}); });
  if (verb == 3)
    Accepted([&] {
      database->RecordAttempts({MadeUpAttempt(2, "new", true), MadeUpAttempt(3, "new", false)});
      return RetirePatches(*database, {2, 3}, "test") + RestorePatches(*database, {1});
    });
  if (verb == 4) {
    PatchSource source = MadeUpSource("new.tif");
    std::vector<Patch> patches = MadeUpPatches(1, 1, 100);
    Accepted([&] {
      database->AddSource(source, patches);
      return true;
    });
  }
});

}  // namespace
}  // namespace orient::fuzz

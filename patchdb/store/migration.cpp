#include "patchdb/store/migration.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "core/base/error.h"
#include "patchdb/store/schema.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {
namespace {

constexpr const char* kObjects =
    "SELECT type, name, sql FROM sqlite_master WHERE sql IS NOT NULL AND name NOT GLOB 'sqlite_*' "
    "AND NOT (type = 'table' AND name GLOB 'rtree_patches_geom_*')";
// Prefixes of triggers that GeoPackage 1.4 and programs writing GeoPackages add.
constexpr const char* kTriggersOfGis[] = {"rtree_patches_geom_", "trigger_insert_feature_count_",
                                          "trigger_delete_feature_count_"};
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

// Runs the steps after `version` up to `last`; the caller holds the transaction, and keeps foreign
// keys off: a step may rebuild a table.
void RunSchemaSteps(Connection& connection, int version, int last = CurrentSchemaVersion()) {
  for (const SchemaStep& step : SchemaSteps()) {
    if (step.version <= version || step.version > last) continue;
    connection.Database().exec(step.sql);
    if (step.further != nullptr)
      for (const std::string& statement : step.further()) connection.Database().exec(statement);
    const Query record = connection.Prepare(sql::kAddSchemaStep);
    record->bind(1, step.version);
    record->bind(2, step.description);
    record->exec();
  }
}

void FillNewDatabase(Connection& connection, const Crs& crs) {
  SQLite::Database& database = connection.Database();
  database.exec("PRAGMA application_id = " + std::to_string(kGeoPackageApplicationId));
  database.exec("PRAGMA user_version = " + std::to_string(kGeoPackageVersion));
  database.exec("PRAGMA foreign_keys = OFF");
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

}  // namespace

void WriteNewDatabase(const std::string& path, const Crs& crs) {
  Connection connection(path, Connection::Mode::kCreate);
  WithFile(connection, "creating the database", [&] { FillNewDatabase(connection, crs); });
}

int CheckedSchemaVersion(Connection& connection, const std::string& path) {
  if (connection.Number("PRAGMA application_id") != kGeoPackageApplicationId)
    throw InputError(path + " is not a GeoPackage; give a file made by 'orient patchdb create'");
  if (connection.Number(sql::kHasSchemaTable) != 1)
    throw InputError(path + " is a GeoPackage but not a patch database (it has no table " +
                     "orient_schema); give a file made by 'orient patchdb create'");
  const auto version = connection.Number(sql::kSchemaVersion);
  if (version < 1) throw InputError(path + " is damaged: table orient_schema is empty");
  if (version > CurrentSchemaVersion())
    throw InputError(
        fmt::format("{} has schema version {}, this program knows {} at most; use a newer Orient",
                    path, version, CurrentSchemaVersion()));
  return static_cast<int>(version);
}

bool ReadableAsItIs(int version) {
  const auto& steps = SchemaSteps();
  return std::all_of(steps.begin(), steps.end(), [&](const SchemaStep& step) {
    return step.version <= version || step.for_writers_only;
  });
}

void BringUpToDate(Connection& connection, int version, const std::string& path) {
  if (version == CurrentSchemaVersion()) return;
  SQLite::Database& database = connection.Database();
  database.exec("PRAGMA foreign_keys = OFF");  // has no effect within a transaction
  SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
  // Rows with dangling references stay as they are: 'orient patchdb check --repair' needs
  // today's tables to repair them.
  constexpr const char* kBroken = "SELECT count(*) FROM pragma_foreign_key_check";
  const std::int64_t broken = connection.Number(kBroken);
  // Another program may have upgraded it meanwhile.
  RunSchemaSteps(connection, CheckedSchemaVersion(connection, path));
  if (connection.Number(kBroken) > broken)
    throw InputError(path + " is damaged: it cannot be upgraded without losing rows");
  transaction.commit();
  database.exec("PRAGMA foreign_keys = ON");
}

std::vector<SchemaObject> ForeignObjects(Connection& connection, int version) {
  std::vector<SchemaObject> foreign = ObjectsOf(connection);
  const std::vector<SchemaObject> ours = ObjectsOfVersion(version);
  std::erase_if(foreign, [&](const SchemaObject& object) {
    if (object.type == "view") return false;
    if (object.type != "trigger") return true;
    const bool known = std::any_of(ours.begin(), ours.end(), [&](const SchemaObject& other) {
      return other.type == object.type && other.name == object.name;
    });
    const std::string_view name = object.name;
    return known || std::any_of(std::begin(kTriggersOfGis), std::end(kTriggersOfGis),
                                [&](const char* of_gis) { return name.starts_with(of_gis); });
  });
  return foreign;
}

void RefuseForeignTriggers(Connection& connection, int version, const std::string& path) {
  for (const SchemaObject& object : ForeignObjects(connection, version))
    if (object.type == "trigger")
      throw InputError(fmt::format(
          "{} holds the trigger {}, which is not part of a patch database and would run with every "
          "change; copy the patches without it: 'orient patchdb export FILE --subset NEW'",
          path, object.name));
}

std::vector<SchemaObject> ObjectsOf(Connection& connection) {
  const Query rows = connection.Prepare(kObjects);
  std::vector<SchemaObject> objects;
  while (rows->executeStep())
    objects.push_back({rows->getColumn(0).getString(), rows->getColumn(1).getString(),
                       rows->getColumn(2).getString()});
  return objects;
}

std::vector<SchemaObject> ObjectsOfVersion(int version) {
  Connection reference(":memory:", Connection::Mode::kCreate);
  reference.Database().exec("PRAGMA foreign_keys = OFF");
  RunSchemaSteps(reference, 0, version);
  return ObjectsOf(reference);
}

}  // namespace orient::patchdb

#include "patchdb/maintenance/schema_check.h"

#include <algorithm>
#include <string_view>

#include "core/base/geopackage/self_description.h"
#include "patchdb/store/schema.h"

namespace orient::patchdb {
namespace {

constexpr const char* kRegister =
    "INSERT OR IGNORE INTO gpkg_contents (table_name, data_type, identifier) VALUES (?1, "
    "'attributes', ?1)";
constexpr const char* kSetToken =
    "INSERT OR REPLACE INTO orient_content VALUES (1, randomblob(16))";

bool IsTokens(const SchemaObject& object) {
  return std::string_view(object.name).starts_with("orient_content");
}

// GeoPackage 1.4 has others instead of these (its annex on the R-tree extension).
bool IsReplaced(const SchemaObject& object, const std::vector<SchemaObject>& present) {
  return std::string_view(object.name).starts_with("rtree_patches_geom_update") &&
         std::any_of(present.begin(), present.end(), [](const SchemaObject& other) {
           return other.name == "rtree_patches_geom_update6";
         });
}

bool Has(const std::vector<SchemaObject>& present, const SchemaObject& object) {
  return std::any_of(present.begin(), present.end(), [&](const SchemaObject& other) {
    const bool as_written = object.type != "trigger" || !IsTokens(object);
    return other.type == object.type && other.name == object.name &&
           (as_written || other.sql == object.sql);
  });
}

}  // namespace

std::vector<SchemaObject> MissingObjects(Connection& connection, int version) {
  const std::vector<SchemaObject> present = ObjectsOf(connection);
  std::vector<SchemaObject> missing = ObjectsOfVersion(version);
  std::erase_if(missing, [&](const SchemaObject& object) {
    return Has(present, object) || IsReplaced(object, present);
  });
  return missing;
}

bool IsBeyondRepair(const SchemaObject& object) {
  const std::string_view name = object.name;
  return name == "patches" || name == "orient_schema" ||
         (name.starts_with("gpkg_") && !IsOfSelfDescription(object.name));
}

bool HasTable(const std::vector<SchemaObject>& objects) {
  return std::any_of(objects.begin(), objects.end(),
                     [](const SchemaObject& object) { return object.type == "table"; });
}

void MakeObjects(Connection& connection, const std::vector<SchemaObject>& missing) {
  bool describe = false;
  for (const SchemaObject& object : missing) {
    describe = describe || IsOfSelfDescription(object.name);
    if (IsOfSelfDescription(object.name)) continue;
    if (object.type == "trigger")
      connection.Database().exec("DROP TRIGGER IF EXISTS " + object.name);
    connection.Database().exec(object.sql);
    if (object.type != "table" || object.name.starts_with("rtree_")) continue;
    const Query table = connection.Prepare(kRegister);
    table->bind(1, object.name);
    table->exec();
  }
  if (std::any_of(missing.begin(), missing.end(), IsTokens)) RenewToken(connection);
  if (!describe) return;
  for (const std::string& statement : SelfDescription()) connection.Database().exec(statement);
}

bool LacksToken(Connection& connection, int version) {
  return version >= kFirstSchemaWithToken &&
         connection.Number("SELECT count(*) FROM orient_content") == 0;
}

void RenewToken(Connection& connection) {
  const Query token = connection.Prepare(kSetToken);
  token->exec();
}

}  // namespace orient::patchdb

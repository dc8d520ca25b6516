// The tables of a patch database, as a list of steps that lead from an empty file to today's.
#pragma once

#include <string>
#include <vector>

namespace orient::patchdb {

// One step of the schema, in a file of its own under patchdb/schema/. Steps are never edited once
// released; a change is a new step.
struct SchemaStep {
  int version;  // 1, 2, ... : the schema version after this step
  const char* description;
  const char* sql;
  // Today's program reads files from before this step as they are; only who writes needs it.
  bool for_writers_only = false;
  // Statements that follow those of `sql`, where they are not all known to the compiler.
  std::vector<std::string> (*further)() = nullptr;
};

extern const SchemaStep kSchemaStep1;
extern const SchemaStep kSchemaStep2;
extern const SchemaStep kSchemaStep3;
extern const SchemaStep kSchemaStep4;
extern const SchemaStep kSchemaStep5;
extern const SchemaStep kSchemaStep6;

const std::vector<SchemaStep>& SchemaSteps();
int CurrentSchemaVersion();  // of this program

// What makes the tables of step 6 where they are not there, and fills them: a style for the patches
// that have none, and the program's version (core/base/geopackage).
std::vector<std::string> SelfDescription();

// The first version with orient_content, the token of what the patches are.
inline constexpr int kFirstSchemaWithToken = 4;

// GeoPackage says so: "GPKG" in application_id and 10300 (version 1.3.0) in user_version. The
// latter is why Orient's own schema version is not in user_version but in table orient_schema.
inline constexpr int kGeoPackageApplicationId = 0x47504B47;
inline constexpr int kGeoPackageVersion = 10300;

}  // namespace orient::patchdb

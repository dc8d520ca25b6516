// A file's schema: made, checked, and brought up to date. Private to patchdb.
#pragma once

#include <string>
#include <vector>

#include "core/terrain/crs.h"
#include "patchdb/store/connection.h"

namespace orient::patchdb {

// Into an empty file: everything of an empty patch database in this CRS.
void WriteNewDatabase(const std::string& path, const Crs& crs);

// The version of the file's schema. Throws InputError where it is no patch database, or newer than
// this program.
int CheckedSchemaVersion(Connection& connection, const std::string& path);

// Whether today's program reads a file of this version as it is.
bool ReadableAsItIs(int version);

// Runs the steps that the file lacks, in one transaction.
void BringUpToDate(Connection& connection, int version, const std::string& path);

// A table, index or trigger of the schema.
struct SchemaObject {
  std::string type, name, sql;
};

// Views, and triggers that neither the schema nor a GIS creates: foreign code. Views are never
// run (Connection), triggers by writers only, which refuse the file.
std::vector<SchemaObject> ForeignObjects(Connection& connection, int version);
// Throws InputError naming file and trigger.
void RefuseForeignTriggers(Connection& connection, int version, const std::string& path);

// Those that a file has; of a whole one those that its version has, beside the GeoPackage's own
// tables. What the spatial index and SQLite keep for themselves is left out.
std::vector<SchemaObject> ObjectsOf(Connection& connection);
std::vector<SchemaObject> ObjectsOfVersion(int version);

}  // namespace orient::patchdb

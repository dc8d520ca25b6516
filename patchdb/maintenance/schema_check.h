// Whether a file has the tables, indexes and triggers of its schema version. Private to patchdb.
#pragma once

#include <string>
#include <vector>

#include "patchdb/store/connection.h"
#include "patchdb/store/migration.h"

namespace orient::patchdb {

// What the file should have and has not; of the content's token the triggers of another text, too:
// a change that does not renew it would go unnoticed. The triggers with which GeoPackage 1.4
// replaces some of the spatial index's are taken as well.
std::vector<SchemaObject> MissingObjects(Connection& connection, int version);

// Those of them that no repair can make up: patches, and what the file says of itself.
bool IsBeyondRepair(const SchemaObject& object);

// Without these nothing else can be looked for.
bool HasTable(const std::vector<SchemaObject>& objects);

// Makes them; tables are empty then, but for what the file says of itself (styles, metadata). The
// caller holds the transaction. Throws SQLite::Exception where something else has the name.
void MakeObjects(Connection& connection, const std::vector<SchemaObject>& missing);

// Of a version that has none, the token is never missing.
bool LacksToken(Connection& connection, int version);
void RenewToken(Connection& connection);

}  // namespace orient::patchdb

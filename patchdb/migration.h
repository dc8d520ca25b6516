// A file's schema: made, checked, and brought up to date. Private to patchdb.
#pragma once

#include <string>

#include "core/geometry/crs.h"
#include "patchdb/connection.h"

namespace orient {

// Into an empty file: everything of an empty patch database in this CRS.
void WriteNewDatabase(const std::string& path, const Crs& crs);

// The version of the file's schema. Throws InputError where it is no patch database, or newer than
// this program.
int CheckedSchemaVersion(Connection& connection, const std::string& path);

// Runs the steps that the file lacks, in one transaction.
void BringUpToDate(Connection& connection, int version, const std::string& path);

}  // namespace orient

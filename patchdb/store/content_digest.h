// What a patch database offers to a photo, as one short text that changes when it does.
#pragma once

#include <string>

#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

// Changes with every patch that comes, goes, is retired or restored, or is changed in place by
// any program, and with the CRS; one quick query, however large the database. Not with what
// is learned from attempts: oriented photos update the database, and need not be oriented
// again for that. Only unchanged copies of one database have the same text.
std::string ContentOf(const PatchDatabase& database);

}  // namespace orient::patchdb

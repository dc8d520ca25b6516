// What a patch database offers to a photo, as one short text that changes when it does.
#pragma once

#include <string>

#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

// Changes with every patch that comes, goes, is retired or restored, or is changed in place by
// whatever program, and with the CRS; takes one look, however large the database. Not with what
// attempts have taught: photos that are oriented teach the database, and are not to be oriented
// again for that. Two databases never have the same one, but copies that nobody has changed since.
std::string ContentOf(const PatchDatabase& database);

}  // namespace orient::patchdb

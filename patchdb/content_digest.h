// What a patch database offers to a photo, as one short text that changes when it does.
#pragma once

#include <string>

#include "patchdb/patch_database.h"

namespace orient {

// Of which patches there are and which are retired, but not of what attempts have taught: photos
// that are oriented teach the database, and are not to be oriented again for that.
std::string ContentOf(const PatchDatabase& database);

}  // namespace orient

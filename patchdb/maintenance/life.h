// The life of patches: retired, restored, and finally deleted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

// Each is one transaction and answers how many patches it changed. Ids that are not there, or in
// that state already, change nothing. Throws InputError like the members of PatchDatabase.

// They stay in the database with all their history, but are searched for no longer.
int RetirePatches(PatchDatabase& database, const std::vector<std::int64_t>& ids,
                  const std::string& reason);
// They are searched for again, and begin a new epoch: what failed before counts less from now on.
int RestorePatches(PatchDatabase& database, const std::vector<std::int64_t>& ids);
// Deletes retired patches with their attempts and evidence, for good. Active ones are left alone.
int DeleteRetiredPatches(PatchDatabase& database, const std::vector<std::int64_t>& ids);

}  // namespace orient::patchdb

// A patch database for a command that writes.
#pragma once

#include <iosfwd>
#include <string>

#include "patchdb/store/patch_database.h"

namespace orient {

// Opened for writing. A file of an older program is brought up to date, and `out` hears of it.
patchdb::PatchDatabase OpenToWrite(const std::string& path, std::ostream& out);

// Of the run of an exterior orientation that will tell the database, or those of a folder: before
// anything is read of a file of an older program. Throws InputError, with the remedy, where it
// cannot be written.
void BringUpToDateToLearn(const std::string& path, std::ostream& out);

}  // namespace orient

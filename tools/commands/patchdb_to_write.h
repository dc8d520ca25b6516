// A patch database for a command that writes.
#pragma once

#include <iosfwd>
#include <string>

#include "patchdb/store/patch_database.h"

namespace orient {

// Opened for writing. A file of an older program is upgraded, and `out` gets a line about it.
patchdb::PatchDatabase OpenToWrite(const std::string& path, std::ostream& out);

// For a run of exterior orientation that will record in one database or a folder of them: upgrades
// files of an older program before anything is read. Throws InputError, with the remedy, if one
// cannot be written.
void BringUpToDateToLearn(const std::string& path, std::ostream& out);

}  // namespace orient

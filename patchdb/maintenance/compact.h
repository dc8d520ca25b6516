// A patch database's file written anew: without gaps, in pages of today's size.
#pragma once

#include <cstdint>

#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

struct CompactResult {
  std::uintmax_t before = 0, after = 0;  // bytes of the file
  // It has pages of an older size still: that can only be changed while no other program has the
  // file open.
  bool old_pages = false;
};

// One transaction. The database must be open for writing. Throws InputError: no space for a second
// copy.
CompactResult CompactDatabase(PatchDatabase& database);

}  // namespace orient::patchdb

// The patch database of a block whose file names images of known ground ([control]) in its place.
#pragma once

#include <iosfwd>
#include <string>

#include "core/files/block_file.h"

namespace orient {

// Sets block->patchdb of a block with [control]: OUT/control_<digest>.gpkg, where the digest is of
// all that goes into it (images, poses, heights, keys), so that a file of that name is never stale,
// and none is ever replaced. Returns whether it is there. Nothing, and true, without [control].
bool FindBlockControl(const std::string& camera_library, BlockFile* block);

// Makes the database that FindBlockControl has named and not found, whole or not at all; prints
// what was harvested. Throws InputError naming key or file, also where another program is making
// it.
void MakeBlockControl(const std::string& camera_library, const BlockFile& block, std::ostream& out);

}  // namespace orient

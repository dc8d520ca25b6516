// The patch database of a block whose file names images of known ground ([control]) in its place.
#pragma once

#include <iosfwd>
#include <string>

#include "core/files/block_file.h"

namespace orient {

// Makes block.patchdb from block.control, whole or not at all. One that is there and was made from
// the same images, heights and options is left alone, one made from others is made anew. Nothing
// for a block without [control]. Prints what was harvested. Throws InputError naming key or file.
void MakeBlockControl(const BlockFile& block, const std::string& camera_library, std::ostream& out);

// Whether MakeBlockControl() would have something to do: for --plan.
bool NeedsBlockControl(const BlockFile& block);

}  // namespace orient

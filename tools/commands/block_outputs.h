// What `orient block` writes into its output folder when its photos' results are final.
#pragma once

#include <optional>
#include <string>

#include "block/block.h"
#include "block/pictures/quicklook.h"

namespace orient {

// The photos' results, tables, GeoPackage, report and exports, with `quicklook` pictures of the
// orthophotos, too; adds to the block's findings. Results that an earlier run left of photos that
// are not in the block any more go to the folder not_in_block below: what is read there is the
// block. Throws InputError for an export that cannot be made, when all else is written.
std::optional<block::Quicklook> WriteBlockOutputs(const BlockFile& block, bool quicklook,
                                                  block::OrientedBlock* oriented);

// Throws UsageError where a block's run would replace or remove a file that it reads, or the folder
// holds a patch database named block.gpkg. `path`: the block file's.
void RequireInputsApart(const BlockFile& block, const std::string& path);

// report.html alone: anew, when there are orthophotos to show.
void WriteBlockReport(const BlockFile& block, const block::OrientedBlock& oriented);

}  // namespace orient

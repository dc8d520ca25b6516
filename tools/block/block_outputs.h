// What a block's run writes into its output folder when its photos' results are final.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/geometry/ground_surface.h"
#include "tools/block/block_photos.h"
#include "tools/block/block_run.h"

namespace orient {

struct BlockOutputs {
  const BlockFile& block;
  const CameraFile& camera;  // that the final poses are true with
  const std::vector<BlockPhotoFile>& photos;
  bool quicklook = false;
};

// Results that an earlier run left of photos that are not in the block any more go to the folder
// not_in_block below: what is read here is the block. Returns what is told of it, if anything was
// moved.
std::optional<std::string> SetOtherPhotosAside(const BlockFile& block);

// The photos' results, tables, GeoPackage, pictures, report and exports; adds to the result's
// messages. Throws InputError for an export that cannot be made, when all else is written.
void WriteBlockOutputs(const BlockOutputs& outputs, BlockRunResult* result);

}  // namespace orient

// Photos of a block that are one image under two names.
#pragma once

#include <vector>

#include "block/inputs/block_photos.h"
#include "core/files/finding.h"

namespace orient::block {

// One finding for each image that several of the photos show, by the digests of the scans that
// their results were made from, naming them. A photo without a digest is nobody's copy.
Findings SameImages(const std::vector<BlockPhotoFile>& photos);

}  // namespace orient::block

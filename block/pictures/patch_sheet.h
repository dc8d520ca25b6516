// A picture of what was matched: every patch as the photo should see it, beside the photo there.
#pragma once

#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/terrain/photo_view.h"
#include "exterior/steps/photo_image.h"
#include "patchdb/store/patch.h"

namespace orient::block {

// Writes a PNG with up to `max_patches` pairs (patch left, photo right), those that were rejected
// or not found first, then the matched ones with the lowest correlation; the frame's colour says
// which: green matched, red rejected, grey not found. `view` holds the final pose. Writes nothing
// where no patch is visible.
void WritePatchSheet(const std::string& path, const PhotoView& view,
                     const exterior::PhotoImage& photo, const std::vector<patchdb::Patch>& patches,
                     const ExteriorResult& result, int max_patches = 48);

}  // namespace orient::block

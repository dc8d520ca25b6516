// What a Metashape chunk's ground system is taken for, and whether its cameras lie where their
// references say.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/exchange/metashape.h"

namespace orient {

// The aligned cameras against their enabled references, in plan: heights may be above the ellipsoid
// or the sea.
struct MetashapeReferenceFit {
  std::size_t cameras = 0;
  double median_m = 0;
  double bound_m = 0;  // more than what GPS on board leaves, and than the chunk's stated accuracy
};
// Empty where no camera has a reference that can be compared.
std::optional<MetashapeReferenceFit> FitToReferences(const MetashapeChunk& chunk);

// What a reader must know of the chunk: the ground system taken and what speaks for it, what was
// left out. Throws InputError naming `file`: cameras away from their references, or geocentric ones
// in a chunk without a transform.
std::vector<std::string> NotesOnMetashape(const MetashapeChunk& chunk, const std::string& file);

}  // namespace orient

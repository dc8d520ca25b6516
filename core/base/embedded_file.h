// A file of the sources that the program carries inside itself: see orient_embed() in
// cmake/OrientTargets.cmake.
#pragma once

#include <string_view>

namespace orient {

struct EmbeddedFile {
  std::string_view name, contents;
};

}  // namespace orient

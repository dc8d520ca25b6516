// Folders for results.
#pragma once

#include <string>

namespace orient {

// Makes the folder and those above it; removes what killed programs left half written in it. Throws
// InputError naming it, EnvironmentError where there is no room.
void MakeOutputDirectory(const std::string& directory);

}  // namespace orient

// Folders for results.
#pragma once

#include <string>

namespace orient {

// Makes the folder and those above it. Throws InputError naming it.
void MakeOutputDirectory(const std::string& directory);

}  // namespace orient

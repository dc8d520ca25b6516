// Which cameras an orientation table from elsewhere names.
#pragma once

#include <set>
#include <string>

namespace orient {

// Of its column "camera"; empty where it has none. The table is one that ReadOrientationTable
// takes.
std::set<std::string> CamerasNamed(const std::string& table);

// Throws InputError where it names several: poses of different cameras do not hold with one.
void RequireOneCamera(const std::string& table);

}  // namespace orient

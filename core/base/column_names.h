// Names of an orientation table's columns, as people and programs write them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace orient {

// "Easting", "X [m]", "x/easting" -> "x", "Omega(deg)", "O" -> "omega": what Orient calls the
// column. A name it does not know, or with another unit, in lower case.
std::string ColumnName(const std::string& written);

// The columns' places by the above. The photo's name, "filename", is the first of filename, photo,
// image, label, name and id that is there. `twice` becomes the place of a second column of one
// name, where there is one.
std::map<std::string, std::size_t> ColumnPlaces(const std::vector<std::string>& written,
                                                std::optional<std::size_t>* twice);

}  // namespace orient

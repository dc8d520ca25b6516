// Names in tables of photos, as people and programs write them: of columns and of photos.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace orient {

// "Easting", "X [m]", "x/easting" -> "x", "Omega(deg)", "O" -> "omega": what Orient calls the
// column. A name it does not know, or with another unit, in lower case.
std::string ColumnName(const std::string& written);

// "Z [ft]" -> "z", "omega(gon)", "Omega_rad" -> "omega": what the column would be in the unit of
// Orient's tables. Empty where no unit is named.
std::string ColumnOfOtherUnit(const std::string& written);

// Whether the name is that of an angle ("yaw", "Heading [deg]", "kappa_rad"), Orient's or not.
// "roll" counts, although it may be that of a film.
bool NamesAngle(const std::string& written);

// The columns' places by the above. The photo's name, "filename", is the first of filename, photo,
// photoid, image, imagename, label, name and id that is there. `twice` becomes the place of a
// second column of one name, where there is one.
std::map<std::string, std::size_t> ColumnPlaces(const std::vector<std::string>& written,
                                                std::optional<std::size_t>* twice);

// "dir/4711.tif" -> "4711", "0182.v2" -> "0182.v2": file names in a table stand for the photos;
// any other dot belongs to the name. A name without an image extension is kept as it is, except
// that the folder of a Windows path is removed.
std::string WithoutImageEnding(const std::string& name);

// The same without any folder: "flight/4711" -> "4711".
std::string BareImageName(const std::string& image);

}  // namespace orient

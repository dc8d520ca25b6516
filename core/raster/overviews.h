// Overviews that a raster's file brings with it.
#pragma once

#include <string>

namespace orient {

// Raster pixels per pixel of the coarsest overview that Raster::ReadGrey uses; 1 where there is
// none, of palettes, and where the file cannot be opened.
double CoarsestOverview(const std::string& path);

}  // namespace orient

// The columns of a table of image points or ground points as people and programs name them. Private
// to core/exchange.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace orient {

// Places of the columns of each meaning in a table; a meaning that is absent has none.
struct MeasuredColumns {
  // Of image points: photo, point, and col, row (pixels) or x_mm, y_mm (photo system); sigma.
  // Of ground points: point, x, y, z (metres); sigma_x, sigma_y, sigma_z, sigma_xy or sigma; role,
  // enabled. Of both: sigma_ground beside the image points' sigma.
  std::map<std::string, std::size_t> places;
  bool image_points = false, ground_points = false;  // a table of both has both
  bool perhaps_mm = false;                           // col and row are called x and y
  std::vector<std::string> unread;                   // as they are written
  std::string why_not;                               // neither: what is missing, and what to do

  bool Has(const std::string& meaning) const { return places.contains(meaning); }
  bool InPixels() const { return Has("col"); }
};

// Finds out what a header's cells mean: "Easting [m]" is x, "marker" is point; "name", "label" and
// "id" name the photo or the point, whichever has no column of its own; x and y are pixels in a
// table that names photos and has no z. Two columns of one meaning, and geographic coordinates, are
// a reason why not.
MeasuredColumns MeasuredColumnsOf(const std::vector<std::string>& header);

}  // namespace orient

// What the report says about one photo.
#pragma once

#include <functional>
#include <string>

#include "tools/report/template.h"
#include "tools/report/verdict.h"

namespace orient {

// A picture of the output folder: inside the page, or a link where the page has no room left or the
// file is no picture.
using PictureHtml = std::function<Markup(const std::string& file_name, const std::string& alt)>;

struct PhotoPlace {
  size_t number = 1;  // of the block's photos, from 1
  std::string all;    // link to the list of all photos
};

// A <section id="photo-<number>">.
Markup PhotoSection(const PhotoRecord& photo, const PhotoVerdict& verdict, const PhotoPlace& place,
                    const PictureHtml& picture);

}  // namespace orient

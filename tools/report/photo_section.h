// What the report says about one photo.
#pragma once

#include <functional>
#include <string>

#include "tools/report/verdict.h"

namespace orient {

// HTML of a picture of the output folder: inside the page, or a link where the page has no room
// left. Empty for a file that is no picture.
using PictureHtml =
    std::function<std::string(const std::string& file_name, const std::string& alt)>;

// A <section id="photo-<number>">. `number` counts from 1.
std::string PhotoSection(const PhotoRecord& photo, const PhotoVerdict& verdict, size_t number,
                         const PictureHtml& picture);

}  // namespace orient

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

// A <section id="photo-<number>">. `number` counts from 1.
Markup PhotoSection(const PhotoRecord& photo, const PhotoVerdict& verdict, size_t number,
                    const PictureHtml& picture);

}  // namespace orient

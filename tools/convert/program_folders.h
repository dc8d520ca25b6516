// Images where other programs look for them: in or beside the files of their format.
#pragma once

#include <string>
#include <vector>

#include "tools/convert/exchange_format.h"

namespace orient {

// Links of that kind need no space, and lead to the images wherever `out` is moved: below it they
// are relative. Links that are there are replaced, files never.

// out/images/<photo><extension> for each of a digital camera's images. Throws UsageError for an
// image that ends otherwise: the names in the files written would lead nowhere.
void LinkDigitalImages(const std::string& out, const std::vector<std::string>& images,
                       const std::string& extension);

// For OpenSfM and COLMAP out/FORMAT/images, for MicMac and ASP a link for each image beside their
// files; the other programs ask where the images are. Throws InputError where a link cannot be
// made.
void LinkImagesForPrograms(const std::string& out, const std::vector<ExchangeFormat>& formats);

}  // namespace orient

// Images where other programs look for them: in or beside the files of their format.
#pragma once

#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"
#include "tools/convert/exchange_format.h"

namespace orient {

// Links of that kind need no space, and lead to the images wherever `out` is moved: below it they
// are relative. Links that are there are replaced, files never.

// Throws UsageError for a digital camera's image that ends otherwise: the names in the files
// written would lead nowhere; InputError for one that is not there.
void RequireDigitalImages(const std::vector<std::string>& images, const std::string& extension);
// out/images/<photo><extension> for each of them.
void LinkDigitalImages(const std::string& out, const std::vector<std::string>& images,
                       const std::string& extension);

// Links to the block's images in out/images: for OpenSfM and COLMAP out/FORMAT/images, for
// MicMac and ASP a link for each beside their files; the other programs ask where the images are.
// Links have the names of the files (NamesInFiles).
// Throws InputError where a link cannot be made.
void LinkImagesForPrograms(const std::string& out, const std::vector<ExchangeFormat>& formats,
                           const ExchangeBlock& block);

}  // namespace orient

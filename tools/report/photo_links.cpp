#include "tools/report/photo_links.h"

#include "tools/report/html_text.h"

namespace orient {

std::string PhotoPageFile(const PhotoRecord& photo) { return photo.name + ".html"; }

std::string PhotoLinks::To(const BlockRecord& block, std::size_t photo) const {
  if (!apart) return "#photo-" + std::to_string(photo + 1);
  return std::string(kPhotoPages) + "/" + PercentEncoded(PhotoPageFile(block.photos[photo]));
}

}  // namespace orient

// Film photos as images in the photo system, for programs whose cameras have square pixels and no
// film: its deformation and its lying on the scan are gone.
#pragma once

#include <string>

#include "tools/convert/film_image.h"

namespace orient {

struct ResampledPhoto {
  std::string path;
  int width = 0, height = 0, bands = 0;
  // Largest distance between a pixel and where scan and film transform bring it back to, px.
  double largest_difference_px = 0;
};

// Writes `path`, a tiled TIFF with the scan's bands and data type: bicubic, averaged over the
// pixel's area where it is coarser than the scan's by a fifth or more. Grey values stay as they are
// (a negative stays one), 0 beside the scan. Works in blocks: memory does not grow with the image.
// Throws InputError naming the scan: unreadable, another size than its interior orientation's, a
// palette.
ResampledPhoto ResamplePhoto(const std::string& scan, const FilmImage& film, const Camera& image,
                             const std::string& path);

}  // namespace orient

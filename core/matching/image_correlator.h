// Many templates of one size, each searched for over the whole of one image: what of the
// correlation depends on the image alone is computed once.
#pragma once

#include <memory>

#include "core/raster/image.h"

namespace orient {

// By grey values: correlation coefficients, an estimate where there are gaps and the masked one
// where there are none. Templates are square, of `side` pixels, no larger than the image
// (std::invalid_argument). NaN: no data. Scores lie in [-1, 1], one for every place where the
// template lies inside the image; result(c, r) is for the template's corner at the image's (c, r).
// Gaps of the template are taken as varying like the rest of the window. NaN where less than half
// of the window has data, or one side is flat.
class ImageCorrelator {
 public:
  ImageCorrelator(const Image& image, int side);
  Image Scores(const Image& templ) const;

 private:
  struct Prepared;
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace orient

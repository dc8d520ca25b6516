// Many templates of one size, each sought over the whole of one image: what of the correlation
// depends on the image alone is computed once.
#pragma once

#include <memory>

#include "core/imaging/image.h"

namespace orient {

class ImageCorrelator {
 public:
  // Templates will be square, of `side` pixels, no larger than the image. NaN: no data.
  ImageCorrelator(const Image& image, int side);

  // Correlation coefficients in [-1, 1] of a template at every place where it lies inside the
  // image; result(c, r) is for the template's corner at the image's (c, r). Gaps of the template
  // (NaN) are taken as varying like the rest of the window, so that a coefficient is an estimate
  // where there are gaps, and the masked one where there are none. NaN where less than half of the
  // window has data, or one side is flat.
  Image Scores(const Image& templ) const;

 private:
  struct Prepared;
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace orient

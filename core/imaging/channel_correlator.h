// Many templates of one size, each sought by its gradients' orientations over the whole of one
// image: what of the correlation depends on the image alone is computed once.
#pragma once

#include <memory>

#include "core/imaging/image.h"

namespace orient {

class ChannelCorrelator {
 public:
  // Templates will be square, of `side` pixels, no larger than the image. NaN: no data.
  ChannelCorrelator(const Image& image, int side);

  // Cosine of the gradient channels of a template and of the image, in [-1, 1], at every place
  // where the template lies inside the image; result(c, r) is for the template's corner at the
  // image's (c, r). As CorrelateChannels (gradient_channels.h), but gaps of the template are taken
  // as strong as the rest of the window. NaN where less than half of the window has data, or there
  // is no gradient.
  Image Scores(const Image& templ) const;

 private:
  struct Prepared;
  std::shared_ptr<const Prepared> prepared_;
};

}  // namespace orient

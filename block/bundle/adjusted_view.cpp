#include "block/bundle/adjusted_view.h"

namespace orient::block {

PhotoView AdjustedView(const BlockToAdjust& block, const BlockResult& result, std::size_t photo) {
  const BlockPhoto& of = block.photos.at(photo);
  const AdjustedPhoto& adjusted = result.photos.at(photo);
  PhotoView view{result.cameras.at(of.camera), of.photo_from_pixel, adjusted.pose,
                 of.film_correction};
  const Vector6d& film = adjusted.interior_correction;
  view.photo_from_pixel.A += (Eigen::Matrix2d() << film[0], film[1], film[2], film[3]).finished();
  view.photo_from_pixel.t += film.tail<2>();
  return view;
}

}  // namespace orient::block

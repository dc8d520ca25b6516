#include "block/bundle/adjusted_view.h"

#include "core/terrain/view_over_ground.h"

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

PhotoView ViewWithGivenFilm(const BlockToAdjust& block, const BlockResult& result,
                            std::size_t photo, double height_m) {
  const PhotoView moved = AdjustedView(block, result, photo);
  PhotoView own = moved;
  own.photo_from_pixel = block.photos[photo].photo_from_pixel;
  if (!result.photos[photo].interior_correction.isZero())
    own.pose = PoseShowingTheSame(moved, own, height_m).value_or(moved.pose);
  return own;
}

}  // namespace orient::block

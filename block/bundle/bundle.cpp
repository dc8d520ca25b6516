#include "block/bundle/bundle.h"

#include <stdexcept>

namespace orient::block {

void BlockToAdjust::CheckIndices() const {
  for (const BlockPhoto& photo : photos)
    if (photo.camera >= cameras.size())
      throw std::invalid_argument("photo '" + photo.name + "' has a camera that is not there");
  for (const ImageObservation& o : observations)
    if (o.photo >= photos.size() || o.point >= points.size())
      throw std::invalid_argument("an image observation has a photo or point that is not there");
}

Eigen::Matrix2d BlockToAdjust::ImageCovariance(std::size_t observation) const {
  const ImageObservation& o = observations[observation];
  const BlockPhoto& photo = photos[o.photo];
  const Eigen::Matrix2d& A = photo.photo_from_pixel.A;
  return A * o.covariance_px2 * A.transpose() +
         Eigen::Matrix2d::Identity() * (photo.film_sigma_mm * photo.film_sigma_mm);
}

std::optional<std::string> BlockOptions::Check() const {
  if (!(significance > 0 && significance < 0.5)) return "significance must lie between 0 and 0.5";
  if (!(least_precision_factor > 0 && least_precision_factor <= 1))
    return "least_precision_factor must lie between 0 and 1";
  if (!(gnss_shift_sigma_m > 0)) return "gnss_shift_sigma_m must be positive";
  if (!(height_correlation_m > 0)) return "height_correlation_m must be positive";
  if (!(control_shared_everywhere >= 0) || !(control_shared_smoothly >= 0))
    return "control_shared_everywhere and control_shared_smoothly must not be negative";
  if (most_photos < 1) return "most_photos must be at least 1";
  if (max_rounds < 1 || max_iterations < 1 || threads < 1)
    return "max_rounds, max_iterations and threads must be at least 1";
  return std::nullopt;
}

}  // namespace orient::block

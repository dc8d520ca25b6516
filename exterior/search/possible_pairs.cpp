#include "exterior/search/possible_pairs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/geometry/collinearity.h"

namespace orient::exterior {
namespace {

Eigen::Vector2f UnitAt(double angle_rad) {
  return Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad)).cast<float>();
}

}  // namespace

PossiblePairs::PossiblePairs(const Keypoints& photo, const ChipKeypoints& chips, double gsd_m,
                             double scale_reach)
    : photo_(photo), chips_(chips), gsd_m_(gsd_m), scale_reach_(scale_reach) {
  if (!std::is_sorted(photo.sizes_px.begin(), photo.sizes_px.end()))
    throw std::invalid_argument("PossiblePairs: the photo's keypoints must be in order of size");
}

void PossiblePairs::LetPassNear(const PhotoView& view, const FilmPosition& position,
                                double kappa_reach_rad,
                                const std::function<double(const Eigen::Vector2d&)>& reach_mm) {
  const Eigen::Vector2d& centre_mm = view.camera.principal_point_mm;
  Pose unturned = view.pose;
  unturned.opk_rad.z() = 0;
  Places places;
  places.least_cosine =
      kappa_reach_rad < std::numbers::pi ? static_cast<float>(std::cos(kappa_reach_rad)) : -2.0F;
  places.of_photo.resize(2, std::ssize(photo_.pixels));
  places.turns_of_photo.resize(2, std::ssize(photo_.pixels));
  for (Eigen::Index k = 0; k < places.of_photo.cols(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double turn = KappaOf(photo_.angles_rad[i], position);
    const Eigen::Rotation2Dd back(turn);
    places.turns_of_photo.col(k) = UnitAt(turn - view.pose.opk_rad.z());
    places.of_photo.col(k) =
        (back * (view.PhotoFromPixel(photo_.pixels[i]) - centre_mm)).cast<float>();
  }
  // In a mirrored photo, kappa increases with the angles of the chips' keypoints.
  const double sense = IsMirrored(position) ? -1 : 1;
  const auto count = static_cast<Eigen::Index>(chips_.keypoints.Size());
  places.of_chips = places.turns_of_chips = Eigen::Matrix2Xf::Zero(2, count);
  places.reach_mm.assign(chips_.keypoints.Size(), -1);
  const PosedCamera camera(view.camera, unturned);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto photo_mm = camera.PhotoFromGround(chips_.ground_m[i]);
    if (!photo_mm) continue;
    const double turn = sense * chips_.keypoints.angles_rad[i];
    const Eigen::Rotation2Dd back(turn);
    places.turns_of_chips.col(k) = UnitAt(turn);
    places.of_chips.col(k) = (back * (*photo_mm - centre_mm)).cast<float>();
    places.reach_mm[i] = static_cast<float>(reach_mm(*photo_mm));
  }
  places_.push_back(std::move(places));
}

std::vector<std::size_t> PossiblePairs::Of(std::size_t chip_keypoint) const {
  const double size_px = chips_.keypoints.sizes_px[chip_keypoint] / gsd_m_;
  const auto& sizes_px = photo_.sizes_px;
  const auto first = std::lower_bound(sizes_px.begin(), sizes_px.end(), size_px / scale_reach_);
  const auto last = std::upper_bound(first, sizes_px.end(), size_px * scale_reach_);
  const auto chip = static_cast<Eigen::Index>(chip_keypoint);
  const auto may_be = [&](std::size_t i) {
    const auto photo = static_cast<Eigen::Index>(i);
    return places_.empty() ||
           std::any_of(places_.begin(), places_.end(), [&](const Places& places) {
             const float reach = places.reach_mm[chip_keypoint];
             const Eigen::Vector2f off = places.of_photo.col(photo) - places.of_chips.col(chip);
             return reach >= 0 && off.squaredNorm() <= reach * reach &&
                    places.turns_of_photo.col(photo).dot(places.turns_of_chips.col(chip)) >=
                        places.least_cosine;
           });
  };
  std::vector<std::size_t> possible;
  const auto end = static_cast<std::size_t>(last - sizes_px.begin());
  for (auto i = static_cast<std::size_t>(first - sizes_px.begin()); i < end; ++i)
    if (may_be(i)) possible.push_back(i);
  return possible;
}

}  // namespace orient::exterior

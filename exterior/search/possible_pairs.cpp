#include "exterior/search/possible_pairs.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/geometry/collinearity.h"

namespace orient::exterior {
namespace {

Eigen::Array2f UnitAt(double angle_rad) {
  return Eigen::Array2d(std::cos(angle_rad), std::sin(angle_rad)).cast<float>();
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
  places.of_photo.resize(std::ssize(photo_.pixels), 2);
  places.turns_of_photo.resize(std::ssize(photo_.pixels), 2);
  for (Eigen::Index k = 0; k < places.of_photo.rows(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double turn = KappaOf(photo_.angles_rad[i], position);
    const Eigen::Rotation2Dd back(turn);
    const Eigen::Vector2d place = back * (view.PhotoFromPixel(photo_.pixels[i]) - centre_mm);
    places.turns_of_photo.row(k) = UnitAt(turn - view.pose.opk_rad.z());
    places.of_photo.row(k) = place.cast<float>().array();
  }
  // In a mirrored photo, kappa increases with the angles of the chips' keypoints.
  const double sense = IsMirrored(position) ? -1 : 1;
  const auto count = static_cast<Eigen::Index>(chips_.keypoints.Size());
  places.of_chips = places.turns_of_chips = Eigen::ArrayX2f::Zero(count, 2);
  places.reach_mm.assign(chips_.keypoints.Size(), -1);
  const PosedCamera camera(view.camera, unturned);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const auto photo_mm = camera.PhotoFromGround(chips_.ground_m[i]);
    if (!photo_mm) continue;
    const double turn = sense * chips_.keypoints.angles_rad[i];
    const Eigen::Rotation2Dd back(turn);
    const Eigen::Vector2d place = back * (*photo_mm - centre_mm);
    places.turns_of_chips.row(k) = UnitAt(turn);
    places.of_chips.row(k) = place.cast<float>().array();
    places.reach_mm[i] = static_cast<float>(reach_mm(*photo_mm));
  }
  places_.push_back(std::move(places));
}

Eigen::ArrayXf PossiblePairs::MarginsIn(const Places& places, Eigen::Index chip, Eigen::Index first,
                                        Eigen::Index count) const {
  const float reach_mm = places.reach_mm[static_cast<std::size_t>(chip)];
  if (reach_mm < 0) return Eigen::ArrayXf::Constant(count, -1);
  const auto photo = places.of_photo.middleRows(first, count);
  const auto turns = places.turns_of_photo.middleRows(first, count);
  const Eigen::Array2f at = places.of_chips.row(chip), turn = places.turns_of_chips.row(chip);
  const auto off = (photo.col(0) - at.x()).square() + (photo.col(1) - at.y()).square();
  const auto cosine = turns.col(0) * turn.x() + turns.col(1) * turn.y();
  return (reach_mm * reach_mm - off).min(cosine - places.least_cosine);
}

std::vector<std::size_t> PossiblePairs::Of(std::size_t chip_keypoint) const {
  const double size_px = chips_.keypoints.sizes_px[chip_keypoint] / gsd_m_;
  const auto& sizes_px = photo_.sizes_px;
  const auto smallest = std::lower_bound(sizes_px.begin(), sizes_px.end(), size_px / scale_reach_);
  const auto largest = std::upper_bound(smallest, sizes_px.end(), size_px * scale_reach_);
  const Eigen::Index first = smallest - sizes_px.begin(), count = largest - smallest;
  Eigen::ArrayXf margins = Eigen::ArrayXf::Constant(count, places_.empty() ? 0 : -1);
  for (const Places& places : places_)
    margins =
        margins.max(MarginsIn(places, static_cast<Eigen::Index>(chip_keypoint), first, count));
  std::vector<std::size_t> possible;
  for (Eigen::Index i = 0; i < count; ++i)
    if (margins[i] >= 0) possible.push_back(static_cast<std::size_t>(first + i));
  return possible;
}

}  // namespace orient::exterior

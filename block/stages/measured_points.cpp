#include "block/stages/measured_points.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

namespace orient::block {
namespace {

// Sightings of each point by photos of the block, in the order of their measurement.
std::map<std::string, std::vector<ImageObservation>> SightingsOf(const Measurements& measured,
                                                                 const BlockToAdjust& block) {
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < block.photos.size(); ++i) index[block.photos[i].name] = i;
  std::map<std::string, std::vector<ImageObservation>> sightings;
  for (const ImagePointMeasurement& seen : measured.image_points) {
    const auto photo = index.find(seen.photo);
    if (photo == index.end()) continue;
    const BlockPhoto& in = block.photos[photo->second];
    const double pixel_mm = std::sqrt(std::abs(in.photo_from_pixel.A.determinant()));
    ImageObservation observation;
    observation.photo = photo->second;
    observation.pixel =
        seen.pixel ? *seen.pixel
                   : PixelFromPhoto(in.photo_from_pixel, in.film_correction.get(), *seen.photo_mm);
    const double sigma_px = seen.pixel ? seen.sigma : seen.sigma / pixel_mm;
    observation.covariance_px2 = sigma_px * sigma_px * Eigen::Matrix2d::Identity();
    sightings[seen.point].push_back(observation);
  }
  return sightings;
}

void Add(BlockPoint point, std::vector<ImageObservation> seen, BlockToAdjust* block) {
  for (ImageObservation& observation : seen) observation.point = block->points.size();
  block->observations.insert(block->observations.end(), seen.begin(), seen.end());
  // Numbers below 0: no patch has them.
  point.id = -static_cast<std::int64_t>(block->points.size()) - 1;
  point.by_hand = true;
  block->points.push_back(std::move(point));
}

}  // namespace

void AddMeasuredTies(const Measurements& measured, BlockToAdjust* block) {
  for (auto& [name, seen] : SightingsOf(measured, *block))
    if (seen.size() > 1 && measured.Point(name) == nullptr) Add({}, std::move(seen), block);
}

bool JoinsPhotos(const Measurements& measured, const std::set<std::string>& photos) {
  std::map<std::string, std::set<std::string>> seen_by;
  for (const ImagePointMeasurement& seen : measured.image_points)
    if (photos.contains(seen.photo) && measured.Point(seen.point) == nullptr)
      seen_by[seen.point].insert(seen.photo);
  return std::any_of(seen_by.begin(), seen_by.end(),
                     [](const auto& point) { return point.second.size() > 1; });
}

std::vector<SurveyedPoint> AddSurveyedPoints(const Measurements& measured, BlockToAdjust* block) {
  std::vector<SurveyedPoint> surveyed;
  for (auto& [name, seen] : SightingsOf(measured, *block)) {
    const GroundPoint* given = measured.Point(name);
    if (given == nullptr) continue;
    BlockPoint point;
    point.control = GroundControl{given->ground_m, given->sigma_m.cwiseAbs2().asDiagonal(),
                                  Eigen::Vector3d::Zero(), 0, "surveyed"};
    point.held_out = given->role == PointRole::kCheck;
    surveyed.push_back({name, block->points.size()});
    Add(std::move(point), std::move(seen), block);
  }
  return surveyed;
}

}  // namespace orient::block

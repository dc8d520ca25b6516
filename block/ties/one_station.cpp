#include "block/ties/one_station.h"

#include <algorithm>
#include <cmath>

namespace orient::block {
namespace {

// Angle (rad) between rays of one station: half a degree, far below any base, above pose errors.
constexpr double kOneStation = 0.0087;

struct Station {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // from the ground; zero: no pose is known
  std::vector<const SightingRecord*> seen;
};

bool IsSeenFrom(const Station& station, const Eigen::Vector3d& direction) {
  return !station.direction.isZero() && !direction.isZero() &&
         (station.direction - direction).norm() < kOneStation;
}

std::vector<Station> StationsOf(const TieRecord& tie, const std::map<std::string, Pose>& poses) {
  std::vector<Station> stations;
  for (const SightingRecord& seen : tie.seen) {
    Eigen::Vector3d direction = Eigen::Vector3d::Zero();
    if (const auto pose = poses.find(seen.photo); pose != poses.end())
      direction = (pose->second.position_m - tie.ground_m).normalized();
    const auto station = std::find_if(stations.begin(), stations.end(), [&](const Station& known) {
      return IsSeenFrom(known, direction);
    });
    if (station == stations.end())
      stations.push_back({direction, {&seen}});
    else
      station->seen.push_back(&seen);
  }
  return stations;
}

}  // namespace

std::vector<TieRecord> SplitByStations(const TieRecord& tie,
                                       const std::map<std::string, Pose>& poses) {
  const std::vector<Station> stations = StationsOf(tie, poses);
  std::size_t count = 1;
  for (const Station& station : stations) count = std::max(count, station.seen.size());
  if (count == 1 || stations.size() == 1) return {};
  std::vector<TieRecord> ties(count, {tie.ground_m, {}});
  for (const Station& station : stations) {
    const std::size_t rays = station.seen.size();
    for (std::size_t i = 0; i < count; ++i) {
      SightingRecord seen = *station.seen[i % rays];
      const std::size_t uses = count / rays + (i % rays < count % rays ? 1 : 0);
      seen.covariance_px2 *= static_cast<double>(uses);
      ties[i].seen.push_back(std::move(seen));
    }
  }
  return ties;
}

}  // namespace orient::block

// Ties that show a place twice from one station: a photo exposed twice, scanned twice, or under two
// names. Such rays fix no height between them, and their errors are nearly the same ones: as two
// witnesses of one tie they would outvote every other photo.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "block/ties/tie_file.h"
#include "core/geometry/pose.h"

namespace orient::block {

// The tie as ties with one ray of each station. A ray that is in several of them has as much larger
// a covariance, so that it counts once in all. Empty where the tie is right as it is: without two
// rays of one station, or with one station alone. `poses`: by photo; sightings of others stay in
// every tie.
std::vector<TieRecord> SplitByStations(const TieRecord& tie,
                                       const std::map<std::string, Pose>& poses);

}  // namespace orient::block

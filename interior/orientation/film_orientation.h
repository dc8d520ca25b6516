// In which of the ways that the marks leave open does the film lie? Identification symbols and the
// border's asymmetry decide, or leave it open; they never decide where they contradict one another.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/raster/raster.h"
#include "interior/constellation/film_reading.h"
#include "interior/constellation/layout.h"

namespace orient::interior {

// What one symbol, one feature of the border or the marks' layout says.
struct OrientationVote {
  // Nats for each scan orientation, in the order in which the ways were given; all zero where it
  // could not be read.
  std::vector<double> nats;
  std::optional<size_t> mark = std::nullopt;  // whose symbol it is; else the border or the layout
  bool fits_none = false;  // clearly read, and something that no scan orientation has there
  bool layout = false;     // what the marks' calibrated positions say
  std::optional<size_t> feature = std::nullopt;  // of BorderFeatures (film_border.h)
  bool off_scan = false;  // the feature lies outside the scan, however the film may lie
};

struct OrientationDecision {
  std::vector<ScanOrientation> possible;  // the likeliest first; as given where contradictory
  std::vector<double> nats;               // of each of these less the likeliest's
  // A quarter of the votes or more, or one that was clearly read without seven others to outvote
  // it, stood against the rest.
  bool contradictory = false;
  std::vector<size_t> dissenting;  // votes against the likeliest orientation, outvoted or not
};

// Scan orientations that are `kSureNats` less likely than the best are excluded; none where the
// votes contradict one another. A dissenting vote was clearly read where it says yes to another way
// and no to the likeliest one with 2 nats each: four to five times its noise.
inline constexpr double kSureNats = 5.0;
OrientationDecision Decide(const OrientationClass& open, const std::vector<OrientationVote>& votes);

// Adds the rivals less than kSureNats away, where they belong: what the marks' layout excludes no
// more surely than that is open, too.
void AddRivals(const std::vector<RivalOrientation>& rivals, OrientationDecision* decision);

// `measured`: marks and transform as found for the class's first orientation. Votes of all symbols
// beside used marks, and of the border.
std::vector<OrientationVote> VotesOfFilm(const Raster& scan, const CameraFile& camera,
                                         const MarkShapes& shapes, const InteriorResult& measured,
                                         const OrientationClass& open);

}  // namespace orient::interior

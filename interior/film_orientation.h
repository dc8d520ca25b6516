// In which of the ways that the marks leave open does the film lie? Identification symbols and the
// border's asymmetry decide, or leave it open; they never decide where they contradict each other.
#pragma once

#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/imaging/raster.h"
#include "interior/layout.h"

namespace orient {

// What one symbol or one feature of the border says: nats for each way of lying, in the order in
// which the ways were given; all zero where it could not be read.
using OrientationVote = std::vector<double>;

struct OrientationDecision {
  std::vector<ScanOrientation> possible;  // the likeliest first
  bool contradictory = false;             // a quarter of the votes or more stood against the rest
};

// Ways of lying that are `kSureNats` less likely than the best are excluded; none where the votes
// contradict each other.
inline constexpr double kSureNats = 5.0;
OrientationDecision Decide(const OrientationClass& open, const std::vector<OrientationVote>& votes);

// `measured`: marks and transform as found for the class's first orientation. Votes of all symbols
// beside used marks, and of the border.
std::vector<OrientationVote> VotesOfFilm(const Raster& scan, const CameraFile& camera,
                                         const MarkShapes& shapes, const InteriorResult& measured,
                                         const OrientationClass& open);

}  // namespace orient

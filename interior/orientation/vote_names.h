// What the votes on the scan orientation are called: for messages and results.
#pragma once

#include <string>
#include <vector>

#include "interior/orientation/film_orientation.h"

namespace orient::interior {

class VoteNames {
 public:
  // Votes were cast as if the film lay in `first`; marks are named as it lies in `chosen`, one of
  // the ways that look alike.
  VoteNames(const CameraFile& camera, const MarkShapes& shapes, ScanOrientation first,
            ScanOrientation chosen);

  // "the symbols of marks 2, 5 and the border"; empty for none. `which`: indices into `votes`.
  std::string Of(const std::vector<OrientationVote>& votes, const std::vector<size_t>& which) const;
  // Every vote with its nats for the open ways; not that of a layout without departures.
  std::vector<OrientationEvidence> Evidence(const std::vector<OrientationVote>& votes,
                                            const OrientationClass& open) const;
  // "data strip, border 2": features that no open way has on the scan; empty for none.
  std::string OffScan(const std::vector<OrientationVote>& votes) const;

 private:
  std::string MarkOf(const OrientationVote& vote) const;  // the id of the mark with the symbol
  std::string NameOf(const OrientationVote& vote) const;

  const CameraFile& camera_;
  std::optional<std::vector<int>> relabel_;
};

// Evidence() of marks that get other names: relabel[i] is the mark that mark i becomes.
void RenameSymbols(const CameraFile& camera, const std::vector<int>& relabel,
                   std::vector<OrientationEvidence>* evidence);

}  // namespace orient::interior

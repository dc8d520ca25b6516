// Single patches that are searched for at a level at which the whole photo can be searched, drawn
// as it may see them. Private to exterior.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "exterior/search/photo_level.h"
#include "exterior/steps/consensus.h"
#include "exterior/steps/photo_task.h"

namespace orient::exterior {

// Level and patches of one search; the patches are drawn in one size.
class SoughtPatches {
 public:
  // The patches with most structure of those that the photo may show from an approximate pose,
  // evenly distributed. `ground_m`: MedianGroundHeight. `level`: that of the search before, if any;
  // made anew where this one needs another. Empty: too few patches can be searched for.
  static std::optional<SoughtPatches> Of(const PhotoTask& task, double ground_m,
                                         const Pose& approximate,
                                         std::shared_ptr<const PhotoLevel>* level);

  int Reduction() const { return level_->Reduction(); }
  // One per patch, with candidates where it may appear given the prior's sigmas and what is left by
  // the steps of kappa and height; drawn as seen under a view, but without its lens.
  std::vector<VotingPatch> Seek(const PhotoView& drawn_under, const PosePrior& prior) const;

 private:
  SoughtPatches(const PhotoTask& task, double ground_m, std::vector<std::size_t> patches,
                std::shared_ptr<const PhotoLevel> level)
      : task_(task), ground_m_(ground_m), patches_(std::move(patches)), level_(std::move(level)) {}

  const PhotoTask& task_;
  double ground_m_;
  std::vector<std::size_t> patches_;
  std::shared_ptr<const PhotoLevel> level_;
};

}  // namespace orient::exterior

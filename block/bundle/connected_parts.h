// Which photos of a block are connected, and whether each connected part has a datum. Private to
// block.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "block/bundle/equations.h"

namespace orient::block {

// What is connected, as a forest: each tree is a part, known by its least member.
class Forest {
 public:
  explicit Forest(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t Root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(std::size_t a, std::size_t b) {
    parent_[std::max(Root(a), Root(b))] = std::min(Root(a), Root(b));
  }

 private:
  std::vector<std::size_t> parent_;
};

// By the observations that connect: `connects` has one per observation, `takes_part` one per
// photo. Every photo is in exactly one part. Fills photos, control_points,
// has_datum, by_control and finding.
std::vector<BlockPart> FindParts(const BlockSystem& system, const std::vector<bool>& connects,
                                 const std::vector<bool>& takes_part);

// What is reported of a part with a deficiency. `only`: the block has one part.
std::optional<Finding> FindingOf(const BlockToAdjust& block, const BlockPart& part, bool only);

// "a, b, c and 12 more"
std::string NamesOf(const BlockToAdjust& block, const std::vector<std::size_t>& photos);

}  // namespace orient::block

// The results of overlapping sub-blocks as one block's. Private to block.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"
#include "block/bundle/connected_parts.h"

namespace orient::block {

struct SubBlock {
  std::vector<std::size_t> core;    // photos, ascending; every photo is in one core
  std::vector<std::size_t> beside;  // photos that share points with the core's, ascending
  std::vector<std::size_t> photos;  // the core and those around it, ascending

  bool IsInCore(std::size_t photo) const {
    return std::binary_search(core.begin(), core.end(), photo);
  }
};

struct AdjustedSubBlock {
  const SubBlock& sub;
  std::vector<std::size_t> points, observations;  // of the result: indices into the whole's
  BlockResult result;                             // its photos are sub.photos
};

// Poses come from the sub-block in whose core the photo is; a point and all its observations come
// from one sub-block with a photo in its core that shows the point, if possible from one that
// determines it by control; observations in photos that are not adjusted are unusable, and checks
// are made of the joined poses. A part is what one sub-block adjusted together. What is about the
// block as a whole (variance components, redundancy) is the mean or sum, each sub-block counted by
// the share of it that is taken.
class JoinedSubBlocks {
 public:
  // Of the whole block.
  explicit JoinedSubBlocks(const BlockToAdjust& block);

  void Add(const AdjustedSubBlock& adjusted);
  // Once, when all are added.
  BlockResult Result(const BlockOptions& options);

 private:
  struct Component {
    VarianceComponent sum;
    double weight = 0;
  };
  struct Share {
    double taken = 0, all = 0;
    double Value() const { return all > 0 ? taken / all : 0; }
  };

  void AddPhotos(const AdjustedSubBlock& adjusted);
  void AddPoints(const AdjustedSubBlock& adjusted);
  void AddParts(const AdjustedSubBlock& adjusted);
  void AddComponents(const AdjustedSubBlock& adjusted);
  void AddStrips(const AdjustedSubBlock& adjusted);
  void AddTimings(const BlockTimings& of);
  std::map<std::string, Share> SharesOf(const AdjustedSubBlock& adjusted) const;
  void DropSightingsOfUnadjusted();
  bool IsTie(std::size_t point) const;
  void FillParts();
  void ReportConnectedParts(const std::vector<std::size_t>& together, bool only);
  void FillComponents();
  SubBlockSummary Compared() const;

  const BlockToAdjust& block_;
  BlockResult result_;
  int count_ = 0, largest_ = 0;
  bool any_converged_ = false, any_failed_ = false;
  std::vector<int> owner_of_point_;    // number of the sub-block; -1: none
  std::vector<bool> held_by_control_;  // of each point: in its owner, by a part with control
  std::vector<BlockPart> parts_;       // of all sub-blocks, one after the other
  std::vector<std::vector<std::size_t>> parts_of_photo_;
  std::vector<std::vector<std::size_t>> core_of_part_;
  std::vector<Component> components_;
  double redundancy_ = 0, squares_ = 0;
  std::map<std::string, std::pair<std::ptrdiff_t, StripGnss>> strips_;  // photos in the core
  std::vector<std::pair<std::size_t, Pose>> beside_;                    // poses that do not count
};

}  // namespace orient::block

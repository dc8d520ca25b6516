// Transforms a patch to another CRS: its position, covariance, chip and heights.
#pragma once

#include <optional>

#include "core/terrain/crs.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

class PatchTransform {
 public:
  // Throws InputError: no way from one to the other.
  PatchTransform(const Crs& target, const Crs& source);
  // The chip is turned and scaled to the target's north and metre where that moves its corner by
  // more than a tenth of a pixel (bilinear, cut to the square that stays covered). Heights are
  // taken as they are. Empty where the place has no coordinates in the target.
  std::optional<Patch> operator()(const Patch& patch) const;

 private:
  bool same_;
  CoordinateTransform target_from_source_, source_from_target_;
};

}  // namespace orient::patchdb

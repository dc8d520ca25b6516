// Ground control points that somebody surveyed and measured in oriented photos, made into patches.
#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "core/terrain/ground_surface.h"
#include "patchdb/harvest/further_views.h"
#include "patchdb/harvest/harvest_options.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

struct ControlPoint {
  std::string id;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  // X, Y, Z
};

// Where a photo shows it; `source` is not owned.
struct ControlSighting {
  const FurtherSource* source = nullptr;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

enum class ControlRefusal { kNoHeight, kNoImage, kContradicted };
inline constexpr std::array<ControlRefusal, 3> kAllControlRefusals = {
    ControlRefusal::kNoHeight, ControlRefusal::kNoImage, ControlRefusal::kContradicted};
std::string_view Name(ControlRefusal refusal);

// The chip is cut from the photo that shows the point best; where orientation and measurement
// differ, the measurement counts: its pixel is the chip's middle. The ground point is the surveyed
// one, the heights are the surface's, raised or lowered to it. The other photos become evidence.
// Refused where a measurement departs from the orientation beyond what both may be wrong (1 in
// 1000; kPointing_px), no photo shows the whole chip, or the surface does not cover it.
std::variant<Patch, ControlRefusal> MakeControlPatch(const ControlPoint& point,
                                                     const std::vector<ControlSighting>& sightings,
                                                     const GroundSurface& surface, int chip_px);

}  // namespace orient::patchdb

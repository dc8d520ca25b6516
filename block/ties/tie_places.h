// Where a photo's tie points are searched for: interest points spread over its frame, on the ground
// that it owns. Private to block.
#pragma once

#include <optional>
#include <vector>

#include "block/ties/tie.h"
#include "core/terrain/ground_surface.h"

namespace orient::block {

struct TiePlace {
  Eigen::Vector2d pixel;             // of the owner's scan
  Eigen::Vector3d ground_m;          // where its ray meets the surface
  std::vector<std::size_t> further;  // the other photos that should show it
};

// Where a photo's frame shows a ground point, at least `margin_px` inside frame and scan.
std::optional<Eigen::Vector2d> SeenAt(const TiePhoto& photo, const Eigen::Vector3d& ground_m,
                                      double margin_px);

// One list per cell that has any, the best places first: those that more photos show, then the
// strongest ones.
std::vector<std::vector<TiePlace>> FindTiePlaces(const std::vector<TiePhoto>& photos,
                                                 std::size_t owner, const GroundSurface& surface,
                                                 const TieOptions& options);

}  // namespace orient::block

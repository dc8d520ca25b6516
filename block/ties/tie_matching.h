// One place measured in another photo: the owner's window drawn as the other photo should see it,
// correlated, matched by least squares, and matched back. Private to block.
#pragma once

#include <optional>

#include "block/ties/tie_places.h"
#include "exterior/steps/align.h"

namespace orient::block {

// `from`'s picture of the ground around a point, drawn as `to` should see it: every pixel's ray is
// followed to the surface and from there into `from`. `shift_px` is added to where `from` is said
// to show the ground. Square, side odd; at full resolution of `to`, centred at `centre_px` there.
// NaN where the surface has no height or `from` no picture.
exterior::AlignedPatch AlignWindow(const TiePhoto& to, const TiePhoto& from,
                                   const GroundSurface& surface, const Eigen::Vector2d& centre_px,
                                   const Eigen::Vector2d& shift_px, int side);

// Covariance of where `other` shows the ground that `owner` shows at a pixel, px^2: both poses' and
// what stands on the surface, `height_sigma_m`.
Eigen::Matrix2d DifferenceCovariance(const TiePhoto& owner, const TiePhoto& other,
                                     const Eigen::Vector3d& ground_m, double height_sigma_m);

// Where `other` shows the place; empty where it is not found there, or not with certainty. The
// covariance is that of the difference between both photos.
std::optional<TieSighting> MatchPlace(const TiePhoto& owner, const TiePhoto& other,
                                      const TiePlace& place, const GroundSurface& surface,
                                      const TieOptions& options);

}  // namespace orient::block

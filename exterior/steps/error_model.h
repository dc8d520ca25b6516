// What is assumed of errors that no single match shows, by single photos and blocks alike.
#pragma once

#include <Eigen/Core>

namespace orient::exterior {

// An edge is known across its direction only (LsmResult::along): one of its axes has a larger sigma
// than this, no other match has.
inline constexpr double kLeastSigmaOfEdge_px = 10;
// The same for a match in a result, which has only the sigmas of both axes.
inline bool IsOfEdge(const Eigen::Vector2d& sigma_px) {
  return sigma_px.maxCoeff() > kLeastSigmaOfEdge_px;
}

// Correlation length of terrain and its errors, roughly, as a share of the flying height.
inline constexpr double kHeightCorrelationPerHeight = 0.3;

// Share of a height error's variance common to the whole region (a datum or systematic survey
// error); the rest decorrelates with distance.
inline constexpr double kCommonHeightShare = 0.5;

// Or over this share of that distance, and more smoothly, as exp(-(distance / length)^2): the error
// of a DEM too coarse for its terrain. Matches much farther apart cannot tell it from noise.
inline constexpr double kShortHeightCorrelation = 0.2;

// Film bends slowly: its errors at two places resemble one another by exp(-(distance / length)^2),
// the length being this share of the frame's shorter side.
inline constexpr double kFilmCorrelationPerFrame = 0.4;

// Share of a ground point's standard deviation from its source's orientation that is common to the
// whole source: as a shift, and as much again at its border as a linear deformation. As
// four real orthophotos have (NGI: a fifth of a pixel, where half of one is stated by default).
inline constexpr double kSharedBySource = 0.3;

// Errors that patch matches share and residuals do not show, as fractions of an observation's own
// sigma: common to all matches, and varying smoothly over the ground for those of one source.
// Fitted to pose errors in a simulated block of houses, trees and shadows; verified on other blocks
// (tools/bench/exterior_honesty.cpp).
inline constexpr double kSharedEverywhere = 0.5, kSharedSmoothly = 0.8;

}  // namespace orient::exterior

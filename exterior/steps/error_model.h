// What is assumed of errors that no single match shows, by single photos and blocks alike.
#pragma once

namespace orient::exterior {

// Matching's covariance knows the grey values' noise only. Relief between the heights' nodes and
// change of the scene add what no single match can see: one sigma of a coordinate, scan pixels.
inline constexpr double kModelSigmaPx = 0.1;

// Terrain and its errors resemble themselves over about this share of the flying height.
inline constexpr double kHeightCorrelationPerHeight = 0.3;

// Of a height error's variance: common to the whole region (a datum, a systematic survey error);
// the rest fades with distance.
inline constexpr double kCommonHeightShare = 0.5;

// Film bends slowly: its errors at two places resemble one another by exp(-(distance / length)^2),
// the length being this share of the frame's shorter side.
inline constexpr double kFilmCorrelationPerFrame = 0.4;

// What patches' matches share and residuals do not show, in shares of an observation's own standard
// deviation: what all have in common, and what those of one source share smoothly over the ground.
// As pose errors in a simulated block of houses, trees and shadows are; verified with other blocks
// (tools/bench/exterior_honesty.cpp).
inline constexpr double kSharedEverywhere = 0.5, kSharedSmoothly = 0.8;

}  // namespace orient::exterior

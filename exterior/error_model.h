// What is assumed of errors that no single match shows, by single photos and blocks alike.
#pragma once

namespace orient {

// Matching's covariance knows the grey values' noise only. Relief between the heights' nodes and
// change of the scene add what no single match can see: one sigma of a coordinate, scan pixels.
inline constexpr double kModelSigmaPx = 0.1;

// Terrain and its errors resemble themselves over about this share of the flying height.
inline constexpr double kHeightCorrelationPerHeight = 0.3;

// Film bends slowly: over this share of the frame's shorter side.
inline constexpr double kFilmCorrelationPerFrame = 0.4;

}  // namespace orient

// Approximate kappas for photos of which only the positions are known.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace orient::block {

// A nearly vertical photo over nearly level ground.
struct LevelPhoto {
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();  // projection centre, east and north
  std::map<std::string, Eigen::Vector2d> seen_mm;     // points, from the principal point
};

// Each photo is a similarity of the plane with its place observed, and points that photos share, or
// whose ground is known, join them: a planimetric adjustment of independent models (van den Hout
// 1966) with single photos for models, linear and so without any approximation. Good to some
// degrees, as tilt and relief are taken for errors. Empty for photos that it does not determine:
// with fewer than two such points, or with another scale than most have.
std::vector<std::optional<double>> KappasByPlaces(
    const std::vector<LevelPhoto>& photos, const std::map<std::string, Eigen::Vector2d>& ground_m);

}  // namespace orient::block

// Everything that stands or grows on a simulated block, at two dates.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/terrain/ground_surface.h"
#include "tools/simulate/parcels.h"

namespace orient::simulation {

// kOld: when the oriented photos were taken. kNew: when the photos to orient were.
enum class Epoch { kOld, kNew };

struct SceneOptions {
  double change = 0.2;  // share of parcels that look different; half of it for buildings
  bool objects = true;  // buildings and trees
  std::uint32_t seed = 1;
  double inverted = 0.5;  // share of the changed parcels whose contrast is inverted
};

// Positions: metres east and north of the scene's south-west corner; heights above the ground.
struct Building {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();
  Eigen::Vector2f axis = Eigen::Vector2f::UnitX();  // unit length, along the ridge
  float half_length = 6, half_width = 4;
  float eave = 4, ridge = 7;  // equal: a flat roof
  float tone = 0.4f;          // of the roof
  bool at_old = true, at_new = true;
};

struct Tree {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();
  float radius = 3, height = 8;
  float tone = 0.2f;
  std::uint32_t seed = 0;
};

struct Pond {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();
  float radius = 20;
};

enum class Change { kNone, kTone, kInverted };

struct Scene {
  Bounds extent;  // block CRS; its south-west corner is the origin of all positions above
  LandDivision land;
  std::vector<Change> parcel_change;  // one a parcel
  std::vector<Building> buildings;
  std::vector<Tree> trees;
  std::vector<Pond> ponds;
  std::uint32_t seed = 1;

  static Scene Make(const Bounds& extent, const SceneOptions& options);
};

inline bool Exists(const Building& building, Epoch epoch) {
  return epoch == Epoch::kOld ? building.at_old : building.at_new;
}

// Unit vector to the sun: the two dates have different hours and seasons.
Eigen::Vector3d SunDirection(Epoch epoch);

}  // namespace orient::simulation

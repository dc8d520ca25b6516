// How the land is divided: roads, tracks and field borders as a tree of straight cuts, looked up by
// position. Cuts are straight in warped coordinates, so that roads and borders bend gently.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace orient::simulation {

class RandomStream;

enum class LandUse { kField, kMeadow, kWood, kVillage };
enum class Border { kPlain, kHedge, kTrack, kRoad };

// Positions in this header: metres east and north of the scene's south-west corner.
struct Parcel {
  LandUse use = LandUse::kField;
  std::uint32_t seed = 0;
  float direction_rad = 0;  // of its longest side, counter-clockwise from east
  float area_m2 = 0;
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();
  std::vector<Eigen::Vector2f> outline;  // convex, counter-clockwise
};

// What lies at a position.
struct LandAt {
  int parcel = 0;
  float border_m = 1e9f;       // distance to the nearest border of the parcel
  bool hedge = false;          // that border is a hedge
  float road_m = 1e9f;         // signed distance from the nearest road's axis
  float along_m = 0;           // position along that road
  float second_road_m = 1e9f;  // distance to the axis of the next nearest: small at a crossing
  float track_m = 1e9f;        // signed distance from the nearest track's axis
};

class LandDivision {
 public:
  static LandDivision Make(float width_m, float height_m, std::uint32_t seed);
  LandAt At(float x, float y) const { return AtUnbent({x + BendX(x, y), y + BendY(x, y)}); }

  // The same in two steps, for those who know the bend of neighbouring positions already: how far
  // a position is moved (smooth over metres), and what lies at a moved position.
  float BendX(float x, float y) const;
  float BendY(float x, float y) const;
  LandAt AtUnbent(const Eigen::Vector2f& position) const;
  const std::vector<Parcel>& Parcels() const { return parcels_; }

 private:
  struct Cut {
    Eigen::Vector2f normal;
    float offset = 0;
    Border border = Border::kPlain;
    int front = 0, back = 0;  // node behind each side: >= 0 a cut, < 0 the parcel -(index + 1)
  };
  using Polygon = std::vector<Eigen::Vector2f>;
  // `through`: a cut that must be made here, because it goes on from the neighbour (a crossing).
  int Divide(const Polygon& outline, int depth, RandomStream* random, const Cut* through = nullptr);
  static Cut ChooseCut(const Polygon& outline, RandomStream* random);
  static bool Cuts(const Polygon& outline, const Cut& cut);
  int AddParcel(const Polygon& outline, RandomStream* random);
  bool NearVillage(const Eigen::Vector2f& position) const;

  std::vector<Cut> cuts_;
  std::vector<Parcel> parcels_;
  std::vector<Eigen::Vector3f> villages_;  // x, y, radius
  std::uint32_t seed_ = 0;
  int root_ = 0;
};

}  // namespace orient::simulation

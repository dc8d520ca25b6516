#include "tools/simulate/scene.h"

#include <numbers>

#include "tools/simulate/noise.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2f;

float Between(RandomStream* random, double low, double high) {
  return static_cast<float>(random->Uniform(low, high));
}

bool InsideParcel(const Parcel& parcel, const Vector2f& p, float inset_m) {
  for (size_t i = 0; i < parcel.outline.size(); ++i) {
    const Vector2f& a = parcel.outline[i];
    const Vector2f side = (parcel.outline[(i + 1) % parcel.outline.size()] - a).normalized();
    if (side.x() * (p - a).y() - side.y() * (p - a).x() < inset_m) return false;
  }
  return true;
}

Vector2f RandomPosition(const Parcel& parcel, RandomStream* random) {
  Vector2f low = parcel.outline.front(), high = low;
  for (const Vector2f& corner : parcel.outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  return {Between(random, low.x(), high.x()), Between(random, low.y(), high.y())};
}

bool FreeOfBuildings(const Scene& scene, const Vector2f& p, float radius_m) {
  for (const Building& other : scene.buildings)
    if ((other.centre - p).norm() < radius_m + std::hypot(other.half_length, other.half_width))
      return false;
  return true;
}

bool FreeOfWater(const Scene& scene, const Vector2f& p, float radius_m) {
  constexpr float kLargest = 1.35f;  // a pond's shore reaches up to this many radii out
  for (const Pond& pond : scene.ponds)
    if ((pond.centre - p).norm() < radius_m + kLargest * pond.radius) return false;
  return true;
}

bool FreeOfRoads(const Scene& scene, const Vector2f& p, float radius_m) {
  const LandAt at = scene.land.At(p.x(), p.y());
  return std::abs(at.road_m) > radius_m + 4 && std::abs(at.track_m) > radius_m + 2.5f &&
         at.border_m > radius_m * 0.8f;
}

Building MakeBuilding(const Parcel& parcel, const Vector2f& p, bool hall, double change,
                      RandomStream* random) {
  Building building;
  building.centre = p;
  const float turn = random->Chance(0.3) ? std::numbers::pi_v<float> / 2 : 0;
  const float angle = parcel.direction_rad + turn + Between(random, -0.05, 0.05);
  building.axis = {std::cos(angle), std::sin(angle)};
  building.half_length = hall ? Between(random, 11, 20) : Between(random, 5.5, 9);
  building.half_width = hall ? Between(random, 6, 9) : Between(random, 3.8, 5.2);
  building.eave = hall ? Between(random, 4.5, 7) : Between(random, 3, 5.5);
  const bool flat = hall ? random->Chance(0.5) : random->Chance(0.12);
  building.ridge = building.eave + (flat ? 0 : building.half_width * Between(random, 0.45, 0.8));
  building.tone = flat ? Between(random, 0.55, 0.85) : Between(random, 0.22, 0.62);
  const double fate = random->Uniform();
  building.at_old = fate >= 0.25 * change;
  building.at_new = !building.at_old || fate < 1 - 0.25 * change;
  return building;
}

void AddBuildings(const Parcel& parcel, double change, RandomStream* random, Scene* scene) {
  const bool village = parcel.use == LandUse::kVillage;
  const bool farm = parcel.use == LandUse::kMeadow && random->Chance(0.25);
  if (!village && !farm) return;
  const int wanted = village ? 1 + static_cast<int>(parcel.area_m2 / 380) : 3;
  int placed = 0;
  for (int attempt = 0; attempt < 12 * wanted && placed < wanted; ++attempt) {
    const Vector2f p = RandomPosition(parcel, random);
    const bool hall = random->Chance(farm ? 0.5 : 0.08);
    const Building building = MakeBuilding(parcel, p, hall, change, random);
    const float radius = std::hypot(building.half_length, building.half_width);
    if (!InsideParcel(parcel, p, radius * 0.8f) || !FreeOfRoads(*scene, p, radius) ||
        !FreeOfBuildings(*scene, p, radius + 2) || !FreeOfWater(*scene, p, radius))
      continue;
    scene->buildings.push_back(building);
    ++placed;
  }
}

void AddTree(const Vector2f& p, float largest_radius, RandomStream* random, Scene* scene) {
  Tree tree;
  tree.centre = p;
  tree.radius = Between(random, 0.45, 1.0) * largest_radius;
  tree.height = tree.radius * Between(random, 1.8, 3.2);
  tree.tone = Between(random, 0.15, 0.34);
  tree.seed = static_cast<std::uint32_t>(random->Next());
  const LandAt at = scene->land.At(p.x(), p.y());
  if (std::abs(at.road_m) < 5 + tree.radius || std::abs(at.track_m) < 1.5f + tree.radius) return;
  if (FreeOfBuildings(*scene, p, tree.radius) && FreeOfWater(*scene, p, tree.radius))
    scene->trees.push_back(tree);
}

void AddTrees(const Parcel& parcel, RandomStream* random, Scene* scene) {
  // Trees a square metre: a closed wood, gardens, an old pear tree in the field.
  const double density = parcel.use == LandUse::kWood      ? 1 / 26.0
                         : parcel.use == LandUse::kVillage ? 1 / 190.0
                         : parcel.use == LandUse::kMeadow  ? 1 / 2500.0
                                                           : 1 / 12000.0;
  Vector2f low = parcel.outline.front(), high = low;
  for (const Vector2f& corner : parcel.outline) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  const double box = static_cast<double>((high - low).prod());
  const int wanted = static_cast<int>(box * density + random->Uniform());
  const float largest = parcel.use == LandUse::kWood ? 4.5f : 3.5f;
  for (int i = 0; i < wanted; ++i) {
    const Vector2f p = RandomPosition(parcel, random);
    if (InsideParcel(parcel, p, 1)) AddTree(p, largest, random, scene);
  }
}

// Bushes and trees in a loose row along hedges: follow each parcel's sides.
void AddHedges(const Parcel& parcel, RandomStream* random, Scene* scene) {
  for (size_t i = 0; i < parcel.outline.size(); ++i) {
    const Vector2f a = parcel.outline[i];
    const Vector2f side = parcel.outline[(i + 1) % parcel.outline.size()] - a;
    const float length = side.norm();
    for (float s = 0; s < length; s += Between(random, 3, 16)) {
      const Vector2f p = a + side * (s / length);
      const LandAt at = scene->land.At(p.x(), p.y());
      if (at.hedge && random->Chance(0.6)) AddTree(p, 2.8f, random, scene);
    }
  }
}

Change ChooseChange(const SceneOptions& options, RandomStream* random) {
  if (!random->Chance(options.change)) return Change::kNone;
  return random->Chance(options.inverted) ? Change::kInverted : Change::kTone;
}

}  // namespace

Scene Scene::Make(const Bounds& extent, const SceneOptions& options) {
  Scene scene;
  scene.extent = extent;
  scene.seed = options.seed;
  scene.land = LandDivision::Make(static_cast<float>(extent.max_x - extent.min_x),
                                  static_cast<float>(extent.max_y - extent.min_y), options.seed);
  RandomStream random(Mix(options.seed + 77));
  for (size_t i = 0; i < scene.land.Parcels().size(); ++i)
    scene.parcel_change.push_back(ChooseChange(options, &random));
  for (const Parcel& parcel : scene.land.Parcels())
    if (parcel.use == LandUse::kMeadow && parcel.area_m2 > 4000 && random.Chance(0.3))
      scene.ponds.push_back(
          {parcel.centre, std::sqrt(parcel.area_m2) * Between(&random, 0.12, 0.25)});
  if (!options.objects) return scene;
  for (const Parcel& parcel : scene.land.Parcels())
    AddBuildings(parcel, options.change, &random, &scene);
  for (const Parcel& parcel : scene.land.Parcels()) {
    AddTrees(parcel, &random, &scene);
    AddHedges(parcel, &random, &scene);
  }
  return scene;
}

Eigen::Vector3d SunDirection(Epoch epoch) {
  // Azimuth clockwise from north, elevation: a summer forenoon, and an earlier hour in spring.
  const double azimuth = (epoch == Epoch::kOld ? 142.0 : 118.0) * std::numbers::pi / 180;
  const double elevation = (epoch == Epoch::kOld ? 51.0 : 43.0) * std::numbers::pi / 180;
  return {std::sin(azimuth) * std::cos(elevation), std::cos(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

}  // namespace orient::simulation

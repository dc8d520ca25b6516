#include "tools/simulate/scene.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/simulate/ground_raster.h"

namespace orient::simulation {
namespace {

constexpr Bounds kExtent{5000, 7000, 6200, 8000};

Scene MakeScene(double change = 0.2, bool objects = true) {
  return Scene::Make(kExtent, {change, objects, 3});
}

TEST(Scene, HasRoadsWithCrossingsFieldsAndHouses) {
  const Scene scene = MakeScene();
  EXPECT_GT(scene.land.Parcels().size(), 100u);
  EXPECT_GT(scene.buildings.size(), 20u);
  EXPECT_GT(scene.trees.size(), 300u);
  int road = 0, crossing = 0;
  for (float y = 1; y < 1000; y += 3)
    for (float x = 1; x < 1200; x += 3) {
      const LandAt at = scene.land.At(x, y);
      if (std::abs(at.road_m) < 4) ++road;
      if (std::abs(at.road_m) < 4 && at.second_road_m < 4) ++crossing;
    }
  EXPECT_GT(road, 1000);
  EXPECT_GT(crossing, 5);
}

TEST(Scene, NoHouseStandsOnARoad) {
  const Scene scene = MakeScene();
  for (const Building& building : scene.buildings)
    EXPECT_GT(std::abs(scene.land.At(building.centre.x(), building.centre.y()).road_m),
              4 + building.half_width);
}

TEST(Scene, NoHouseStandsInWater) {
  const Scene scene = MakeScene();
  ASSERT_FALSE(scene.ponds.empty());
  for (const Building& building : scene.buildings)
    for (const Pond& pond : scene.ponds)
      EXPECT_GT((building.centre - pond.centre).norm(), pond.radius + building.half_width);
}

TEST(Scene, WithoutChangeTheHousesStay) {
  const Scene same = MakeScene(0), other = MakeScene(0.8);
  for (const Building& building : same.buildings) EXPECT_TRUE(building.at_old && building.at_new);
  for (const Change change : same.parcel_change) EXPECT_EQ(change, Change::kNone);
  int gone = 0, fresh = 0;
  for (const Building& building : other.buildings) {
    EXPECT_TRUE(building.at_old || building.at_new);
    gone += building.at_new ? 0 : 1;
    fresh += building.at_old ? 0 : 1;
  }
  EXPECT_GT(gone, 0);
  EXPECT_GT(fresh, 0);
}

TEST(Scene, OfTheChangedParcelsTheShareAskedForIsInverted) {
  const Scene scene = Scene::Make(kExtent, {0.6, false, 3, 0.9});
  int inverted = 0, tone = 0;
  for (const Change change : scene.parcel_change) {
    inverted += change == Change::kInverted ? 1 : 0;
    tone += change == Change::kTone ? 1 : 0;
  }
  ASSERT_GT(inverted + tone, 60);
  EXPECT_NEAR(static_cast<double>(inverted) / (inverted + tone), 0.9, 0.1);
}

// Correlation of the two dates' tones over the parcels with a given change.
double Correlation(Change change) {
  const Scene scene = MakeScene(0.5, false);
  const Terrain terrain = Terrain::Make(kExtent, {250, 20, 5, 1});
  const Bounds part{5300, 7300, 5900, 7800};
  const GroundRaster a = RenderGround(scene, terrain, Epoch::kOld, part, 1.0);
  const GroundRaster b = RenderGround(scene, terrain, Epoch::kNew, part, 1.0);
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (double y = 7301.5; y < 7799; y += 1)
    for (double x = 5301.5; x < 5899; x += 1) {
      const LandAt at = scene.land.At(static_cast<float>(x - 5000), static_cast<float>(y - 7000));
      const auto parcel = static_cast<size_t>(at.parcel);
      if (scene.parcel_change[parcel] != change || at.border_m < 8 ||
          scene.land.Parcels()[parcel].use != LandUse::kField)
        continue;
      const double va = a.ToneAt(x, y), vb = b.ToneAt(x, y);
      n += 1;
      sa += va, sb += vb, saa += va * va, sbb += vb * vb, sab += va * vb;
    }
  return (n * sab - sa * sb) / std::sqrt((n * saa - sa * sa) * (n * sbb - sb * sb));
}

TEST(Scene, UnchangedFieldsLookAlikeAndInvertedOnesOpposite) {
  EXPECT_GT(Correlation(Change::kNone), 0.7);
  EXPECT_LT(Correlation(Change::kInverted), -0.5);
}

TEST(GroundRaster, CoarseAndFineRastersShowTheSameLand) {
  const Scene scene = MakeScene();
  const Terrain terrain = Terrain::Make(kExtent, {250, 20, 5, 1});
  const Bounds part{5400, 7400, 5500, 7500};
  const GroundRaster fine = RenderGround(scene, terrain, Epoch::kOld, part, 0.25);
  const GroundRaster coarse = RenderGround(scene, terrain, Epoch::kOld, part, 1.0);
  double difference = 0;
  int count = 0;
  for (double y = 7402.5; y < 7498; y += 1)
    for (double x = 5402.5; x < 5498; x += 1, ++count) {
      double sum = 0;
      for (const double dx : {-0.375, -0.125, 0.125, 0.375})
        for (const double dy : {-0.375, -0.125, 0.125, 0.375}) sum += fine.ToneAt(x + dx, y + dy);
      difference += std::abs(sum / 16 - coarse.ToneAt(x, y));
    }
  EXPECT_LT(difference / count, 0.03);
}

}  // namespace
}  // namespace orient::simulation

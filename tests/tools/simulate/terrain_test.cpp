#include "tools/simulate/terrain.h"

#include <gtest/gtest.h>

namespace orient::simulation {
namespace {

TEST(Terrain, NodesLieInTheCentresOfCells) {
  Eigen::MatrixXf heights(2, 3);
  heights << 1, 2, 3, 4, 5, 6;
  const Terrain terrain(heights, 100, 200, 10);
  EXPECT_DOUBLE_EQ(terrain.HeightAt(105, 195), 1);  // north-west cell
  EXPECT_DOUBLE_EQ(terrain.HeightAt(125, 185), 6);  // south-east cell
  EXPECT_DOUBLE_EQ(terrain.HeightAt(110, 190), 3);  // the corner between four cells
  EXPECT_DOUBLE_EQ(terrain.HeightAt(90, 300), 1);   // beyond the edge: the nearest
}

TEST(Terrain, HasTheReliefAskedFor) {
  const Terrain terrain = Terrain::Make({0, 0, 1500, 1000}, {300, 80, 5, 7});
  EXPECT_NEAR(terrain.MaxHeight() - terrain.MinHeight(), 80, 1e-3);
  EXPECT_NEAR(terrain.MinHeight(), 260, 1e-3);
  EXPECT_GT(terrain.MaxSlope(), 0.02);
  EXPECT_LT(terrain.MaxSlope(), 0.9);
}

TEST(Terrain, LongerWavesAreLessSteep) {
  const Bounds extent{0, 0, 8000, 8000};
  const Terrain hills = Terrain::Make(extent, {300, 800, 50, 7});
  const Terrain mountains = Terrain::Make(extent, {300, 800, 50, 7, 6000});
  EXPECT_LT(mountains.MaxSlope(), 0.6 * hills.MaxSlope());
}

TEST(Terrain, FlatWhereNoReliefIsAskedFor) {
  const Terrain terrain = Terrain::Make({0, 0, 300, 300}, {300, 0, 5, 7});
  EXPECT_EQ(terrain.MinHeight(), 300);
  EXPECT_EQ(terrain.MaxSlope(), 0);
}

TEST(Terrain, SlopesTowardsTheSunAreBrighter) {
  Eigen::MatrixXf heights(3, 3);
  heights << 0, 2, 4, 0, 2, 4, 0, 2, 4;  // rises to the east: faces west
  const Terrain terrain(heights, 0, 30, 10);
  const Eigen::Vector3d east = Eigen::Vector3d(1, 0, 1).normalized();
  EXPECT_LT(terrain.Shading(east)(1, 1), 0.9f);
  EXPECT_GT(terrain.Shading(Eigen::Vector3d(-1, 0, 1).normalized())(1, 1), 1.1f);
}

}  // namespace
}  // namespace orient::simulation

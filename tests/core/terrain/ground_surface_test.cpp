#include "core/terrain/ground_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/base/error.h"
#include "tests/core/terrain/rough_ground.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kClosedForm = 1e-9;
constexpr double kOnSurface_m = 1e-4;  // what the header promises

TEST(GroundSurface, IsBilinearBetweenCellCentres) {
  Eigen::MatrixXf heights(2, 2);
  heights << 10, 20, 30, 60;
  const GroundSurface surface = GroundSurface::FromGrid(heights, 100, 200, 2);
  EXPECT_NEAR(surface.HeightAt(101, 199).value(), 10, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(103, 199).value(), 20, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(101, 197).value(), 30, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(103, 197).value(), 60, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(102, 198).value(), 30, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(101.5, 198.5).value(), 10 + 2.5 + 5 + 20 / 16.0, kClosedForm);
  EXPECT_EQ(surface.MinHeight(), 10);
  EXPECT_EQ(surface.MaxHeight(), 60);
  EXPECT_EQ(surface.MeanHeight(), 30);
  EXPECT_EQ(surface.CellSize(), 2);
  EXPECT_EQ(surface.Extent().min_x, 101);
  EXPECT_EQ(surface.Extent().max_y, 199);
}

TEST(GroundSurface, HasNoHeightBeyondItsOutermostNodesOrBesideNodata) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(4, 4, 5.f);
  heights(1, 1) = kNone;
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 4, 1);
  EXPECT_TRUE(surface.HeightAt(3.2, 1.2));
  EXPECT_FALSE(surface.HeightAt(0.49, 1.2));
  EXPECT_FALSE(surface.HeightAt(3.51, 1.2));
  EXPECT_FALSE(surface.HeightAt(2, 3.51));
  EXPECT_FALSE(surface.HeightAt(2, 0.49));
  EXPECT_FALSE(surface.HeightAt(1.9, 2.9));
  EXPECT_FALSE(surface.HeightAt(std::nan(""), 2));
  EXPECT_FALSE(surface.HeightAt(1e30, -1e30));
}

TEST(GroundSurface, FewerThanTwoNodesOrNoCellSizeIsABrokenPromise) {
  EXPECT_THROW(GroundSurface::FromGrid(Eigen::MatrixXf::Zero(1, 5), 0, 0, 1),
               std::invalid_argument);
  EXPECT_THROW(GroundSurface::FromGrid(Eigen::MatrixXf::Zero(5, 5), 0, 0, 0),
               std::invalid_argument);
}

TEST(GroundSurface, APlumbLineHitsTheHeightBelow) {
  std::mt19937 random(TestSeed());
  const GroundSurface surface =
      GroundSurface::FromGrid(RoughGround(20, 20, 0, &random), 500000, 5000000, 5);
  for (const double x : {500002.5, 500010.0, 500033.3, 500097.5}) {
    const auto hit = surface.Intersect({{x, 4999950, 4000}, {0, 0, -1}});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->z(), surface.HeightAt(x, 4999950).value(), kClosedForm);
  }
}

// The slow and obvious way: march in steps of a hundredth of a cell and look for the first change
// from above to below, with no hole in between.
std::optional<Eigen::Vector3d> March(const GroundSurface& surface, const Ray& ray) {
  const double step = surface.CellSize() / 100;
  bool above = false;
  const double begin = (surface.MaxHeight() + 0.5 - ray.origin_m.z()) / ray.direction.z();
  const double end = (surface.MinHeight() - 0.5 - ray.origin_m.z()) / ray.direction.z();
  for (double t = begin; t < end; t += step) {
    const Eigen::Vector3d p = ray.origin_m + t * ray.direction;
    const auto height = surface.HeightAt(p.x(), p.y());
    if (height && p.z() <= *height) return above ? std::optional(p) : std::nullopt;
    above = height.has_value();
  }
  return std::nullopt;
}

TEST(GroundSurface, TheFirstHitIsTheOneOfTheSlowAndObviousWay) {
  std::mt19937 random(TestSeed());
  std::uniform_real_distribution<double> any(0, 1);
  int hits = 0;
  for (const double holes : {0.0, 0.03}) {
    const GroundSurface surface =
        GroundSurface::FromGrid(RoughGround(30, 40, holes, &random), 1000, 2000, 10);
    for (int i = 0; i < 400; ++i) {
      const Eigen::Vector3d origin(1000 + 400 * any(random), 1700 + 300 * any(random), 700);
      const Eigen::Vector3d to(1000 + 400 * any(random), 1700 + 300 * any(random), 100);
      const Ray ray = From(origin, to);
      const auto hit = surface.Intersect(ray);
      const auto marched = March(surface, ray);
      // A ray that grazes a crest within a marching step can only be told apart by the exact way.
      if (hit && !marched && holes > 0) continue;
      ASSERT_EQ(hit.has_value(), marched.has_value()) << "ray " << i;
      if (!hit) continue;
      ++hits;
      EXPECT_NEAR(surface.HeightAt(hit->x(), hit->y()).value_or(0), hit->z(), kOnSurface_m);
      const double missed = (*marched - *hit).norm();
      if (missed > 0.2) {  // more than two steps: then the hit lies before, and is a real one
        EXPECT_LT(hit->z(), marched->z() + 40);
        EXPECT_GT((*marched - origin).norm(), (*hit - origin).norm());
      }
    }
  }
  EXPECT_GT(hits, 400);
}

TEST(GroundSurface, ACliffIsHitOnItsFaceAndHidesWhatLiesBehind) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Zero(10, 10);
  heights.rightCols(5).setConstant(200);  // rises within one cell, between x = 4.5 and 5.5
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 10, 1);
  const auto face = surface.Intersect(From({-100, 5, 210}, {7, 5, 100}));
  ASSERT_TRUE(face);
  EXPECT_GT(face->x(), 4.5);
  EXPECT_LT(face->x(), 5.5);
  EXPECT_NEAR(face->z(), surface.HeightAt(face->x(), 5).value(), kOnSurface_m);
  // From the other side the plateau's edge hides the foot.
  const auto top = surface.Intersect(From({109, 5, 300}, {4, 5, 100}));
  EXPECT_FALSE(top);  // enters the DEM below the plateau: what hides it lies outside
  const auto plateau = surface.Intersect(From({9, 5, 230}, {6, 5, 195}));
  ASSERT_TRUE(plateau);
  EXPECT_NEAR(plateau->z(), 200, kOnSurface_m);
}

TEST(GroundSurface, AGrazingRayFindsTheCrestOrPassesOverIt) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Zero(50, 50);
  heights.col(25).setConstant(10);  // a wall with its crest at x = 25.5
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 50, 1);
  const auto under = surface.Intersect(From({1, 20, 10.1}, {49, 20, 9.7}));
  ASSERT_TRUE(under);
  EXPECT_NEAR(under->x(), 25.5, 0.1);
  EXPECT_FALSE(surface.Intersect(From({1, 20, 10.2}, {49, 20, 9.9})));  // leaves the DEM behind it
  const auto level = surface.Intersect({{1, 20, 5}, {1, 0, 0}});
  ASSERT_TRUE(level);
  EXPECT_NEAR(level->x(), 25, kOnSurface_m);  // half way up
  EXPECT_FALSE(surface.Intersect({{1, 20, 11}, {1, 0, 0}}));
}

TEST(GroundSurface, RaysThatDoNotMeetTheGroundHaveNoPoint) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(10, 10, 50.f);
  heights.block(3, 3, 4, 4).setConstant(kNone);
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 10, 1);
  EXPECT_TRUE(surface.Intersect({{1, 1, 500}, {0, 0, -1}}));
  EXPECT_FALSE(surface.Intersect({{1, 1, 500}, {0, 0, 1}})) << "points up";
  EXPECT_FALSE(surface.Intersect({{1, 1, 40}, {0, 0, -1}})) << "starts under the ground";
  EXPECT_FALSE(surface.Intersect({{5, 5, 500}, {0, 0, -1}})) << "only nodata";
  EXPECT_FALSE(surface.Intersect({{90, 1, 500}, {0, 0, -1}})) << "beside the DEM";
  EXPECT_FALSE(surface.Intersect(From({1, 1, 500}, {400, 1, 50}))) << "leaves the DEM";
  EXPECT_FALSE(surface.Intersect({{1, 1, 500}, {0, std::nan(""), -1}}));
  // Comes down inside the hole and would come out of the ground beyond it: hidden, not seen.
  EXPECT_FALSE(surface.Intersect(From({5, 5, 51}, {9, 5, 48})));
}

TEST(GroundSurface, ARayMayPassOverAHole) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(10, 20, 50.f);
  heights.block(0, 5, 10, 3).setConstant(kNone);
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 10, 1);
  const auto hit = surface.Intersect(From({-100, 5, 160}, {10, 5, 50}));
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->x(), 10, kOnSurface_m);
}

// ---- files -------------------------------------------------------------------------------------

}  // namespace
}  // namespace orient

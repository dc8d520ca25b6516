// Curvature and refraction: the textbooks' numbers, and sizes and signs from first principles (a
// sphere; Snell's law in a layered atmosphere).
#include "core/terrain/earth_effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/collinearity.h"

namespace orient {
namespace {

constexpr double kC_mm = 152;

Camera WideAngle() {
  Camera camera;
  camera.principal_distance_mm = kC_mm;
  camera.frame_mm = {230, 230};
  return camera;
}

double Refraction(double flying_m) { return RefractionOfStandardAtmosphere(flying_m, 0); }

double Textbook(double flying_m, double r_mm) {
  const double inwards = flying_m * std::pow(r_mm, 3) / (2 * kEarthRadius_m * kC_mm * kC_mm);
  return Refraction(flying_m) * std::pow(r_mm, 3) / (kC_mm * kC_mm) - inwards;
}

// Where a vertical photo shows the point `across_m` from the nadir of a sphere, without air.
double ImageOfSphere(double flying_m, double across_m) {
  const double angle = across_m / kEarthRadius_m;
  const double down = flying_m + kEarthRadius_m * (1 - std::cos(angle));
  return kC_mm * kEarthRadius_m * std::sin(angle) / down;
}

// How far from the nadir a ray meets flat ground that leaves the camera at the slope `tangent`,
// through air that thins out by height (Snell's law in flat layers).
double AcrossThroughAir(double flying_m, double tangent) {
  const auto index = [](double height_m) { return 1 + 277e-6 * std::exp(-height_m / 9700); };
  const double sine = tangent / std::hypot(1, tangent) * index(flying_m);
  constexpr int kLayers = 20000;
  double across = 0;
  for (int i = 0; i < kLayers; ++i) {
    const double here = sine / index(flying_m * (i + 0.5) / kLayers);
    across += flying_m / kLayers * here / std::sqrt(1 - here * here);
  }
  return across;
}

TEST(EarthEffects, TogetherAreTheTextbooksCorrections) {
  const double height_m = 4000, r_mm = 110;
  // H r^3 / (2 R c^2) = 18.1 um inwards, K r^3 / c^2 = 2.2 um outwards.
  EXPECT_NEAR(EarthDistortion(kC_mm, height_m, 0) * std::pow(r_mm, 3), Textbook(height_m, r_mm),
              1e-12);
  EXPECT_NEAR(Textbook(height_m, r_mm), -0.0181 + 0.0023, 1e-4);
  EXPECT_NEAR(1e6 * Refraction(3000), 30.0, 0.05);
}

TEST(EarthEffects, CurvatureMovesImagePointsAsASphereDoes) {
  const double flying_m = 4000;
  for (const double r_mm : {40.0, 80.0, 110.0, 150.0}) {
    const double moved = ImageOfSphere(flying_m, r_mm / kC_mm * flying_m) - r_mm;
    const double cubic = -flying_m * std::pow(r_mm, 3) / (2 * kEarthRadius_m * kC_mm * kC_mm);
    EXPECT_LT(moved, 0);
    EXPECT_NEAR(moved, cubic, 0.003 * std::abs(cubic)) << r_mm;
  }
}

TEST(EarthEffects, RefractionMovesImagePointsAsSnellsLawDoes) {
  const double flying_m = 6000, K = Refraction(flying_m);
  for (const double r_mm : {40.0, 80.0, 110.0, 150.0}) {
    const double straight_mm = kC_mm * AcrossThroughAir(flying_m, r_mm / kC_mm) / flying_m;
    const double textbook = K * (r_mm + std::pow(r_mm, 3) / (kC_mm * kC_mm));
    EXPECT_GT(r_mm, straight_mm);
    EXPECT_NEAR(r_mm - straight_mm, textbook, 0.03 * textbook) << r_mm;
  }
}

TEST(EarthEffects, RefractionIsThatOfTheAirBetweenCameraAndGround) {
  EXPECT_LT(RefractionOfStandardAtmosphere(6000, 2000), Refraction(6000));
  EXPECT_EQ(RefractionOfStandardAtmosphere(1000, 1000), 0);
}

// The whole chain: a ground point on the sphere, projected by its map coordinates.
TEST(EarthEffects, ACameraOverTheEarthShowsMapCoordinatesWhereTheyAre) {
  const double flying_m = 4000;
  const Camera camera = WithEarthEffects(WideAngle(), EarthMode::kCurved, flying_m, 0);
  const Pose pose = {{500000, 5000000, flying_m}, {0, 0, 0}};
  const double across_m = 110 / kC_mm * flying_m;
  const auto seen = PhotoFromGround(camera, pose, {500000 + across_m, 5000000, 0});
  ASSERT_TRUE(seen);
  const double refracted = Refraction(flying_m) * std::pow(110, 3) / (kC_mm * kC_mm);
  EXPECT_NEAR(seen->x(), ImageOfSphere(flying_m, across_m) + refracted, 1e-4);
}

TEST(EarthEffects, AddToEveryKindOfLens) {
  const Eigen::Vector2d point(70, -90);
  const double k1 = EarthDistortion(kC_mm, 5000, 200);
  const Eigen::Vector2d added = k1 * point.squaredNorm() * point;
  for (const LensDistortion& lens :
       {LensDistortion{}, LensDistortion{BrownDistortion{{1e-8, 2e-13, 0}, {1e-7, 0}}},
        LensDistortion{RadialTable{{0, 50, 100, 150}, {0, 4, -2, 6}}}}) {
    Camera camera = WideAngle();
    camera.lens = lens;
    const Camera over = WithEarthEffects(camera, EarthMode::kCurved, 5000, 200);
    EXPECT_LT((DistortionAt(over.lens, point) - DistortionAt(lens, point) - added).norm(), 5e-5);
  }
}

TEST(EarthEffects, CurvatureIsToldFromRefraction) {
  for (const double flying_m : {800.0, 3500.0, 9000.0})
    for (const double ground_m : {0.0, 700.0}) {
      const Camera over = WithEarthEffects(WideAngle(), EarthMode::kCurved, flying_m, ground_m);
      const double curvature = -(flying_m - ground_m) / (2 * kEarthRadius_m * kC_mm * kC_mm);
      EXPECT_NEAR(CurvatureOf(over, ground_m), curvature, 1e-6 * std::abs(curvature));
    }
  EXPECT_EQ(CurvatureOf(WideAngle(), 0), 0);
}

TEST(EarthEffects, LargestIsWhatTheFlyingHeightDoesNotAbsorb) {
  const double k1 = EarthDistortion(kC_mm, 5000, 0);
  double upper = 0, lower = 0, largest = 0;
  const auto all = [](auto&& visit) {
    for (int i = -50; i <= 50; ++i)
      for (int j = -50; j <= 50; ++j) visit(115 * std::hypot(i / 50.0, j / 50.0));
  };
  all([&](double r) { upper += k1 * std::pow(r, 4), lower += r * r; });
  all([&](double r) { largest = std::max(largest, std::abs(k1 * r * r * r - r * upper / lower)); });
  EXPECT_NEAR(LargestUnabsorbed(WideAngle(), k1), largest, 0.05 * largest);
}

TEST(EarthEffects, AreOnByThemselvesWhereTheyExceedATenthOfAPixel) {
  // Film at 1:10 000: 10 um in the corners.
  EXPECT_LT(WithEarthEffects(WideAngle(), EarthMode::kAuto, 1700, 200).earth_k1, 0);
  EXPECT_EQ(WithEarthEffects(WideAngle(), EarthMode::kFlat, 1700, 200).earth_k1, 0);
  Camera drone = WideAngle();
  drone.kind = CameraKind::kDigital;
  drone.principal_distance_mm = 10;
  drone.frame_mm = {13, 9};
  drone.image_px = Eigen::Vector2i(5472, 3648);
  EXPECT_EQ(WithEarthEffects(drone, EarthMode::kAuto, 300, 200).earth_k1, 0);
  EXPECT_LT(WithEarthEffects(drone, EarthMode::kCurved, 300, 200).earth_k1, 0);
}

}  // namespace
}  // namespace orient

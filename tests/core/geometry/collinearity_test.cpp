#include "core/geometry/collinearity.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "tests/support/generators.h"

namespace orient {
namespace {

constexpr double kClosedForm = 1e-9;

Camera Rc10() {
  Camera camera;
  camera.principal_distance_mm = 153.29;
  camera.principal_point_mm = {0.012, -0.3};
  camera.lens = BrownDistortion{{4e-7, -1e-11, 3e-16}, {3e-6, -2e-6}};
  return camera;
}

TEST(Collinearity, AVerticalPhotoHasXToTheEastAndYToTheNorth) {
  Camera camera;
  camera.principal_distance_mm = 150;
  const Pose pose = {{1000, 2000, 1500}, {0, 0, 0}};
  const auto photo = PhotoFromGround(camera, pose, {1100, 2050, 0});
  ASSERT_TRUE(photo);
  EXPECT_NEAR(photo->x(), 10, kClosedForm);  // 100 m * 0.150 m / 1500 m
  EXPECT_NEAR(photo->y(), 5, kClosedForm);
}

TEST(Collinearity, KappaOfNinetyDegreesTurnsTheFilmNotTheGround) {
  Camera camera;
  camera.principal_distance_mm = 150;
  const Pose pose = {{0, 0, 1500}, {0, 0, std::numbers::pi / 2}};
  const auto photo = PhotoFromGround(camera, pose, {0, 100, 0});  // to the north
  ASSERT_TRUE(photo);
  EXPECT_NEAR(photo->x(), 10, kClosedForm);
  EXPECT_NEAR(photo->y(), 0, kClosedForm);
}

TEST(Collinearity, PrincipalPointAndDistortionAreAdded) {
  Camera camera;
  camera.principal_distance_mm = 150;
  camera.principal_point_mm = {1, 2};
  camera.lens = BrownDistortion{{1e-4, 0, 0}, {0, 0}};
  const auto photo = PhotoFromGround(camera, {{0, 0, 1500}, {0, 0, 0}}, {100, 0, 0});
  ASSERT_TRUE(photo);
  EXPECT_NEAR(photo->x(), 1 + 10 + 10 * 1e-4 * 100, kClosedForm);
  EXPECT_NEAR(photo->y(), 2, kClosedForm);
}

TEST(Collinearity, APointBehindOrBesideTheCameraIsNotSeen) {
  const Pose pose = {{0, 0, 1500}, {0, 0, 0}};
  EXPECT_FALSE(PhotoFromGround(Rc10(), pose, {10, 10, 1600}));
  EXPECT_FALSE(PhotoFromGround(Rc10(), pose, {10, 10, 1500}));
  EXPECT_FALSE(PhotoFromGround(Rc10(), pose, pose.position_m));
  EXPECT_FALSE(PhotoFromGroundWithDerivatives(Rc10(), pose, {10, 10, 1600}));
}

TEST(Collinearity, APointWhereTheLensModelFoldedOverIsNotSeen) {
  Camera camera;
  camera.principal_distance_mm = 150;
  camera.lens = BrownDistortion{{-1e-5, 0, 0}, {0, 0}};  // folds at 182.6 mm
  const Pose pose = {{0, 0, 1500}, {0, 0, 0}};
  EXPECT_TRUE(PhotoFromGround(camera, pose, {1800, 0, 0}));
  // Without the check this point would come out at x = 33 mm, in the middle of the photo.
  EXPECT_FALSE(PhotoFromGround(camera, pose, {3000, 0, 0}));
  EXPECT_FALSE(PhotoFromGroundWithDerivatives(camera, pose, {3000, 0, 0}));
}

struct Scene {
  Pose pose;
  Eigen::Vector3d ground_m;
};

rc::Gen<Scene> AnyScene() {
  return rc::gen::exec([] {
    Scene scene;
    scene.pose.position_m = {*InRange(4e5, 6e5), *InRange(5e6, 5.1e6), *InRange(1000, 3000)};
    scene.pose.opk_rad = {*InRange(-0.2, 0.2), *InRange(-0.2, 0.2), *InRange(-3.1, 3.1)};
    scene.ground_m =
        scene.pose.position_m +
        Eigen::Vector3d(*InRange(-400, 400), *InRange(-400, 400), -*InRange(900, 1500));
    return scene;
  });
}

TEST(Collinearity, DerivativesAgreeWithDifferences) {
  EXPECT_TRUE(rc::check("derivatives", [] {
    const Scene scene = *AnyScene();
    const Camera camera = Rc10();
    const auto at = [&camera](const Vector6d& pose, const Eigen::Vector3d& ground_m) {
      return PhotoFromGround(camera, Pose::FromVector(pose), ground_m).value();
    };
    const Vector6d pose = scene.pose.AsVector();
    const auto d = PhotoFromGroundWithDerivatives(camera, scene.pose, scene.ground_m);
    RC_ASSERT(d.has_value());
    RC_ASSERT((d->photo_mm - at(pose, scene.ground_m)).norm() < kClosedForm);
    // Metres: coordinates of 5e6 m carry 1e-9 m, over a step of 0.1 m that is 1e-9 mm per m.
    constexpr double kStep_m = 0.1, kStep_rad = 1e-5, kTolerance = 3e-7;
    for (int i = 0; i < 6; ++i) {
      const double step = i < 3 ? kStep_m : kStep_rad;
      const Vector6d shift = step * Vector6d::Unit(i);
      const Eigen::Vector2d difference =
          (at(pose + shift, scene.ground_m) - at(pose - shift, scene.ground_m)) / (2 * step);
      RC_ASSERT((d->by_pose.col(i) - difference).norm() < kTolerance * (1 + difference.norm()));
    }
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d shift = kStep_m * Eigen::Vector3d::Unit(i);
      const Eigen::Vector2d difference =
          (at(pose, scene.ground_m + shift) - at(pose, scene.ground_m - shift)) / (2 * kStep_m);
      RC_ASSERT((d->by_ground.col(i) - difference).norm() < kTolerance);
    }
  }));
}

TEST(Collinearity, DerivativeByThePrincipalDistanceAgreesWithDifferences) {
  const Pose pose = {{0, 0, 1500}, {0.05, -0.02, 1}};
  const Eigen::Vector3d ground(300, -200, 100);
  Camera longer = Rc10(), shorter = Rc10();
  constexpr double kStep = 1e-3;
  longer.principal_distance_mm += kStep;
  shorter.principal_distance_mm -= kStep;
  const Eigen::Vector2d difference = (PhotoFromGround(longer, pose, ground).value() -
                                      PhotoFromGround(shorter, pose, ground).value()) /
                                     (2 * kStep);
  const auto d = PhotoFromGroundWithDerivatives(Rc10(), pose, ground);
  EXPECT_LT((d.value().by_principal_distance - difference).norm(), 1e-8);
}

TEST(Collinearity, TheRayOfAnImagePointPassesThroughItsGroundPoint) {
  EXPECT_TRUE(rc::check("ground -> photo -> ray", [] {
    const Scene scene = *AnyScene();
    const auto photo = PhotoFromGround(Rc10(), scene.pose, scene.ground_m);
    const auto ray = GroundRayFromPhoto(Rc10(), scene.pose, photo.value());
    RC_ASSERT(ray.has_value());
    const Eigen::Vector3d offset = scene.ground_m - ray->origin_m;
    RC_ASSERT(std::abs(ray->direction.norm() - 1) < 1e-12);
    const double along = offset.dot(ray->direction);
    RC_ASSERT(along > 0);
    RC_ASSERT((offset - along * ray->direction).norm() < 1e-8);  // 5e6 m carries 1e-9 m
  }));
}

TEST(Collinearity, NoRayWhereTheLensHasNoInverse) {
  Camera camera = Rc10();
  camera.lens = BrownDistortion{{-1e-5, 0, 0}, {0, 0}};
  EXPECT_FALSE(GroundRayFromPhoto(camera, {}, {160, 0}));
}

}  // namespace
}  // namespace orient

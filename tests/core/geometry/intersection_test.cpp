#include "core/geometry/intersection.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "tests/support/shared_data.h"

namespace orient {
namespace {

Camera Film() {
  Camera camera;
  camera.principal_distance_mm = 153.0;
  camera.lens = BrownDistortion{{2e-8, -1e-12, 0}, {1e-7, 2e-7}};
  return camera;
}

const std::vector<Pose> kPoses = {{{610000, 5120000, 1800}, {0.02, -0.03, 1.0}},
                                  {{610900, 5120050, 1820}, {-0.01, 0.02, 1.1}},
                                  {{610450, 5120800, 1790}, {0.03, 0.01, -2.0}}};
const Eigen::Vector3d kPoint(610400, 5120300, 240);

std::vector<PhotoObservation> Exact(const Camera& camera, std::size_t count) {
  std::vector<PhotoObservation> photos;
  for (std::size_t i = 0; i < count; ++i)
    photos.push_back({&camera, kPoses[i], PhotoFromGround(camera, kPoses[i], kPoint).value()});
  return photos;
}

TEST(IntersectRays, TheMiddleOfTheCommonPerpendicular) {
  const auto middle = IntersectRays({{{0, 0, 10}, {1, 0, 0}}, {{5, -3, 12}, {0, 1, 0}}});
  ASSERT_TRUE(middle);
  EXPECT_LT((*middle - Eigen::Vector3d(5, 0, 11)).norm(), 1e-12);
}

TEST(IntersectRays, ParallelRaysOneRayAndRaysThatMeetBehindHaveNoPoint) {
  const Eigen::Vector3d down(0, 0, -1);
  EXPECT_FALSE(IntersectRays({{{0, 0, 10}, down}, {{5, 0, 10}, down}}));
  EXPECT_FALSE(IntersectRays({{{0, 0, 10}, down}}));
  const Eigen::Vector3d left(-0.6, 0, -0.8), right(0.6, 0, -0.8);
  EXPECT_FALSE(IntersectRays({{{0, 0, 10}, left}, {{5, 0, 10}, right}}));
  EXPECT_TRUE(IntersectRays({{{0, 0, 10}, right}, {{5, 0, 10}, left}}));
}

TEST(IntersectPhotos, ExactObservationsGiveTheExactPoint) {
  const Camera camera = Film();
  for (const std::size_t count : {2u, 3u}) {
    const auto result = IntersectPhotos(Exact(camera, count));
    ASSERT_TRUE(result);
    EXPECT_LT((result->ground_m - kPoint).norm(), 1e-6);
    EXPECT_EQ(result->degrees_of_freedom, static_cast<int>(2 * count) - 3);
  }
}

TEST(IntersectPhotos, CovarianceIsTheScatterOfManyIntersections) {
  const Camera camera = Film();
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> noise(0, 0.01);
  double sum = 0, sigma0_sum = 0;
  constexpr int kRuns = 1000;
  for (int run = 0; run < kRuns; ++run) {
    auto photos = Exact(camera, 3);
    for (auto& photo : photos) photo.photo_mm += Eigen::Vector2d(noise(random), noise(random));
    const auto result = IntersectPhotos(photos);
    ASSERT_TRUE(result);
    const Eigen::Vector3d error = result->ground_m - kPoint;
    sum += error.dot(result->covariance_m2.ldlt().solve(error)) / 3;
    sigma0_sum += result->sigma0 * result->sigma0;
  }
  EXPECT_NEAR(std::sqrt(sum / kRuns), 1.0, 0.05);
  EXPECT_NEAR(std::sqrt(sigma0_sum / kRuns), 1.0, 0.05);
}

TEST(IntersectPhotos, OnePhotoAndTwoPhotosFromOnePlaceHaveNoPoint) {
  const Camera camera = Film();
  EXPECT_FALSE(IntersectPhotos(Exact(camera, 1)));
  auto twice = Exact(camera, 1);
  twice.push_back(twice[0]);
  EXPECT_FALSE(IntersectPhotos(twice));
  EXPECT_FALSE(IntersectPhotos({}));
}

}  // namespace
}  // namespace orient

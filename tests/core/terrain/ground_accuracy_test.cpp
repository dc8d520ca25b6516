#include "core/terrain/ground_accuracy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/hilly_view.h"

namespace orient {
namespace {

TEST(CircularError90, OfACircleAndOfALine) {
  EXPECT_NEAR(CircularError90(Eigen::Vector2d(4, 4).asDiagonal()), 2 * 2.14597, 1e-4);
  EXPECT_NEAR(CircularError90(Eigen::Vector2d(9, 0).asDiagonal()), 3 * 1.64485, 1e-2);
  EXPECT_EQ(CircularError90(Eigen::Matrix2d::Zero()), 0);
}

TEST(CircularError90, HoldsNineTenthsOfDrawnErrors) {
  Eigen::Matrix2d root;
  root << 2, 0.3, 1.1, 0.7;
  const double radius = CircularError90(root * root.transpose());
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  int inside = 0;
  constexpr int kDrawn = 40000;
  for (int i = 0; i < kDrawn; ++i)
    inside += (root * Eigen::Vector2d(normal(random), normal(random))).norm() < radius ? 1 : 0;
  EXPECT_NEAR(static_cast<double>(inside) / kDrawn, 0.9, 0.006);
}

// Poses drawn by the covariance move the place of a photo point on the ground by what is said.
TEST(AccuracyOf, IsWhatDrawnPosesShow) {
  const GroundSurface flat =
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(300, 300, 100), 3500, 4500, 10);
  const PhotoView view = ortho::HillyView();
  Vector6d sigma;
  sigma << 0.4, 0.4, 0.3, 2e-4, 2e-4, 1e-4;
  const Matrix6d covariance = sigma.cwiseAbs2().asDiagonal();
  const auto accuracy = AccuracyOf(view, covariance, flat, 0);
  ASSERT_TRUE(accuracy);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<double> off;
  const Eigen::Vector2d corner(5, 5);
  const Eigen::Vector3d truth = view.GroundFromPixel(corner, flat).value();
  for (int i = 0; i < 4000; ++i) {
    PhotoView drawn = view;
    Vector6d pose = view.pose.AsVector();
    for (int k = 0; k < 6; ++k) pose[k] += sigma[k] * normal(random);
    drawn.pose = Pose::FromVector(pose);
    off.push_back((drawn.GroundFromPixel(corner, flat).value() - truth).norm());
  }
  std::sort(off.begin(), off.end());
  const double drawn = off[off.size() * 9 / 10];
  EXPECT_LT(accuracy->median_m, accuracy->worst_m);
  EXPECT_GT(drawn, 0.7 * accuracy->median_m);
  EXPECT_LT(drawn, 1.05 * accuracy->worst_m) << "a corner is no better than the worst place";
}

TEST(AccuracyOf, HeightsMoveWhatLiesFarFromTheNadir) {
  const GroundSurface hills = ortho::Hills();
  PhotoView view = ortho::HillyView();
  view.pose.opk_rad.setZero();
  const auto none = AccuracyOf(view, Matrix6d::Zero(), hills, 0);
  const auto some = AccuracyOf(view, Matrix6d::Zero(), hills, 2);
  EXPECT_EQ(none->worst_m, 0);
  // In a corner the ray's tangent is 141 / 150.
  EXPECT_NEAR(some->worst_m, 2 * 1.645 * 141 / 150, 0.1);
}

TEST(AccuracyOf, NothingBesideTheSurface) {
  PhotoView view = ortho::HillyView();
  view.pose.position_m.x() += 1e5;
  EXPECT_FALSE(AccuracyOf(view, Matrix6d::Identity(), ortho::Hills(), 0));
}

}  // namespace
}  // namespace orient

#include "core/geometry/lens.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "tests/support/generators.h"

namespace orient {
namespace {

constexpr double kExact_mm = 1e-12;

BrownDistortion Film() { return {{3e-8, -1e-12, 5e-18}, {2e-7, -4e-7}}; }
BrownDistortion Strong() { return {{-8e-6, 3e-11, 0}, {1e-5, -2e-5}}; }
RadialTable Report() { return {{0, 20, 40, 80, 110, 148}, {0, 1.2, -0.8, -3.4, 2.2, 9.6}}; }

TEST(Lens, BrownAgreesWithNumbersByHand) {
  // At (3, 4): r^2 = 25.
  const LensDistortion radial = BrownDistortion{{1e-4, 1e-6, 1e-8}, {0, 0}};
  const double factor = 1e-4 * 25 + 1e-6 * 625 + 1e-8 * 15625;
  EXPECT_LT((DistortionAt(radial, {3, 4}) - factor * Eigen::Vector2d(3, 4)).norm(), kExact_mm);
  const LensDistortion decentring = BrownDistortion{{0, 0, 0}, {1e-3, 2e-3}};
  // dx = p1 (25 + 18) + 2 p2 12, dy = p2 (25 + 32) + 2 p1 12.
  EXPECT_LT(
      (DistortionAt(decentring, {3, 4}) - Eigen::Vector2d(0.043 + 0.048, 0.114 + 0.024)).norm(),
      kExact_mm);
}

TEST(Lens, TableIsLinearBetweenRadiiConstantBeyondAndPositiveOutwards) {
  const LensDistortion lens = Report();
  EXPECT_LT((DistortPoint(lens, {0, 30}) - Eigen::Vector2d(0, 30.0002)).norm(), kExact_mm);
  EXPECT_LT((DistortPoint(lens, {-148, 0}) - Eigen::Vector2d(-148.0096, 0)).norm(), kExact_mm);
  EXPECT_LT((DistortPoint(lens, {0, -200}) - Eigen::Vector2d(0, -200.0096)).norm(), kExact_mm);
  EXPECT_EQ(DistortionAt(lens, {0, 0}).norm(), 0);
}

TEST(Lens, NoDistortionChangesNothing) {
  const LensDistortion lens;
  EXPECT_EQ(DistortPoint(lens, {12, -7}), Eigen::Vector2d(12, -7));
  EXPECT_EQ(UndistortPoint(lens, {12, -7}), Eigen::Vector2d(12, -7));
}

TEST(Lens, UndistortingIsTheExactInverse) {
  EXPECT_TRUE(rc::check("distort -> undistort", [] {
    const LensDistortion lens =
        *rc::gen::element<LensDistortion>(Film(), Strong(), Report(), LensDistortion{});
    const Eigen::Vector2d ideal(*InRange(-110, 110), *InRange(-110, 110));
    const auto back = UndistortPoint(lens, DistortPoint(lens, ideal));
    RC_ASSERT(back.has_value());
    // The inverse is exact in the measured point; where the lens squeezes, in the ideal one the
    // rounding of 100 mm comes back larger.
    RC_ASSERT((DistortPoint(lens, *back) - DistortPoint(lens, ideal)).norm() <= kExact_mm);
    RC_ASSERT((*back - ideal).norm() < 10 * kExact_mm);
  }));
}

TEST(Lens, RadialTermsAreAddedToWhateverTheLensIs) {
  EXPECT_TRUE(rc::check("lens + polynomial", [] {
    const LensDistortion lens =
        *rc::gen::element<LensDistortion>(Film(), Strong(), Report(), LensDistortion{});
    const std::array<double, 3> k = {-1e-8 * *InRange(0, 5), 2e-13, -1e-18};
    const LensDistortion sum = WithRadial(lens, k, 160);
    const Eigen::Vector2d at(*InRange(-110, 110), *InRange(-110, 110));
    const double r2 = at.squaredNorm();
    const Eigen::Vector2d added = at * (r2 * (k[0] + r2 * (k[1] + r2 * k[2])));
    const double straight = std::holds_alternative<RadialTable>(lens) ? 1e-5 : kExact_mm;
    RC_ASSERT((DistortionAt(sum, at) - DistortionAt(lens, at) - added).norm() < straight);
  }));
}

TEST(Lens, JacobianAgreesWithDifferences) {
  constexpr double kStep = 1e-3;
  constexpr double kTolerance = 1e-8;  // third derivative * step^2
  for (const LensDistortion& lens : {LensDistortion(Film()), LensDistortion(Strong()),
                                     LensDistortion(Report()), LensDistortion()}) {
    for (const Eigen::Vector2d& place : {Eigen::Vector2d(31, -57), {-90, 44}, {0.01, 0.02}}) {
      const Eigen::Matrix2d jacobian = DistortionJacobian(lens, place);
      for (int i = 0; i < 2; ++i) {
        const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(i);
        const Eigen::Vector2d difference =
            (DistortionAt(lens, place + step) - DistortionAt(lens, place - step)) / (2 * kStep);
        EXPECT_LT((jacobian.col(i) - difference).norm(), kTolerance);
      }
    }
  }
}

TEST(Lens, JacobianInTheCentreOfATableIsItsFirstSlope) {
  EXPECT_LT((DistortionJacobian(Report(), {0, 0}) - 6e-5 * Eigen::Matrix2d::Identity()).norm(),
            kExact_mm);
}

TEST(Lens, FoldedModelHasNoInverseBeyondItsFold) {
  // r - 1e-5 r^3 folds at r = 182.57 where the measured radius is 121.7.
  const LensDistortion lens = BrownDistortion{{-1e-5, 0, 0}, {0, 0}};
  EXPECT_FALSE(UndistortPoint(lens, {122, 0}));
  EXPECT_FALSE(UndistortPoint(lens, {-300, 200}));
  const auto inside = UndistortPoint(lens, {0, -121.6});
  ASSERT_TRUE(inside);
  EXPECT_LT(inside->norm(), 182.57);
  EXPECT_NEAR(DistortPoint(lens, *inside).y(), -121.6, kExact_mm);
  EXPECT_TRUE(InsideFold(lens, {182.5, 0}));
  EXPECT_FALSE(InsideFold(lens, {182.7, 0}));
}

TEST(Lens, AModelThatUnfoldsAgainIsStillFolded) {
  // The slope 1 + 3 k1 r^2 + 5 k2 r^4 is negative from r = 154 to 237 and positive again at 300.
  const LensDistortion lens = BrownDistortion{{-2e-5, 1.5e-10, 0}, {0, 0}};
  EXPECT_GT(1 - 6e-5 * 9e4 + 7.5e-10 * 8.1e9, 0);
  EXPECT_FALSE(InsideFold(lens, {300, 0}));
  const auto ideal = UndistortPoint(lens, DistortPoint(lens, {300, 0}));
  EXPECT_TRUE(!ideal || ideal->norm() < 154);
}

TEST(Lens, FoldedTableHasNoInverse) {
  const LensDistortion lens = RadialTable{{0, 100, 101}, {0, 0, -2000}};
  EXPECT_TRUE(UndistortPoint(lens, {99.5, 0}));
  EXPECT_FALSE(UndistortPoint(lens, {100.5, 0}));
  EXPECT_FALSE(InsideFold(lens, {100.5, 0}));
}

TEST(Lens, ATableWithoutOneDrForEachRadiusIsABrokenPromise) {
  EXPECT_THROW(DistortPoint(RadialTable{{0, 10}, {0}}, {1, 1}), std::invalid_argument);
  EXPECT_THROW(UndistortPoint(RadialTable{}, {1, 1}), std::invalid_argument);
}

}  // namespace
}  // namespace orient

#include "block/verdict/approximations_apart.h"

#include <gtest/gtest.h>

#include <random>

namespace orient::block {
namespace {

constexpr double kSigma_m = 10;

// Poses of photos, and approximations that err by their sigma and lie apart from them.
struct Photos {
  Photos(int count, const Eigen::Vector3d& apart_m, unsigned seed = 1, double sigma_m = kSigma_m) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, sigma_m);
    for (int i = 0; i < count; ++i) {
      ExteriorResult result;
      result.photo = std::to_string(i);
      result.status = Status::kOk;
      Pose pose;
      pose.position_m = {5e5 + 1000.0 * i, 5e6, 3000};
      result.pose = pose;
      result.covariance = 0.01 * Matrix6d::Identity();
      results.push_back(result);
      for (double& coordinate : pose.position_m) coordinate += normal(random);
      pose.position_m -= apart_m;
      Vector6d sigma;
      sigma << sigma_m, sigma_m, sigma_m, 0.05, 0.05, 0.05;
      stated[result.photo] = {pose, sigma.cwiseAbs2().asDiagonal()};
    }
  }
  std::optional<Finding> Apart() const { return ApproximationsApart(results, stated); }

  std::vector<ExteriorResult> results;
  PosePriors stated;
};

TEST(ApproximationsApart, AHeightDatumIsNamedThoughNoPhotoAloneContradictsItsOwn) {
  const auto finding = Photos(6, {0, 0, 45}).Apart();
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->reason, Reason::kApproximationsWorseThanStated);
  EXPECT_NEAR(*finding->value, 4.5, 1.2);
  EXPECT_NE(finding->where.find("of 6 photos"), std::string::npos) << finding->where;
}

TEST(ApproximationsApart, OfRightOnesNothingIsSaid) {
  for (unsigned seed = 0; seed < 1000; ++seed)
    EXPECT_FALSE(Photos(3 + static_cast<int>(seed % 50), {0, 0, 0}, seed).Apart());
}

TEST(ApproximationsApart, OfManyPhotosASmallShiftIsWithinTheirAccuracy) {
  EXPECT_FALSE(Photos(400, {0, 12, 0}).Apart());
  EXPECT_TRUE(Photos(400, {0, 20, 0}).Apart());
}

// Control that is worse than the approximations, and says so.
TEST(ApproximationsApart, WhatThePosesHaveInCommonMayMoveThemTogether) {
  Photos photos(6, {0, 0, 1.5}, 1, 0.1);
  EXPECT_TRUE(photos.Apart());
  for (ExteriorResult& result : photos.results) (*result.covariance)(2, 2) = 1;
  EXPECT_FALSE(photos.Apart());
}

TEST(ApproximationsApart, WhereTheyScatterAsMuchNothingIsSaidOfAShift) {
  Photos photos(6, {0, 0, 45});
  for (std::size_t i = 0; i < photos.results.size(); i += 2)
    photos.results[i].pose->position_m.z() -= 90;
  EXPECT_FALSE(photos.Apart());
}

TEST(ApproximationsApart, TwoPhotosOrNoneSayNothing) {
  EXPECT_FALSE(Photos(0, {0, 0, 0}).Apart());
  EXPECT_FALSE(Photos(2, {0, 0, 450}).Apart());
  Photos photos(6, {0, 0, 45});
  for (std::size_t i = 2; i < photos.results.size(); ++i) photos.results[i].pose.reset();
  EXPECT_FALSE(photos.Apart());
}

TEST(ApproximationsApart, AccuracyThatNobodyStatesSaysNothing) {
  Photos photos(6, {0, 0, 45});
  while (photos.stated.size() > 2) photos.stated.erase(photos.stated.begin());
  EXPECT_FALSE(photos.Apart());
}

TEST(ApproximationsApart, PhotosOfStatedAccuracyAreWeak) {
  Photos photos(6, {0, 0, 45});
  photos.stated.erase("0");
  photos.results[1].pose.reset();
  photos.results[2].status = Status::kWeak;
  const auto finding = photos.Apart();
  ASSERT_TRUE(finding);
  AddToPhotos(*finding, photos.stated, &photos.results);
  EXPECT_EQ(photos.results[0].status, Status::kOk);
  EXPECT_TRUE(photos.results[1].findings.empty());
  for (std::size_t i = 2; i < photos.results.size(); ++i) {
    EXPECT_EQ(photos.results[i].status, Status::kWeak);
    ASSERT_EQ(photos.results[i].findings.size(), 1u);
    EXPECT_EQ(photos.results[i].findings[0].where, finding->where);
  }
}

}  // namespace
}  // namespace orient::block

#include "core/matching/keypoints.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/base/median.h"
#include "core/geometry/rotation.h"

namespace orient {
namespace {

// Blobs of all sizes, drawn where `place` puts them.
template <typename Place>
Image Blobs(int size, Place place, double scale = 1) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> at(0, 200), radius(1.5, 6), grey(-60, 60);
  Image image(size, size, 120);
  for (int i = 0; i < 250; ++i) {
    const Eigen::Vector2d middle = place(Eigen::Vector2d(at(random), at(random)));
    const double r = scale * radius(random);
    const double g = grey(random);
    const int reach = static_cast<int>(4 * r);
    const int col0 = static_cast<int>(middle.x()), row0 = static_cast<int>(middle.y());
    for (int row = std::max(0, row0 - reach); row < std::min(size, row0 + reach); ++row)
      for (int col = std::max(0, col0 - reach); col < std::min(size, col0 + reach); ++col) {
        const double d2 = (Eigen::Vector2d(col + 0.5, row + 0.5) - middle).squaredNorm();
        image.At(col, row) += static_cast<float>(g * std::exp(-d2 / (2 * r * r)));
      }
  }
  return image;
}

TEST(Keypoints, OfATurnedAndScaledImageAreTheSamePlaces) {
  const auto turned = [](const Eigen::Vector2d& p) {
    const Eigen::Vector2d d = 1.3 * (p - Eigen::Vector2d(100, 100));
    return Eigen::Vector2d(150 + d.x() * std::cos(2.0) - d.y() * std::sin(2.0),
                           150 + d.x() * std::sin(2.0) + d.y() * std::cos(2.0));
  };
  const Keypoints a = FindKeypoints(Blobs(200, [](const auto& p) { return p; }), 1000);
  const Keypoints b = FindKeypoints(Blobs(300, turned, 1.3), 1000);
  const auto matches = MatchKeypoints(a, b);
  ASSERT_GT(matches.size(), 20u);
  std::size_t right = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const KeypointMatch& match : matches) {
    const Eigen::Vector2d off = b.pixels[match.second] - turned(a.pixels[match.first]);
    if (off.norm() > 1.5) continue;
    ++right;
    mean += off;
  }
  EXPECT_GT(right, matches.size() * 9 / 10);
  EXPECT_LT((mean / static_cast<double>(right)).norm(), 0.25);  // no half pixel is lost
}

TEST(Keypoints, SayHowTheImageIsTurnedAndScaled) {
  const auto turned = [](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return Eigen::Vector2d(150, 150) +
           Eigen::Rotation2Dd(2.0) * (1.3 * (p - Eigen::Vector2d(100, 100)));
  };
  const Keypoints a = FindKeypoints(Blobs(200, [](const auto& p) { return p; }), 1000);
  const Keypoints b = FindKeypoints(Blobs(300, turned, 1.3), 1000);
  std::vector<double> turns, scales;
  for (const KeypointMatch& match : MatchKeypoints(a, b)) {
    turns.push_back(NormalizeAngle(b.angles_rad[match.second] - a.angles_rad[match.first] - 2.0));
    scales.push_back(b.sizes_px[match.second] / a.sizes_px[match.first]);
  }
  ASSERT_GT(turns.size(), 20u);
  EXPECT_NEAR(UpperMedian(turns), 0, 0.05);  // from columns towards rows
  EXPECT_NEAR(UpperMedian(scales), 1.3, 0.05);
}

Comparable AllOf(const Keypoints& keypoints) {
  std::vector<std::size_t> all(keypoints.Size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return [all](std::size_t) { return all; };
}

TEST(Keypoints, TheNearestOnesComeInOrderAndFromOneKeypointTogether) {
  const Keypoints a = FindKeypoints(Blobs(200, [](const auto& p) { return p; }), 1000);
  const auto matches = CompareKeypoints(a, a, AllOf(a), 0.8, 3).nearest;
  ASSERT_EQ(matches.size(), 3 * a.Size());
  for (std::size_t i = 0; i < matches.size(); ++i) EXPECT_EQ(matches[i].first, i / 3);
  for (std::size_t i = 0; i < a.Size(); ++i)  // itself, or one with the same descriptor
    EXPECT_EQ(a.descriptors.row(static_cast<Eigen::Index>(matches[3 * i].second)),
              a.descriptors.row(static_cast<Eigen::Index>(i)));
  EXPECT_TRUE(CompareKeypoints(Keypoints{}, a, AllOf(a), 0.8, 3).nearest.empty());
}

TEST(Keypoints, OnlyThoseThatMayBeAreCompared) {
  const Keypoints a = FindKeypoints(Blobs(200, [](const auto& p) { return p; }), 1000);
  const auto next = [&](std::size_t i) { return std::vector<std::size_t>{(i + 1) % a.Size()}; };
  const AlikeKeypoints alike = CompareKeypoints(a, a, next, 0.8, 3);
  ASSERT_EQ(alike.nearest.size(), a.Size());
  for (const KeypointMatch& match : alike.nearest)
    EXPECT_EQ(match.second, (match.first + 1) % a.Size());
  const AlikeKeypoints all = CompareKeypoints(a, a, AllOf(a), 0.8, 1);
  EXPECT_EQ(all.distinct.size(), MatchKeypoints(a, a).size());
}

TEST(Keypoints, AppendedAreThoseOfBoth) {
  const Keypoints a = FindKeypoints(Blobs(200, [](const auto& p) { return p; }), 1000);
  Keypoints both = a.Of({0, 1});
  both.Append(a.Of({5}));
  ASSERT_EQ(both.Size(), 3u);
  EXPECT_EQ(both.pixels[2], a.pixels[5]);
  EXPECT_EQ(both.sizes_px[2], a.sizes_px[5]);
  EXPECT_EQ(both.angles_rad[2], a.angles_rad[5]);
  EXPECT_EQ(both.descriptors.row(2), a.descriptors.row(5));
}

TEST(Keypoints, AreNoneWhereThereIsNoContrastAndNoneBesideNoData) {
  EXPECT_EQ(FindKeypoints(Image(100, 100, 7), 100).Size(), 0u);
  EXPECT_EQ(FindKeypoints(Image(100, 100, kNoData), 100).Size(), 0u);
  EXPECT_EQ(FindKeypoints(Image(5, 5, 1), 100).Size(), 0u);
  Image image = Blobs(200, [](const auto& p) { return p; });
  for (int row = 0; row < 200; ++row)
    for (int col = 0; col < 80; ++col) image.At(col, row) = kNoData;
  const Keypoints found = FindKeypoints(image, 1000);
  ASSERT_GT(found.Size(), 10u);
  for (const Eigen::Vector2d& pixel : found.pixels) EXPECT_GE(pixel.x(), 87);
}

TEST(Keypoints, WhatRepeatsItselfMatchesNothing) {
  const auto pattern = [](int size) {
    Image image(size, size);
    for (int row = 0; row < size; ++row)
      for (int col = 0; col < size; ++col)
        image.At(col, row) =
            static_cast<float>(100 + 50 * std::sin(col * 0.4) * std::sin(row * 0.4));
    return image;
  };
  const Keypoints a = FindKeypoints(pattern(200), 1000), b = FindKeypoints(pattern(220), 1000);
  ASSERT_GT(a.Size(), 50u);
  EXPECT_LT(MatchKeypoints(a, b).size(), a.Size() / 20);
}

TEST(Keypoints, OfNothingMatchNothing) {
  const Keypoints some = FindKeypoints(Blobs(200, [](const auto& p) { return p; }), 100);
  const Keypoints none = FindKeypoints(Image(100, 100, 7), 100);
  EXPECT_TRUE(MatchKeypoints(some, none).empty());
  EXPECT_TRUE(MatchKeypoints(none, some).empty());
}

}  // namespace
}  // namespace orient

#include "core/matching/keypoints.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

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

// How the photos of a roll lie, from what single photos leave open.
#include "block/roll/roll_orientation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "interior/interior.h"
#include "tests/support/film_frame.h"

namespace orient::block {
namespace {

using Orientations = std::vector<ScanOrientation>;

const Orientations kAll(kAllScanOrientations.begin(), kAllScanOrientations.end());

class RollOrientation : public testing::Test {
 protected:
  // A photo with four equal marks that lies r0, its marks named as if it lay in the first of
  // `possible`.
  InteriorResult Photo(const Orientations& possible, const std::vector<double>& nats = {}) const {
    InteriorResult photo;
    photo.status = Status::kOk;
    photo.photo_from_pixel = Affine2d{Eigen::Vector2d(0.1, -0.1).asDiagonal(), {-35, 35}};
    photo.possible_orientations = kAll;
    for (const Fiducial& f : camera_.fiducials)
      photo.marks.push_back({f.id, MarkState::kUsed,
                             photo.photo_from_pixel->Inverse() * f.position_mm,
                             Eigen::Vector2d(0.02, 0.02), std::nullopt, 0.9});
    InteriorResult named = InOrientation(photo, camera_, shapes_, possible.front()).value();
    named.possible_orientations = possible;
    named.orientation_nats = nats;
    if (possible.size() > 1) {
      named.orientation.reset();
      named.findings.push_back({.reason = Reason::kOrientationOpen, .where = "r0, r90"});
    }
    return named;
  }

  std::vector<size_t> Vote(std::vector<InteriorResult>* roll, bool alike = true) const {
    return OrientAsRoll(camera_, shapes_, alike, roll);
  }

  CameraFile camera_ = RingCamera(30, 70);
  interior::MarkShapes shapes_ = interior::ShapesOf(camera_);
};

TEST_F(RollOrientation, PhotosThatTellItDecideForThoseThatDoNot) {
  const InteriorResult open = Photo({ScanOrientation::kM270, ScanOrientation::kR0});
  std::vector<InteriorResult> roll(4, Photo({ScanOrientation::kR0}));
  roll.insert(roll.begin() + 1, open);
  EXPECT_EQ(Vote(&roll), std::vector<size_t>{1});
  EXPECT_EQ(roll[1].orientation, ScanOrientation::kR0);
  EXPECT_EQ(roll[1].possible_orientations, Orientations{ScanOrientation::kR0});
  EXPECT_EQ(roll[1].orientations_alone, open.possible_orientations);
  EXPECT_TRUE(roll[1].photo_from_pixel->A.isApprox(roll[0].photo_from_pixel->A, 1e-9));
  EXPECT_EQ(roll[1].marks[2].pixel, roll[0].marks[2].pixel);
  EXPECT_TRUE(Has(roll[1].findings, Reason::kOrientationOfRoll));
  EXPECT_FALSE(Has(roll[1].findings, Reason::kOrientationOpen));
}

TEST_F(RollOrientation, UnsureVotesAddUp) {
  const Orientations two = {ScanOrientation::kR180, ScanOrientation::kR0};
  std::vector<InteriorResult> roll(4, Photo(two, {0, -2}));
  EXPECT_EQ(OrientationOfRoll(roll), ScanOrientation::kR180);  // 8 nats
  roll.resize(2);
  EXPECT_FALSE(OrientationOfRoll(roll));
}

TEST_F(RollOrientation, PositionsOfMarksAreTheSameEvidenceInEveryPhoto) {
  const Orientations two = {ScanOrientation::kM0, ScanOrientation::kR90};
  InteriorResult photo = Photo(two, {0, -1});
  std::vector<InteriorResult> roll(18, photo);
  EXPECT_EQ(OrientationOfRoll(roll), ScanOrientation::kM0);  // by signs: independent
  photo.orientation_evidence = {
      {kByMarkPositions, {{ScanOrientation::kM0, 0}, {ScanOrientation::kR90, -1}}}};
  roll.assign(18, photo);
  EXPECT_FALSE(OrientationOfRoll(roll));
}

TEST_F(RollOrientation, PhotosThatTellNothingAddNothingToOneThatDoes) {
  std::vector<InteriorResult> roll(5, Photo(kAll));
  roll.front() = Photo({ScanOrientation::kM90});
  EXPECT_FALSE(OrientationOfRoll(roll));
  roll[1] = roll[2] = roll.front();
  EXPECT_EQ(OrientationOfRoll(roll), ScanOrientation::kM90);
}

// A run compares the photos with the roll after they have voted: resumed, it must decide the same.
TEST_F(RollOrientation, WhatTheComparisonWithTheRollMadeWeakVotesAsBefore) {
  std::vector<InteriorResult> roll(3, Photo({ScanOrientation::kR90}));
  roll.push_back(Photo(kAll));
  ASSERT_EQ(OrientationOfRoll(roll), ScanOrientation::kR90);
  roll[1].status_alone = roll[1].status;
  roll[1].status = Status::kWeak;
  EXPECT_EQ(OrientationOfRoll(roll), ScanOrientation::kR90);
}

TEST_F(RollOrientation, WithoutAnyVoteAllAreNamedAlikeUnmirroredAndStayOpen) {
  Orientations other = kAll, third = kAll;
  std::rotate(other.begin(), other.begin() + 7, other.end());  // m270 first
  std::rotate(third.begin(), third.begin() + 1, third.end());  // r90
  std::vector<InteriorResult> roll = {Photo(other), Photo(third), Photo(other)};
  EXPECT_EQ(Vote(&roll).size(), 3u);
  for (const InteriorResult& photo : roll) {
    EXPECT_FALSE(photo.orientation);
    EXPECT_EQ(photo.possible_orientations.size(), kAll.size());
    EXPECT_EQ(photo.possible_orientations.front(), ScanOrientation::kR0);
    EXPECT_GT(photo.photo_from_pixel->A(0, 0), 0);
    EXPECT_LT(photo.photo_from_pixel->A(1, 1), 0);
  }
}

TEST_F(RollOrientation, PhotosThatLieDifferentlyDecideNothing) {
  std::vector<InteriorResult> roll(3, Photo({ScanOrientation::kR0}));
  roll.push_back(Photo({ScanOrientation::kR180}));
  roll.push_back(Photo(kAll));
  EXPECT_FALSE(OrientationOfRoll(roll));
  Vote(&roll);
  EXPECT_EQ(roll.back().possible_orientations.size(), kAll.size());
}

TEST_F(RollOrientation, APhotoThatExcludesTheRollsKeepsItsOwn) {
  std::vector<InteriorResult> roll(12, Photo({ScanOrientation::kR0}));
  roll.push_back(Photo({ScanOrientation::kR90, ScanOrientation::kM0}));
  EXPECT_TRUE(Vote(&roll).empty());
  EXPECT_EQ(roll.back().possible_orientations.front(), ScanOrientation::kR90);
}

TEST_F(RollOrientation, FailedAndWeakPhotosHaveNoVote) {
  InteriorResult weak = Photo({ScanOrientation::kR180}), failed;
  weak.status = Status::kWeak;
  std::vector<InteriorResult> roll(3, Photo({ScanOrientation::kR0}));
  roll.insert(roll.end(), 3, weak);
  roll.insert(roll.end(), 3, failed);
  EXPECT_EQ(OrientationOfRoll(roll), ScanOrientation::kR0);
}

TEST_F(RollOrientation, WhatTheRollSaidIsTakenBack) {
  const InteriorResult open = Photo({ScanOrientation::kM270, ScanOrientation::kR0}, {0, -1});
  std::vector<InteriorResult> roll(4, Photo({ScanOrientation::kR0}));
  roll.push_back(open);
  Vote(&roll);
  ASSERT_TRUE(roll.back().orientation);
  EXPECT_EQ(Vote(&roll), std::vector<size_t>());  // again the same
  EXPECT_EQ(Vote(&roll, false), std::vector<size_t>{4});
  EXPECT_FALSE(roll.back().orientation);
  EXPECT_EQ(roll.back().possible_orientations, open.possible_orientations);
  EXPECT_EQ(roll.back().orientation_nats, open.orientation_nats);
  EXPECT_TRUE(roll.back().orientations_alone.empty());
  EXPECT_TRUE(roll.back().photo_from_pixel->A.isApprox(open.photo_from_pixel->A, 1e-9));
  EXPECT_TRUE(Has(roll.back().findings, Reason::kOrientationOpen));
}

}  // namespace
}  // namespace orient::block

// Sources that contradict a pose as a whole, and those of which single patches do.
#include "exterior/contradicted_sources.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "exterior/judge.h"

namespace orient::exterior {
namespace {

struct Patches {
  std::vector<PatchResult> results;

  // In rows of twenty: what is added together lies together.
  void Add(std::int64_t source, PatchState state, const Eigen::Vector2d& residual_px) {
    constexpr int kInRow = 20;
    const int place = static_cast<int>(results.size()), row = place / kInRow;
    PatchResult result;
    result.id = place + 1;
    result.pixel = Eigen::Vector2d(50.0 * (place % kInRow), 50.0 * row);
    result.source = source;
    result.state = state;
    if (state != PatchState::kNotFound) result.residual_px = residual_px;
    results.push_back(std::move(result));
  }
  // `used` ones around the pose, `displaced` ones around the shift.
  void AddSource(std::int64_t source, int used, int displaced, const Eigen::Vector2d& shift_px) {
    for (int i = 0; i < used; ++i) Add(source, PatchState::kMatched, Noise());
    for (int i = 0; i < displaced; ++i) Add(source, PatchState::kRejected, shift_px + Noise());
  }
  // Rejected ones, no two of which lie alike but by chance.
  void AddAnyhow(std::int64_t source, int count, double reach_px) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> anywhere(-reach_px, reach_px);
    for (int i = 0; i < count; ++i)
      Add(source, PatchState::kRejected, {anywhere(random), anywhere(random)});
  }
  SourceVotes Votes(int reduction = 1) const { return VotesOf(results, reduction); }
  Findings Judged() const {
    JudgedPose pose;
    pose.places = 100;
    pose.spread = 0.5;
    pose.worst_sigma_px = 0.2;
    pose.sources = Votes();
    return Judge(pose);
  }

 private:
  Eigen::Vector2d Noise() { return 0.2 * Eigen::Vector2d(normal_(random_), normal_(random_)); }
  std::mt19937 random_{3};
  std::normal_distribution<double> normal_;
};

TEST(VotesOf, AnotherSourceThatIsDisplacedAsAWholeLeavesOpenWhichIsWrong) {
  Patches patches;
  patches.AddSource(1, 300, 10, {2, 2});
  patches.AddSource(2, 0, 140, {-3, 2});
  const SourceVotes votes = patches.Votes();
  ASSERT_EQ(votes.contradicted.size(), 1u);
  EXPECT_EQ(votes.contradicted.front().source, 2);
  EXPECT_EQ(votes.contradicted.front().found, 140);
  EXPECT_NEAR(votes.contradicted.front().shift_px.x(), -3, 0.1);
  EXPECT_NEAR(votes.contradicted.front().shift_px.y(), 2, 0.1);
  EXPECT_TRUE(IsUndecided(votes));
  const Findings findings = patches.Judged();
  ASSERT_TRUE(Has(findings, Reason::kSourceContradicted));
  EXPECT_EQ(StatusOf(findings), Status::kWeak);
}

TEST(VotesOf, TwoSourcesOutvoteOne) {
  Patches patches;
  patches.AddSource(1, 200, 0, {0, 0});
  patches.AddSource(2, 150, 0, {0, 0});
  patches.AddSource(3, 0, 140, {-3, 2});
  EXPECT_EQ(patches.Votes().agreeing_sources, 2);
  EXPECT_FALSE(IsUndecided(patches.Votes()));
  EXPECT_TRUE(Has(patches.Judged(), Reason::kSourceContradicted));
  EXPECT_EQ(StatusOf(patches.Judged()), Status::kOk);
}

TEST(VotesOf, AFewPatchesOfAnotherSourceAreNoRivalOfHundreds) {
  Patches patches;
  patches.AddSource(1, 300, 0, {0, 0});
  patches.AddSource(2, 0, 30, {-3, 2});
  EXPECT_FALSE(IsUndecided(patches.Votes()));
  EXPECT_EQ(StatusOf(patches.Judged()), Status::kOk);
}

TEST(VotesOf, WrongMatchesThatLieAnyhowAreNoContradiction) {
  Patches patches;
  patches.AddSource(1, 300, 0, {0, 0});
  patches.AddAnyhow(2, 100, 5);
  EXPECT_TRUE(patches.Votes().contradicted.empty());
  EXPECT_EQ(StatusOf(patches.Judged()), Status::kOk);
}

TEST(VotesOf, ElevenPatchesHaveNoSayAndThoseNotFoundNeither) {
  Patches patches;
  patches.AddSource(1, 40, 0, {0, 0});
  patches.AddSource(2, 0, 11, {-3, 2});
  for (int i = 0; i < 50; ++i) patches.Add(2, PatchState::kNotFound, {0, 0});
  EXPECT_TRUE(patches.Votes().contradicted.empty());
  EXPECT_EQ(patches.Votes().agreeing_sources, 1);
  EXPECT_TRUE(Patches().Votes().contradicted.empty());
  EXPECT_FALSE(IsUndecided(Patches().Votes()));
}

// A mosaic of two flights, of which one is displaced: its majority is as likely to be wrong.
TEST(VotesOf, APartOfTheOnlySourceThatIsDisplacedLeavesOpenWhichIsWrong) {
  Patches patches;
  patches.AddSource(1, 343, 156, {7.8, 1.6});
  patches.AddAnyhow(1, 60, 10);
  const SourceVotes votes = patches.Votes();
  EXPECT_TRUE(votes.contradicted.empty());
  EXPECT_GE(votes.elsewhere.patches, 156);
  EXPECT_LT((votes.elsewhere.shift_px - Eigen::Vector2d(7.8, 1.6)).norm(), 0.8);
  ASSERT_TRUE(Has(patches.Judged(), Reason::kPatchesAgreeElsewhere));
  EXPECT_EQ(StatusOf(patches.Judged()), Status::kWeak);
}

TEST(VotesOf, AFewPatchesOfTheSameSourceElsewhereAreARemark) {
  Patches patches;
  patches.AddSource(1, 343, 30, {7.8, 1.6});
  ASSERT_TRUE(Has(patches.Judged(), Reason::kPatchesAgreeElsewhere));
  EXPECT_EQ(StatusOf(patches.Judged()), Status::kOk);
}

TEST(VotesOf, TwoDisplacedPartsDoNotHideOneAnother) {
  for (const Eigen::Vector2d& other : {Eigen::Vector2d(-8, 0), Eigen::Vector2d(0, 8)}) {
    Patches patches;
    patches.AddSource(1, 343, 80, {8, 0});
    patches.AddSource(1, 0, 80, other);
    EXPECT_GE(patches.Votes().elsewhere.patches, 80);
    EXPECT_EQ(StatusOf(patches.Judged()), Status::kWeak);
  }
}

TEST(VotesOf, RejectedOnesNearThePoseAreATrendAndNoOtherPlace) {
  Patches patches;
  patches.AddSource(1, 343, 70, {1.1, 0});
  EXPECT_EQ(patches.Votes().elsewhere.patches, 0);
  patches.AddSource(1, 0, 50, {8, 0});
  EXPECT_EQ(patches.Votes().elsewhere.patches, 50);
}

TEST(VotesOf, AShiftIsJudgedInPixelsOfTheReduction) {
  Patches patches;
  patches.AddSource(1, 343, 70, {4.4, 0});
  EXPECT_GE(patches.Votes(1).elsewhere.patches, 70);
  EXPECT_EQ(patches.Votes(4).elsewhere.patches, 0);
  const PatchesElsewhere at_half = patches.Votes(2).elsewhere;
  EXPECT_GE(at_half.patches, 70);
  EXPECT_NEAR(at_half.shift_px.x(), 4.4, 0.2);  // told in pixels of the scan
}

// As the walls and shadows of houses on one side: among patches that agree with the pose.
TEST(VotesOf, WhatStandsOnTheGroundIsNoDisplacedPart) {
  Patches patches;
  for (int i = 0; i < 50; ++i) patches.AddSource(1, 6, 1, {1.8, 0.2});
  EXPECT_EQ(patches.Votes().elsewhere.patches, 0);
  EXPECT_EQ(StatusOf(patches.Judged()), Status::kOk);
}

// As trees and houses in a DEM without them: away from the nadir, all around it.
TEST(VotesOf, ReliefThatTheDemLacksIsNoDisplacedPart) {
  Patches patches;
  patches.AddSource(1, 200, 0, {0, 0});
  for (int i = 0; i < 120; ++i) {
    const double angle = 0.7 * i, length = 1 + 0.05 * (i % 60);
    patches.Add(1, PatchState::kRejected,
                length * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  EXPECT_EQ(patches.Votes().elsewhere.patches, 0);
  EXPECT_EQ(StatusOf(patches.Judged()), Status::kOk);
}

// What a block leaves of a photo's matches may tell more than the photo alone.
TEST(RejudgeSources, FollowsThePatchesThatAreUsedNow) {
  Patches patches;
  patches.AddSource(1, 200, 100, {4, 0});
  ExteriorResult result;
  result.status = Status::kOk;
  result.patches = patches.results;
  RejudgeSources(&result);
  EXPECT_EQ(result.status, Status::kWeak);
  for (PatchResult& patch : result.patches) patch.state = PatchState::kMatched;
  RejudgeSources(&result);
  EXPECT_EQ(result.status, Status::kOk);
  EXPECT_TRUE(result.findings.empty());
}

}  // namespace
}  // namespace orient::exterior

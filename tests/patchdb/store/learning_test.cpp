#include "patchdb/store/learning.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

AttemptOutcome Outcome(const std::string& state, const std::string& photo_status = "ok",
                       int epoch = 1) {
  AttemptOutcome outcome;
  outcome.state = state;
  outcome.photo_status = photo_status;
  outcome.epoch = epoch;
  outcome.neighbours_sought = 8;
  outcome.neighbours_matched = 7;
  return outcome;
}

TEST(Learning, BeforeAnyAttemptTheBeliefIsTheQualityAndUnsure) {
  EXPECT_EQ(BeliefOf(0.75, {}).Mean(), 0.75);
  EXPECT_EQ(BeliefOf(std::nullopt, {}).Mean(), 0.5);
  EXPECT_GT(BeliefOf(std::nullopt, {}).Sigma(), 0.25);
  EXPECT_GT(BeliefOf(0.0, {}).Mean(), 0.0);
  EXPECT_LT(BeliefOf(1.0, {}).Mean(), 1.0);
}

TEST(Learning, NumbersFromADamagedFileGiveABelief) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const SuccessBelief belief = BeliefOf(nan, {-5, nan});
  EXPECT_EQ(belief.Mean(), 0.5);
}

// The stated sigma is what the truth scatters by: patches whose probability is drawn from the
// prior, each tried a few times.
TEST(Learning, BeliefIsHonestAboutFewAttempts) {
  std::mt19937 random(TestSeed());
  std::uniform_real_distribution<double> unit(0, 1);
  for (const int attempts : {1, 3, 10}) {
    double squares = 0;
    constexpr int kPatches = 20000;
    for (int i = 0; i < kPatches; ++i) {
      const double truth = unit(random);  // Beta(1, 1): quality unknown
      std::vector<AttemptOutcome> outcomes;
      for (int j = 0; j < attempts; ++j)
        outcomes.push_back(Outcome(unit(random) < truth ? "matched" : "not_found"));
      const SuccessBelief belief = BeliefOf(std::nullopt, WeighAttempts(outcomes, 1));
      squares += std::pow((belief.Mean() - truth) / belief.Sigma(), 2);
    }
    EXPECT_NEAR(std::sqrt(squares / kPatches), 1, 0.05) << attempts;
  }
}

TEST(Learning, FailedPhotosSayNothingAndWeakOnesHalf) {
  EXPECT_EQ(WeighAttempts({Outcome("not_found", "failed")}, 1).failure, 0);
  EXPECT_EQ(WeighAttempts({Outcome("rejected", "weak")}, 1).failure, 0.5);
  EXPECT_EQ(WeighAttempts({Outcome("not_found")}, 1).failure, 1);
  EXPECT_EQ(WeighAttempts({Outcome("matched")}, 1).success, 1);
  EXPECT_EQ(WeighAttempts({Outcome("not_visible")}, 1).failure, 0);
}

TEST(Learning, OldEpochsAndOldPhotosCountLess) {
  EXPECT_EQ(WeighAttempts({Outcome("not_found", "ok", 1)}, 3).failure, 1.0 / 16);
  AttemptOutcome old = Outcome("not_found"), recent = Outcome("matched");
  old.photo_date = "1981-05-01";
  recent.photo_date = "2001";
  const SuccessWeights weights = WeighAttempts({old, recent}, 1);
  EXPECT_EQ(weights.failure, 0.5);
  EXPECT_EQ(weights.success, 1);
}

TEST(Learning, ThreeFailuresWhereNeighboursSucceedRetire) {
  std::vector<AttemptOutcome> failures(2, Outcome("not_found"));
  EXPECT_FALSE(WhyRetire(failures, 1));
  failures.push_back(Outcome("rejected"));
  const auto reason = WhyRetire(failures, 1);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("3 photos"), std::string::npos) << *reason;
}

TEST(Learning, NothingElseRetires) {
  const auto three = [](const AttemptOutcome& outcome) {
    return std::vector<AttemptOutcome>(3, outcome);
  };
  EXPECT_FALSE(WhyRetire(three(Outcome("not_found", "failed")), 1)) << "the photo failed";
  EXPECT_FALSE(WhyRetire(three(Outcome("not_visible")), 1)) << "never sought";
  EXPECT_FALSE(WhyRetire(three(Outcome("not_found", "ok", 1)), 2)) << "another epoch";
  AttemptOutcome cloudy = Outcome("not_found");
  cloudy.neighbours_matched = 4;
  EXPECT_FALSE(WhyRetire(three(cloudy), 1)) << "its neighbours fare no better";
  AttemptOutcome lonely = Outcome("not_found");
  lonely.neighbours_sought = lonely.neighbours_matched = 2;
  EXPECT_FALSE(WhyRetire(three(lonely), 1)) << "hardly any neighbours";
  auto mixed = three(Outcome("not_found"));
  mixed.push_back(Outcome("matched"));
  mixed.push_back(Outcome("matched"));
  EXPECT_FALSE(WhyRetire(mixed, 1)) << "it matched often enough";
}

}  // namespace
}  // namespace orient::patchdb

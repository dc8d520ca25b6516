#include "exterior/judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace orient::exterior {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double JustBelow(double value) { return std::nextafter(value, -kInfinity); }
double JustAbove(double value) { return std::nextafter(value, kInfinity); }

// Against which nothing speaks.
JudgedMatches GoodMatches() {
  return {.sought = 100, .matched = 80, .agreeing = 80, .places = 60, .log10_false_alarms = -50};
}
JudgedPose GoodPose() {
  JudgedPose pose;
  pose.places = 60;
  pose.spread = 0.5;
  pose.worst_sigma_px = 0.2;
  pose.prior_counts = true;
  return pose;
}

// `findings` are this one alone.
void ExpectOnly(const Findings& findings, const Finding& expected) {
  ASSERT_EQ(findings.size(), 1u) << JoinedSentences(findings);
  EXPECT_EQ(findings[0], expected) << Code(findings[0].reason) << " " << Sentence(findings[0]);
}

class ExteriorJudge : public testing::Test {
 protected:
  std::optional<Finding> WhyNot() const { return WhyNotAccepted(matches_, options_); }
  Findings Judged() const { return Judge(pose_); }

  JudgedMatches matches_ = GoodMatches();
  JudgedPose pose_ = GoodPose();
  OrientPhotoOptions options_;
};

TEST_F(ExteriorJudge, APoseAgainstWhichNothingSpeaksIsAcceptedWithoutFindings) {
  EXPECT_EQ(WhyNot(), std::nullopt);
  EXPECT_TRUE(Judged().empty());
}

TEST_F(ExteriorJudge, FivePatchesAreTooFewAndSixAreNot) {
  matches_.matched = matches_.agreeing = matches_.places = 6;
  EXPECT_EQ(WhyNot(), std::nullopt);
  matches_.agreeing = matches_.places = 5;
  EXPECT_EQ(WhyNot(), (Finding{Reason::kTooFewAgree, Status::kFailed, 5, 6}));
}

TEST_F(ExteriorJudge, SixPatchesInFivePlacesOverlap) {
  matches_.matched = matches_.agreeing = 6;
  matches_.places = 5;
  EXPECT_EQ(WhyNot(), (Finding{Reason::kPatchesOverlap, Status::kFailed, 5, 6}));
}

TEST_F(ExteriorJudge, OnceInAMillionIsNoChanceAndMoreOftenIs) {
  matches_.proven_before = true;
  matches_.log10_false_alarms = -3;
  EXPECT_EQ(WhyNot(), std::nullopt);
  matches_.log10_false_alarms = JustAbove(-3);
  EXPECT_EQ(WhyNot(), (Finding{Reason::kAgreementMayBeChance, Status::kFailed, 80, 100}));
  matches_.proven_before = false;
  matches_.log10_false_alarms = -6;
  EXPECT_EQ(WhyNot(), std::nullopt);
  matches_.log10_false_alarms = JustAbove(-6);
  EXPECT_EQ(WhyNot(), (Finding{Reason::kAgreementMayBeChance, Status::kFailed, 80, 100}));
}

TEST_F(ExteriorJudge, HalfOfTheMatchedPatchesMayContradictAndNotMore) {
  matches_.agreeing = 30;
  matches_.matched = 60;
  EXPECT_EQ(WhyNot(), std::nullopt);
  matches_.matched = 61;
  EXPECT_EQ(WhyNot(), (Finding{Reason::kMostContradict, Status::kFailed, 30, 61}));
}

TEST_F(ExteriorJudge, NoPatchAtAllIsTooFew) {
  matches_ = {};
  EXPECT_EQ(WhyNot(), (Finding{Reason::kTooFewAgree, Status::kFailed, 0, 6}));
}

TEST_F(ExteriorJudge, OfSeveralObjectionsTheFirstIsSaid) {
  const auto reason = [&] { return WhyNot().value_or(Finding{Reason::kStated}).reason; };
  matches_.matched = 1000;
  EXPECT_EQ(reason(), Reason::kMostContradict);
  matches_.log10_false_alarms = 0;
  EXPECT_EQ(reason(), Reason::kAgreementMayBeChance);
  matches_.places = 1;
  EXPECT_EQ(reason(), Reason::kPatchesOverlap);
  matches_.agreeing = 1;
  EXPECT_EQ(reason(), Reason::kTooFewAgree);
}

TEST_F(ExteriorJudge, HowRareChanceMustBeIsAnOption) {
  options_.max_log10_false_alarms = -51;
  EXPECT_EQ(WhyNot(), (Finding{Reason::kAgreementMayBeChance, Status::kFailed, 80, 100}));
}

TEST_F(ExteriorJudge, NinePlacesAreWeakAndTenAreNot) {
  pose_.places = 10;
  EXPECT_TRUE(Judged().empty());
  pose_.places = 9;
  ExpectOnly(Judged(), {Reason::kFewPlaces, Status::kWeak, 9, 10});
}

TEST_F(ExteriorJudge, PatchesOnLessThanThreePercentOfThePhotoAreWeak) {
  pose_.spread = 0.03;
  EXPECT_TRUE(Judged().empty());
  pose_.spread = JustBelow(0.03);
  ExpectOnly(Judged(), {Reason::kPoorSpread, Status::kWeak, 100 * JustBelow(0.03), 100 * 0.03});
}

TEST_F(ExteriorJudge, PatchesOnALineAreWeak) {
  pose_.spread = 0;
  ExpectOnly(Judged(), {Reason::kPoorSpread, Status::kWeak, 0, 100 * 0.03});
}

TEST(ProjectionSigma, IsToldInPixelsAndOnTheGroundUnlessItIsUnbounded) {
  const auto sigma = ProjectionSigmaOf(0.5, 0.3);
  ASSERT_TRUE(sigma);
  EXPECT_EQ(sigma->px, 0.5);
  EXPECT_EQ(sigma->m, 0.5 * 0.3);
  EXPECT_FALSE(ProjectionSigmaOf(std::numeric_limits<double>::infinity(), 0.3));
}

TEST_F(ExteriorJudge, AProjectionUncertainByMoreThanAPixelIsWeak) {
  pose_.worst_sigma_px = 1;
  EXPECT_TRUE(Judged().empty());
  pose_.worst_sigma_px = JustAbove(1);
  ExpectOnly(Judged(), {Reason::kPoorlyDetermined, Status::kWeak, JustAbove(1), 1});
}

TEST_F(ExteriorJudge, ATrendOfAllResidualsMayReachTheTargetAndOneOfASourceSixTenthsOfIt) {
  pose_.target_px = 1.21;
  pose_.trends = {{TrendKind::kShift, 3, 0.72}, {TrendKind::kQuadrants, std::nullopt, 1.21}};
  for (const Finding& finding : Judged()) EXPECT_EQ(finding.at_best, Status::kOk);
  EXPECT_EQ(Judged().size(), 2u);
  pose_.trends = {{TrendKind::kShift, 3, 0.73}};
  ExpectOnly(Judged(), {Reason::kResidualTrend, Status::kWeak, 0.73, std::nullopt,
                        "shift of the patches from source 3"});
  pose_.trends = {{TrendKind::kQuadrants, std::nullopt, 1.22}};
  ExpectOnly(Judged(), {Reason::kResidualTrend, Status::kWeak, 1.22, std::nullopt,
                        "shift that differs by quadrant"});
}

TEST_F(ExteriorJudge, AProjectionOfUnknownPrecisionIsWeak) {
  pose_.worst_sigma_px = kInfinity;
  ExpectOnly(Judged(), {Reason::kPoorlyDetermined, Status::kWeak, kInfinity, 1});
}

// Nobody vouches for an assumed accuracy: the pose is told to lie far off, and stands.
TEST_F(ExteriorJudge, ContradictingItsApproximationIsWeakOnlyWhereThatCounts) {
  pose_.prior_sigmas = 9;
  EXPECT_TRUE(Judged().empty()) << "many sigmas alone are not said to contradict";
  pose_.contradicts_prior = true;
  Finding expected{.reason = Reason::kContradictsApproximation,
                   .at_best = Status::kWeak,
                   .value = 9,
                   .where = "the patches' coordinates are"};
  ExpectOnly(Judged(), expected);
  pose_.prior_counts = false;
  expected.at_best = Status::kOk;
  ExpectOnly(Judged(), expected);
}

TEST_F(ExteriorJudge, AllThatMakesAPoseWeakIsSaid) {
  pose_.contradicts_prior = true;
  pose_.places = 6;
  pose_.spread = 0;
  pose_.worst_sigma_px = 5;
  std::vector<Reason> reasons;
  for (const Finding& finding : Judged()) {
    EXPECT_EQ(finding.at_best, Status::kWeak) << Code(finding.reason);
    reasons.push_back(finding.reason);
  }
  EXPECT_EQ(reasons, (std::vector<Reason>{Reason::kContradictsApproximation, Reason::kFewPlaces,
                                          Reason::kPoorSpread, Reason::kPoorlyDetermined}));
}

TEST(ConcernsPrecision, FewPlacesAndAPoorlyDeterminedPoseAndNothingElse) {
  std::vector<Reason> of_precision;
  for (const Reason reason : AllReasons())
    if (ConcernsPrecision({reason, Status::kWeak})) of_precision.push_back(reason);
  EXPECT_EQ(of_precision, (std::vector<Reason>{Reason::kFewPlaces, Reason::kPoorlyDetermined}));
}

TEST(WithoutPose, FailsForWhatIsSaid) {
  EXPECT_EQ(
      NoPatches("city.gpkg"),
      (Finding{.reason = Reason::kNoPatches, .at_best = Status::kFailed, .where = "city.gpkg"}));
  EXPECT_EQ(NothingAlike(true), (Finding{Reason::kNothingAlike, Status::kFailed}));
  EXPECT_NE(NothingAlike(false), NothingAlike(true));  // what was not searched was not "not found"
  EXPECT_EQ(NoPreciseResection(5, 40),
            (Finding{Reason::kTooFewPreciseMatches, Status::kFailed, 5, 6}));
  EXPECT_EQ(NoPreciseResection(6, 40),
            (Finding{Reason::kMatchesAgreeOnNoPose, Status::kFailed, 6, 40}));
}

// `window_px` of a wide search is the photo, and no accuracy that could be wrong.
TEST(WithoutPose, NoConsensusNamesTheWindowUnlessTheWholePhotoWasSearched) {
  const LoopRound round{40, 7, 123.4, 1.5};
  EXPECT_EQ(NoConsensus(round, false, true),
            (Finding{Reason::kNoConsensus, Status::kFailed, 7, 40, "123 px"}));
  const Finding wide = NoConsensus(round, true, true);
  EXPECT_EQ(wide.reason, Reason::kNothingAlike);
  EXPECT_EQ(wide.at_best, Status::kFailed);
  EXPECT_EQ(wide.value, 7);
  EXPECT_EQ(wide.limit, 40);
  EXPECT_NE(Sentence(wide).find("kappa: at best 7 of 40 places agree"), std::string::npos);
  EXPECT_NE(Sentence(NoConsensus(round, true, false)).find("not all of them could be tried"),
            std::string::npos);
}

TEST(AddToExterior, TheStatusBecomesTheWorstAndNeverBetter) {
  ExteriorResult result;
  result.status = Status::kOk;
  const Finding note{Reason::kDemHasHoles}, weak{Reason::kDemDatum, Status::kWeak},
      failed{Reason::kNoPatches, Status::kFailed};
  Add(note, &result);
  EXPECT_EQ(result.status, Status::kOk);
  Add(weak, &result);
  EXPECT_EQ(result.status, Status::kWeak);
  Add(note, &result);
  EXPECT_EQ(result.status, Status::kWeak);
  Add(failed, &result);
  EXPECT_EQ(result.status, Status::kFailed);
  Add(weak, &result);
  EXPECT_EQ(result.status, Status::kFailed);
  EXPECT_EQ(result.findings, (Findings{note, weak, note, failed, weak}))
      << "in the order in which they were added";
}

}  // namespace
}  // namespace orient::exterior

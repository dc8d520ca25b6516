#include "block/verdict/judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace orient::block {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Chi-square with six degrees of freedom, 1e-4, from a table.
constexpr double kMovedChi2 = 27.856, kTable = 0.001;

double JustBelow(double value) { return std::nextafter(value, -kInfinity); }
double JustAbove(double value) { return std::nextafter(value, kInfinity); }

// Against whose ties nothing speaks.
TiedPhoto WellTied() {
  TiedPhoto photo;
  photo.ties_used = photo.comparable = 40;
  photo.tie_redundancy = 50;
  photo.worst_sigma_px = 0.3;
  return photo;
}

// `findings` are this one alone.
void ExpectOnly(const Findings& findings, const Finding& expected) {
  ASSERT_EQ(findings.size(), 1u) << JoinedSentences(findings);
  EXPECT_EQ(findings[0], expected) << Code(findings[0].reason) << " " << Sentence(findings[0]);
}

TEST(TiesContradict, WhereMoreThanHalfOfThoseThatCouldDo) {
  TiedPhoto photo = WellTied();
  photo.comparable = 20;
  photo.ties_used = 10;
  EXPECT_FALSE(TiesContradict(photo));
  photo.ties_used = 9;
  EXPECT_TRUE(TiesContradict(photo));
}

TEST(TiesContradict, FiveTiesAreTooFewToContradict) {
  TiedPhoto photo;
  photo.ties_used = 0;
  photo.comparable = 5;
  EXPECT_FALSE(TiesContradict(photo));
  photo.comparable = 6;
  EXPECT_TRUE(TiesContradict(photo));
}

TEST(TiesContradict, NoTiesContradictNothing) { EXPECT_FALSE(TiesContradict({})); }

TEST(TiesContradict, IsSaidAsTheCallerAllows) {
  EXPECT_EQ(TiesContradictFinding(Status::kWeak),
            (Finding{Reason::kTiesContradict, Status::kWeak}));
  EXPECT_EQ(TiesContradictFinding(Status::kFailed),
            (Finding{Reason::kTiesContradict, Status::kFailed}));
}

TEST(JudgeTied, NothingSpeaksAgainstAWellTiedPhoto) { EXPECT_TRUE(JudgeTied(WellTied()).empty()); }

TEST(JudgeTied, FiveTiesAreTooFewAndSixAreNot) {
  TiedPhoto photo = WellTied();
  photo.ties_used = photo.comparable = 6;
  EXPECT_TRUE(JudgeTied(photo).empty());
  photo.ties_used = 5;
  ExpectOnly(JudgeTied(photo), {Reason::kFewTies, Status::kFailed, 5, 6});
}

TEST(JudgeTied, NoTiesAreTooFew) {
  ExpectOnly(JudgeTied({}), {Reason::kFewTies, Status::kFailed, 0, 6});
}

TEST(JudgeTied, TiesThatContradictFail) {
  TiedPhoto photo = WellTied();
  photo.comparable = 81;
  ExpectOnly(JudgeTied(photo), {Reason::kTiesContradict, Status::kFailed});
}

TEST(JudgeTied, TiesBelowARedundancyOfSixControlNothing) {
  TiedPhoto photo = WellTied();
  photo.tie_redundancy = 6;
  EXPECT_TRUE(JudgeTied(photo).empty());
  photo.tie_redundancy = JustBelow(6);
  ExpectOnly(JudgeTied(photo), {Reason::kTiesUncontrolled, Status::kFailed, JustBelow(6), 6});
}

TEST(JudgeTied, AProjectionLessCertainThanTheTargetIsWeakAndThreeTimesSoFails) {
  TiedPhoto photo = WellTied();
  for (const double target : {1.0, 0.5}) {
    photo.target_px = photo.worst_sigma_px = target;
    EXPECT_TRUE(JudgeTied(photo).empty());
    photo.worst_sigma_px = JustAbove(target);
    ExpectOnly(JudgeTied(photo),
               {Reason::kTiesImprecise, Status::kWeak, JustAbove(target), target});
    photo.worst_sigma_px = JustAbove(3 * target);
    ExpectOnly(JudgeTied(photo),
               {Reason::kTiesImprecise, Status::kFailed, JustAbove(3 * target), target});
  }
}

TEST(JudgeTied, AProjectionOfUnknownPrecisionFails) {
  TiedPhoto photo = WellTied();
  for (const double unknown : {kInfinity, kNaN}) {
    photo.worst_sigma_px = unknown;
    const Findings why = JudgeTied(photo);
    ASSERT_EQ(why.size(), 1u) << unknown;
    EXPECT_EQ(why.front().reason, Reason::kTiesImprecise);
    EXPECT_EQ(why.front().at_best, Status::kFailed);
  }
}

TEST(JudgeTied, OfSeveralObjectionsTheFirstIsSaid) {
  TiedPhoto photo = WellTied();
  const auto reason = [&] { return JudgeTied(photo).front().reason; };
  photo.worst_sigma_px = 9;
  EXPECT_EQ(reason(), Reason::kTiesImprecise);
  photo.tie_redundancy = 0;
  EXPECT_EQ(reason(), Reason::kTiesUncontrolled);
  photo.comparable = 1000;
  EXPECT_EQ(reason(), Reason::kTiesContradict);
  photo.ties_used = 0;
  EXPECT_EQ(reason(), Reason::kFewTies);
}

TEST(JudgeAgainstOwnPatches, APhotoThatTheBlockLeavesWhereItWasHasNoFindings) {
  EXPECT_TRUE(JudgeAgainstOwnPatches(WellTied()).empty());
}

// What few or uncontrolled ties would be of a photo without patches is none here.
TEST(JudgeAgainstOwnPatches, ItNeedsNoTies) {
  TiedPhoto photo;
  photo.worst_sigma_px = 1;
  EXPECT_TRUE(JudgeAgainstOwnPatches(photo).empty());
}

TEST(JudgeAgainstOwnPatches, AProjectionUncertainByMoreThanAPixelIsWeak) {
  TiedPhoto photo = WellTied();
  photo.worst_sigma_px = 1;
  EXPECT_TRUE(JudgeAgainstOwnPatches(photo).empty());
  photo.worst_sigma_px = JustAbove(1);
  ExpectOnly(JudgeAgainstOwnPatches(photo),
             {Reason::kPoorlyDetermined, Status::kWeak, JustAbove(1), 1});
  photo.worst_sigma_px = kNaN;
  EXPECT_TRUE(Has(JudgeAgainstOwnPatches(photo), Reason::kPoorlyDetermined));
}

TEST(JudgeAgainstOwnPatches, TiesThatContradictAreWeak) {
  TiedPhoto photo = WellTied();
  photo.comparable = 81;
  ExpectOnly(JudgeAgainstOwnPatches(photo), {Reason::kTiesContradict, Status::kWeak});
}

TEST(JudgeAgainstOwnPatches, MovedFartherThanOneInTenThousandIsWeak) {
  TiedPhoto photo = WellTied();
  photo.moved_chi2 = kMovedChi2 - kTable;
  EXPECT_TRUE(JudgeAgainstOwnPatches(photo).empty());
  photo.moved_chi2 = kMovedChi2 + kTable;
  const Findings findings = JudgeAgainstOwnPatches(photo);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].reason, Reason::kMovedByBlock);
  EXPECT_EQ(findings[0].at_best, Status::kWeak);
  EXPECT_EQ(findings[0].value, std::sqrt(photo.moved_chi2)) << "in sigmas, as the limit";
  EXPECT_NEAR(*findings[0].limit, std::sqrt(kMovedChi2), kTable);
}

TEST(JudgeAgainstOwnPatches, AFifthOfThemThatMisfitTheBlockIsWeak) {
  TiedPhoto photo = WellTied();
  photo.own = {81, 20, 20};
  EXPECT_TRUE(JudgeAgainstOwnPatches(photo).empty());
  photo.own = {80, 20, 20};
  ExpectOnly(JudgeAgainstOwnPatches(photo),
             {Reason::kPatchContradictsBlock, Status::kWeak, 20, 100,
              ": 20 of the 100 patches that the photo was oriented by do not fit it"});
}

TEST(JudgeAgainstOwnPatches, GrossErrorsAmongThemSayNothingOfThePose) {
  TiedPhoto photo = WellTied();
  photo.own = {60, 40, 10};
  EXPECT_TRUE(JudgeAgainstOwnPatches(photo).empty());
}

TEST(JudgeAgainstOwnPatches, ElevenThatMisfitTheBlockAreTooFewToSaySo) {
  TiedPhoto photo = WellTied();
  photo.own = {10, 30, 11};
  EXPECT_TRUE(JudgeAgainstOwnPatches(photo).empty());
  photo.own = {10, 30, 12};
  EXPECT_EQ(JudgeAgainstOwnPatches(photo).size(), 1u);
}

TEST(JudgeAgainstOwnPatches, HeldOffThemByMoreThanTheTargetIsWeakAndByLessARemark) {
  TiedPhoto photo = WellTied();
  photo.moved_chi2 = 9;
  photo.own = {100, 0, 0, 0.1, 0.9};
  Findings findings = JudgeAgainstOwnPatches(photo);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].reason, Reason::kMovedByBlock);
  EXPECT_EQ(findings[0].at_best, Status::kOk);
  EXPECT_EQ(findings[0].value, 3);
  photo.own.rms_px = 1.1;
  findings = JudgeAgainstOwnPatches(photo);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].at_best, Status::kWeak);
}

TEST(JudgeAgainstOwnPatches, AllThatSpeaksAgainstItIsSaid) {
  TiedPhoto photo = WellTied();
  photo.worst_sigma_px = 2;
  photo.comparable = 81;
  photo.moved_chi2 = 100;
  std::vector<Reason> reasons;
  for (const Finding& finding : JudgeAgainstOwnPatches(photo)) reasons.push_back(finding.reason);
  EXPECT_EQ(reasons, (std::vector<Reason>{Reason::kPoorlyDetermined, Reason::kTiesContradict,
                                          Reason::kMovedByBlock}));
}

class LiftImprecisionOf : public testing::Test {
 protected:
  void Lift(const TiedPhoto& photo) { RejudgePrecision(photo, &result_); }
  static ExteriorResult Weak(const Findings& findings) {
    ExteriorResult result;
    result.status = Status::kWeak;
    result.findings = findings;
    return result;
  }

  const Finding few_{Reason::kFewPlaces, Status::kWeak, 9, 12};
  const Finding poor_{Reason::kPoorlyDetermined, Status::kWeak, 2, 1};
  const Finding spread_{Reason::kPoorSpread, Status::kWeak, 1, 3};
  ExteriorResult result_ = Weak({few_, poor_});
};

TEST_F(LiftImprecisionOf, APhotoThatWasWeakForNothingElseIsOk) {
  Lift(WellTied());
  EXPECT_EQ(result_.status, Status::kOk);
  EXPECT_TRUE(result_.findings.empty());
}

TEST_F(LiftImprecisionOf, AnotherObjectionStands) {
  result_ = Weak({few_, spread_, poor_});
  Lift(WellTied());
  EXPECT_EQ(result_.status, Status::kWeak);
  ExpectOnly(result_.findings, spread_);
}

// Weak without a reason would be nobody's judgement.
TEST_F(LiftImprecisionOf, ARemarkKeepsNoPhotoWeak) {
  const Finding holes{Reason::kDemHasHoles, Status::kOk, 3, 90};
  result_ = Weak({few_, holes});
  Lift(WellTied());
  EXPECT_EQ(result_.status, Status::kOk);
  ExpectOnly(result_.findings, holes);
}

// The block tells its own figure (JudgeAgainstOwnPatches), ties or not.
TEST_F(LiftImprecisionOf, WhatThePhotoAloneSaidOfAPoorProjectionIsNotToldTwice) {
  TiedPhoto photo;
  photo.worst_sigma_px = JustAbove(photo.target_px);
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kWeak);
  ExpectOnly(result_.findings, few_);
}

TEST_F(LiftImprecisionOf, APhotoThatSaysNothingOfItsPrecisionStaysAsItIs) {
  for (const Findings& findings : {Findings{spread_}, Findings{}}) {
    result_ = Weak(findings);
    Lift(WellTied());
    EXPECT_EQ(result_.status, Status::kWeak);
    EXPECT_EQ(result_.findings, findings);
  }
}

// With the points of one or two photos as a block's only control a wrong one would hardly show.
TEST_F(LiftImprecisionOf, FewMeasuredPointsAreEnoughWhereTheBlockHasMoreControl) {
  const Finding by_points{Reason::kByPointsAlone, Status::kWeak, 4, 6};
  TiedPhoto photo = WellTied();
  photo.control_elsewhere = 11;
  result_ = Weak({by_points});
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kWeak);
  ExpectOnly(result_.findings, {Reason::kLittleOtherControl, Status::kWeak, 11, 12});
  photo.control_elsewhere = 12;
  result_ = Weak({by_points});
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kOk);
  EXPECT_TRUE(result_.findings.empty());
}

TEST_F(LiftImprecisionOf, WhatEnoughPointsAloneSaidIsNotToldOfTheBlocksPose) {
  TiedPhoto photo = WellTied();
  result_.status = Status::kOk;
  result_.findings = {{Reason::kByPointsAlone, Status::kOk, 7, 6}};
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kOk);
  EXPECT_TRUE(result_.findings.empty());
}

TEST_F(LiftImprecisionOf, FiveTiesLiftNothing) {
  TiedPhoto photo = WellTied();
  photo.ties_used = 5;
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kWeak);
  EXPECT_EQ(result_.findings, (Findings{few_, poor_}));
  photo.ties_used = 6;
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kOk);
}

TEST_F(LiftImprecisionOf, TiesThatDoNotControlOneAnotherLiftNothing) {
  TiedPhoto photo = WellTied();
  photo.tie_redundancy = JustBelow(6);
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kWeak);
  EXPECT_EQ(result_.findings, (Findings{few_, poor_}));
  photo.tie_redundancy = 6;
  Lift(photo);
  EXPECT_EQ(result_.status, Status::kOk);
}

TEST_F(LiftImprecisionOf, AFailedPhotoStaysFailed) {
  result_.status = Status::kFailed;
  Lift(WellTied());
  EXPECT_EQ(result_.status, Status::kFailed);
  EXPECT_EQ(result_.findings, (Findings{few_, poor_}));
}

// Of one photo, by GNSS and approximations and without them.
class HoldToWhatControlGives : public testing::Test {
 protected:
  static ExteriorResult Result(Status status, const Findings& findings, double x) {
    ExteriorResult result;
    result.status = status;
    result.findings = findings;
    if (status != Status::kFailed) result.pose = Pose{{x, 0, 0}, {0, 0, 0}};
    return result;
  }
  // Poses at x = 1 without, at x = 2 with them.
  static ExteriorResult Held(Status without, const Findings& why, Status with,
                             const Findings& why_with = {}) {
    ExteriorResult adjusted = Result(with, why_with, 2);
    HoldTo(Result(without, why, 1), &adjusted);
    return adjusted;
  }

  const Finding few_{Reason::kFewPlaces, Status::kWeak, 9, 12};
  const Finding spread_{Reason::kPoorSpread, Status::kWeak, 1, 3};
  const Finding no_ties_{Reason::kNoTies, Status::kFailed};
};

TEST_F(HoldToWhatControlGives, WhatIsOkWithoutThemStaysAsItIsWithThem) {
  for (const Status with : {Status::kOk, Status::kWeak, Status::kFailed}) {
    const ExteriorResult result = Held(Status::kOk, {}, with, {few_});
    EXPECT_EQ(result.status, with);
    EXPECT_EQ(result.findings, Findings{few_});
    if (result.pose) {
      EXPECT_EQ(result.pose->position_m.x(), 2);
    }
  }
}

TEST_F(HoldToWhatControlGives, WhatIsWeakWithoutThemIsWeakAndSaysWhy) {
  const ExteriorResult result = Held(Status::kWeak, {few_, spread_}, Status::kOk);
  EXPECT_EQ(result.status, Status::kWeak);
  ExpectOnly(result.findings, {.reason = Reason::kWeakWithoutPriors,
                               .at_best = Status::kWeak,
                               .where = ": " + JoinedSentences({few_, spread_})});
  ASSERT_TRUE(result.pose);
  EXPECT_EQ(result.pose->position_m.x(), 2) << "the pose is the better one";
}

TEST_F(HoldToWhatControlGives, WhatIsWeakWithoutAReasonIsWeak) {
  ExpectOnly(Held(Status::kWeak, {}, Status::kOk).findings,
             {.reason = Reason::kWeakWithoutPriors, .at_best = Status::kWeak});
}

TEST_F(HoldToWhatControlGives, WhatIsWeakWithThemAnywayIsNotToldTwice) {
  const ExteriorResult result = Held(Status::kWeak, {few_}, Status::kWeak, {spread_});
  EXPECT_EQ(result.status, Status::kWeak);
  ExpectOnly(result.findings, spread_);
}

TEST_F(HoldToWhatControlGives, WhatIsWeakWithoutThemAndFailsWithThemFails) {
  const ExteriorResult result = Held(Status::kWeak, {few_}, Status::kFailed, {no_ties_});
  EXPECT_EQ(result.status, Status::kFailed);
  ExpectOnly(result.findings, no_ties_);
}

TEST_F(HoldToWhatControlGives, WhatFailsWithoutThemHasNoPoseByThem) {
  for (const Status with : {Status::kOk, Status::kWeak}) {
    const ExteriorResult result = Held(Status::kFailed, {no_ties_}, with, {few_});
    EXPECT_EQ(result.status, Status::kFailed);
    EXPECT_FALSE(result.pose);
    EXPECT_EQ(result.findings,
              (Findings{{Reason::kFailedWithoutPriors, Status::kFailed}, no_ties_}));
  }
}

TEST_F(HoldToWhatControlGives, WhatFailsEitherWayIsNotSaidToNeedThem) {
  const ExteriorResult result = Held(Status::kFailed, {no_ties_}, Status::kFailed, {few_});
  EXPECT_EQ(result.status, Status::kFailed);
  ExpectOnly(result.findings, no_ties_);
}

}  // namespace
}  // namespace orient::block

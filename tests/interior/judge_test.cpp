#include "interior/judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "interior/constellation/set_evidence.h"
#include "interior/orientation/film_orientation.h"

namespace orient::interior {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double JustBelow(double value) { return std::nextafter(value, -kInfinity); }
double JustAbove(double value) { return std::nextafter(value, kInfinity); }

// A film against whose marks nothing speaks: all found where they belong, no rival of any kind.
class JudgedFilm {
 public:
  explicit JudgedFilm(int marks_of_camera) {
    reading.pixel_size = {0.015, 0.005};  // stated
    reading.scanner = Scanner::kPhotogrammetric;
    for (int i = 0; i < marks_of_camera; ++i) {
      AssignmentMark mark;
      const double turn = 2 * std::numbers::pi * i / marks_of_camera;
      mark.place_mm = 100 * Eigen::Vector2d(std::cos(turn), std::sin(turn));
      mark.candidates = {{mark.place_mm, 0}};
      mark.window_mm2 = 1e4;  // next to no clutter
      reading.marks.push_back(mark);
    }
    reading.best.choice.assign(reading.marks.size(), 0);
    reading.best.nats = 1e3;
    reading.margin = 30;
    marks.resize(reading.marks.size());
    for (FilmMark& mark : marks) mark.state = MarkState::kUsed;
    film.emplace();
    film->affine = true;
    film->sigma0_um = 5;
    film->pixel_um = 15;
  }

  void Reject(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) marks[i].state = MarkState::kRejected;
  }
  Findings Judged() const {
    std::vector<std::string> unused;
    for (std::size_t i = 0; i < marks.size(); ++i)
      if (marks[i].state != MarkState::kUsed) unused.push_back(std::to_string(i + 1));
    return Judge(reading, marks, film, unused);
  }

  FilmReading reading;
  FilmMarks marks;
  std::optional<FilmTransform> film;
};

// `findings` are this one alone.
void ExpectOnly(const Findings& findings, const Finding& expected) {
  ASSERT_EQ(findings.size(), 1u) << JoinedSentences(findings);
  EXPECT_EQ(findings[0], expected) << Code(findings[0].reason) << " " << Sentence(findings[0]);
}

TEST(InteriorJudge, AFilmAgainstWhichNothingSpeaksHasNoFindings) {
  for (const int marks : {4, 8}) {
    const Findings findings = JudgedFilm(marks).Judged();
    EXPECT_TRUE(findings.empty()) << JoinedSentences(findings);
  }
}

TEST(InteriorJudge, TwoUsedMarksOfThoseFoundFailTheFilmAndThreeDoNot) {
  JudgedFilm judged(4);
  judged.Reject(1);
  EXPECT_EQ(StatusOf(judged.Judged()), Status::kWeak);
  judged.Reject(2);
  ExpectOnly(judged.Judged(), {Reason::kFewMarks, Status::kFailed, 2, 3, "1, 2"});
}

TEST(InteriorJudge, AReadingOfTwoMarksIsNotFoundHoweverManyAreUsed) {
  JudgedFilm judged(8);
  judged.reading.best.choice = {0, 0, -1, -1, -1, -1, -1, -1};
  ExpectOnly(judged.Judged(), {Reason::kMarksNotFound, Status::kFailed, 2, 3});
  judged.reading.best.choice[2] = 0;
  EXPECT_FALSE(Has(judged.Judged(), Reason::kMarksNotFound));
}

TEST(InteriorJudge, MarksOfThePolarityThatTheUserExcludedMakeTheFilmWeakFromFiveNatsOn) {
  JudgedFilm judged(4);
  judged.reading.polarity = Polarity::kNegative;
  judged.reading.polarity_margin = JustAbove(-5);
  EXPECT_TRUE(judged.Judged().empty());
  judged.reading.polarity_margin = -5;
  ExpectOnly(judged.Judged(), {Reason::kPolarityUnlikeMarks, Status::kWeak, 5, 5, "positive"});
}

TEST(InteriorJudge, MarksOfThePolarityThatTheUserExcludedAreToldBeforeThoseNotFound) {
  JudgedFilm judged(4);
  judged.reading.best.choice = {0, -1, -1, -1};
  judged.reading.polarity_margin = -20;
  const Findings findings = judged.Judged();
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0],
            (Finding{Reason::kPolarityUnlikeMarks, Status::kFailed, 20, 5, "negative"}));
  EXPECT_EQ(findings[1].reason, Reason::kMarksNotFound);
}

TEST(InteriorJudge, ACameraWithoutMarksIsNotFound) {
  JudgedFilm judged(0);
  ExpectOnly(judged.Judged(), {Reason::kMarksNotFound, Status::kFailed, 0, 3});
}

TEST(InteriorJudge, ASetMayBeChanceBelowTheNatsThatItsCameraNeeds) {
  for (const int marks : {4, 8}) {
    JudgedFilm judged(marks);
    const double needed = MinSetNats(marks);
    judged.reading.best.nats = needed;
    EXPECT_TRUE(judged.Judged().empty()) << marks;
    judged.reading.best.nats = JustBelow(needed);
    ExpectOnly(judged.Judged(),
               {Reason::kMarksMayBeChance, Status::kFailed, JustBelow(needed), needed});
  }
}

TEST(InteriorJudge, RejectedMarksGiveNoNats) {
  JudgedFilm judged(8);
  // What all eight earn is enough, what three of them earn is not.
  for (AssignmentMark& mark : judged.reading.marks) mark.window_mm2 = 5;
  std::vector<int> kept(8, -1);
  for (std::size_t i = 5; i < 8; ++i) kept[i] = 0;
  const double of_kept = NatsOfSet(judged.reading.marks, judged.reading.prior, kept);
  ASSERT_LT(of_kept, MinSetNats(8));
  judged.reading.best.nats =
      NatsOfSet(judged.reading.marks, judged.reading.prior, judged.reading.best.choice);
  ASSERT_GT(judged.reading.best.nats, MinSetNats(8));
  EXPECT_TRUE(judged.Judged().empty());
  judged.Reject(5);
  ExpectOnly(judged.Judged(),
             {Reason::kMarksMayBeChance, Status::kFailed, of_kept, MinSetNats(8), "1, 2, 3, 4, 5"});
}

TEST(InteriorJudge, ASearchThatWasNotThroughFails) {
  JudgedFilm judged(4);
  judged.reading.proven = false;
  judged.reading.margin = 0;  // as is then said
  ExpectOnly(judged.Judged(), {Reason::kTooManyReadings, Status::kFailed});
}

TEST(InteriorJudge, ARivalReadingThreeNatsBehindFailsTheFilm) {
  JudgedFilm judged(4);
  judged.reading.margin = JustAbove(3);
  EXPECT_TRUE(judged.Judged().empty());
  judged.reading.margin = 3;
  ExpectOnly(judged.Judged(), {Reason::kRivalReading, Status::kFailed, 3, 3});
}

TEST(InteriorJudge, ARivalReadingNamesTheMarksThatWereNotUsed) {
  JudgedFilm judged(4);
  judged.reading.margin = 1;
  judged.marks[2].state = MarkState::kMissing;
  ExpectOnly(judged.Judged(), {Reason::kRivalReading, Status::kFailed, 1, 3, "3"});
}

TEST(InteriorJudge, OfManyUnusedMarksEightAreNamed) {
  JudgedFilm judged(25);
  judged.Reject(23);
  ExpectOnly(judged.Judged(),
             {Reason::kFewMarks, Status::kFailed, 2, 3, "1, 2, 3, 4, 5, 6, 7, 8 and 15 more"});
}

TEST(InteriorJudge, MarksOnOneLineFail) {
  JudgedFilm judged(4);
  judged.film.reset();
  ExpectOnly(judged.Judged(), {Reason::kMarksOnOneLine, Status::kFailed});
}

TEST(InteriorJudge, OfSeveralObjectionsTheFirstFailsTheFilmAlone) {
  JudgedFilm judged(4);
  judged.film.reset();
  const auto reason = [&] {
    const Findings findings = judged.Judged();
    return findings.size() == 1 ? findings[0].reason : Reason::kStated;
  };
  judged.reading.margin = 0;
  EXPECT_EQ(reason(), Reason::kRivalReading);
  judged.reading.proven = false;
  EXPECT_EQ(reason(), Reason::kTooManyReadings);
  judged.reading.best.nats = 0;
  EXPECT_EQ(reason(), Reason::kMarksMayBeChance);
  judged.Reject(2);
  EXPECT_EQ(reason(), Reason::kFewMarks);
  judged.reading.best.choice = {0, 0, -1, -1};
  EXPECT_EQ(reason(), Reason::kMarksNotFound);
}

TEST(InteriorJudge, ThreeOfFourMarksAreWeak) {
  JudgedFilm judged(4);
  judged.Reject(1);
  judged.film->affine = false;  // three give a similarity
  ExpectOnly(judged.Judged(), {Reason::kFewMarks, Status::kWeak, 3, 4, "1"});
}

TEST(InteriorJudge, AllThreeMarksOfACameraOfThreeAreWeak) {
  ExpectOnly(JudgedFilm(3).Judged(), {Reason::kFewMarks, Status::kWeak, 3, 4});
}

TEST(InteriorJudge, FourOfEightMarksAreWeakAndFiveAreNot) {
  JudgedFilm judged(8);
  judged.Reject(3);
  EXPECT_TRUE(judged.Judged().empty());
  judged.Reject(4);
  ExpectOnly(judged.Judged(), {Reason::kFewMarks, Status::kWeak, 4, 5, "1, 2, 3, 4"});
}

TEST(InteriorJudge, ScalesThatDifferByMoreThanThreePercentAreWeak) {
  JudgedFilm judged(4);
  for (const double sign : {1.0, -1.0}) {
    judged.film->shape.scale_difference = sign * 0.03;
    EXPECT_TRUE(judged.Judged().empty());
    judged.film->shape.scale_difference = sign * JustAbove(0.03);
    ExpectOnly(judged.Judged(),
               {Reason::kScaleDifference, Status::kWeak, sign * 100 * JustAbove(0.03), 100 * 0.03});
  }
}

TEST(InteriorJudge, AShearOfMoreThanFifteenMilliradiansIsWeak) {
  JudgedFilm judged(4);
  for (const double sign : {1.0, -1.0}) {
    judged.film->shape.shear_rad = sign * 0.015;
    EXPECT_TRUE(judged.Judged().empty());
    judged.film->shape.shear_rad = sign * JustAbove(0.015);
    ExpectOnly(judged.Judged(),
               {Reason::kShear, Status::kWeak, sign * 1e3 * JustAbove(0.015), 1e3 * 0.015});
  }
}

TEST(InteriorJudge, APixelOnePointFivePercentOffItsStatedSizeIsWeak) {
  JudgedFilm judged(4);
  for (const double sign : {1.0, -1.0}) {
    judged.film->pixel_um = 15 * (1 + sign * 0.01499);
    EXPECT_TRUE(judged.Judged().empty());
    judged.film->pixel_um = 15 * (1 + sign * 0.01501);
    ExpectOnly(judged.Judged(),
               {Reason::kPixelSizeIsNotAsStated, Status::kWeak, judged.film->pixel_um, 15});
  }
}

TEST(InteriorJudge, APixelSizeThatNobodyStatedIsNotContradicted) {
  JudgedFilm judged(4);
  judged.film->pixel_um = 16;
  judged.reading.pixel_size.sigma = 0.01;
  EXPECT_TRUE(judged.Judged().empty());
  judged.reading.pixel_size.sigma = JustBelow(0.01);
  EXPECT_TRUE(Has(judged.Judged(), Reason::kPixelSizeIsNotAsStated));
}

TEST(InteriorJudge, TheOtherScannerThreeNatsBehindIsWeak) {
  JudgedFilm judged(4);
  judged.reading.scanner_margin = JustAbove(3);
  EXPECT_TRUE(judged.Judged().empty());
  judged.reading.scanner_margin = 3;
  ExpectOnly(judged.Judged(), {Reason::kRivalScanner, Status::kWeak, 3, 3});
}

TEST(InteriorJudge, AnotherScanOrientationLessThanFiveNatsBehindIsWeak) {
  JudgedFilm judged(4);
  judged.reading.rival_orientations = {{ScanOrientation::kR180, 9}, {ScanOrientation::kR90, 5}};
  EXPECT_TRUE(judged.Judged().empty());
  judged.reading.rival_orientations.back().nats = JustBelow(5);
  ExpectOnly(judged.Judged(), {Reason::kRivalScanOrientation, Status::kWeak, JustBelow(5), 5});
}

TEST(InteriorJudge, Sigma0IsWeakAboveWhatItsScannerExplains) {
  for (const Scanner scanner : {Scanner::kPhotogrammetric, Scanner::kDesktop}) {
    const double limit = scanner == Scanner::kPhotogrammetric ? 60 : 350;
    JudgedFilm judged(4);
    judged.reading.scanner = scanner;
    judged.film->sigma0_um = limit;
    EXPECT_EQ(StatusOf(judged.Judged()), Status::kOk);
    judged.film->sigma0_um = JustAbove(limit);
    ExpectOnly(judged.Judged(), {Reason::kLargeSigma0, Status::kWeak, JustAbove(limit), limit});
  }
}

TEST(InteriorJudge, AFilmDistortedByMoreThanThirtyMicrometresIsOkAndSaysSo) {
  JudgedFilm judged(4);
  judged.film->sigma0_um = 30;
  EXPECT_TRUE(judged.Judged().empty());
  judged.film->sigma0_um = JustAbove(30);
  ExpectOnly(judged.Judged(), {Reason::kFilmDistorted, Status::kOk, JustAbove(30), 30});
  judged.film->affine = false;
  EXPECT_TRUE(judged.Judged().empty()) << "a similarity says nothing of an affine's rest";
}

TEST(InteriorJudge, AllThatMakesAFilmWeakIsSaid) {
  JudgedFilm judged(4);
  judged.Reject(1);
  judged.film->shape = {.scale_difference = 0.1, .shear_rad = 0.1};
  judged.film->pixel_um = 20;
  judged.film->sigma0_um = 100;
  judged.reading.scanner_margin = 0;
  judged.reading.rival_orientations = {{ScanOrientation::kR90, 0}};
  std::vector<Reason> reasons;
  for (const Finding& finding : judged.Judged()) {
    EXPECT_EQ(finding.at_best, Status::kWeak) << Code(finding.reason);
    reasons.push_back(finding.reason);
  }
  EXPECT_EQ(reasons,
            (std::vector<Reason>{Reason::kFewMarks, Reason::kScaleDifference, Reason::kShear,
                                 Reason::kPixelSizeIsNotAsStated, Reason::kRivalScanner,
                                 Reason::kRivalScanOrientation, Reason::kLargeSigma0}));
}

TEST(InteriorJudge, APixelSizeThatOnlyTheMarksSayIsUnsure) {
  FilmReading reading;
  InteriorResult result;
  reading.pixel_size.sigma = 0.01;
  EXPECT_EQ(JudgePixelSize(reading, result), std::nullopt) << "no pixel size at all";
  result.pixel_size_um = 14.5;
  EXPECT_EQ(JudgePixelSize(reading, result),
            (Finding{Reason::kPixelSizeUnsure, Status::kWeak, 14.5}));
  reading.pixel_size.sigma = JustBelow(0.01);
  EXPECT_EQ(JudgePixelSize(reading, result), std::nullopt);
}

class JudgedReseau : public testing::Test {
 protected:
  void Mark(int used, int rejected) {
    result_.marks.assign(static_cast<std::size_t>(used + rejected), {});
    for (std::size_t i = 0; i < result_.marks.size(); ++i)
      result_.marks[i].state = static_cast<int>(i) < used ? MarkState::kUsed : MarkState::kRejected;
  }
  InteriorResult result_;
};

TEST_F(JudgedReseau, FifteenCrossesThatGiveNoneAreFiducialMarks) {
  Mark(15, 10);
  EXPECT_EQ(JudgeReseau(result_), std::nullopt);
}

TEST_F(JudgedReseau, SixteenCrossesThatGiveNoneContradictOneAnother) {
  Mark(16, 0);
  EXPECT_EQ(JudgeReseau(result_), (Finding{Reason::kReseauContradictory, Status::kWeak}));
}

TEST_F(JudgedReseau, IsOkFromSixtyPercentOfItsCrossesOn) {
  Mark(5, 20);  // 60 % of all 25 that the camera has; what is used does not count here
  result_.reseau.emplace();
  result_.reseau->noise_um = 1.2;
  result_.reseau->left_out_rms_um = 3.8;
  const std::string figures = "noise 1.2 um, left-out crosses 3.8 um";
  result_.reseau->crosses = 15;
  EXPECT_EQ(JudgeReseau(result_),
            (Finding{Reason::kReseauCorrection, Status::kOk, 15, 15, figures}));
  result_.reseau->crosses = 14;
  EXPECT_EQ(JudgeReseau(result_),
            (Finding{Reason::kFewReseauCrosses, Status::kWeak, 14, 15, figures}));
}

TEST(JudgeImageSize, FailsAnImageOfAnotherSizeThanItsCameras) {
  EXPECT_EQ(JudgeImageSize({640, 480}, {640, 480}), std::nullopt);
  EXPECT_EQ(JudgeImageSize({640, 480}, {640, 481}),
            (Finding{.reason = Reason::kImageSizeIsNotTheCameras,
                     .at_best = Status::kFailed,
                     .where = "640 x 480 pixels, the camera's image_px is 640 x 481"}));
  EXPECT_TRUE(JudgeImageSize({480, 640}, {640, 480})) << "turned";
}

TEST(BlackAndWhite, IsWeak) {
  EXPECT_EQ(BlackAndWhite(), (Finding{Reason::kBlackAndWhite, Status::kWeak}));
}

TEST(JudgeGiven, ByTheLayoutIsContradictedFromFiveNatsOn) {
  const ScanOrientation given = ScanOrientation::kR0, best = ScanOrientation::kR90;
  EXPECT_EQ(JudgeGivenByLayout(given, best, JustBelow(5)), std::nullopt);
  EXPECT_EQ(JudgeGivenByLayout(given, best, 5),
            (Finding{Reason::kOrientationUnlikeLayout, Status::kWeak, 5, 5,
                     std::string(Name(best)) + ", not " + std::string(Name(given))}));
}

TEST(JudgeGiven, BySignsIsContradictedWhereTheyDoNotLeaveIt) {
  const ScanOrientation r0 = ScanOrientation::kR0, r90 = ScanOrientation::kR90,
                        r180 = ScanOrientation::kR180;
  EXPECT_EQ(JudgeGivenBySigns(r90, {r0, r90}), std::nullopt) << "the likelier need not be it";
  const std::string names = std::string(Name(r0)) + ", " + std::string(Name(r90));
  EXPECT_EQ(JudgeGivenBySigns(r180, {r0, r90}),
            (Finding{.reason = Reason::kOrientationUnlikeSigns,
                     .at_best = Status::kWeak,
                     .where = names + ", not " + std::string(Name(r180))}));
}

TEST(JudgeFound, SaysNothingOfAScanOrientationThatAllSignsAgreeOn) {
  EXPECT_TRUE(JudgeFound(false, "", {ScanOrientation::kR0}).empty());
  EXPECT_TRUE(JudgeFound(false, "", {}).empty());
}

TEST(JudgeFound, NamesSignsThatWereOutvoted) {
  ExpectOnly(JudgeFound(false, "the border", {ScanOrientation::kR0}),
             {.reason = Reason::kSignNotClear, .where = "the border"});
}

TEST(JudgeFound, NamesOneSideOfAContradiction) {
  ExpectOnly(JudgeFound(true, "the border", {ScanOrientation::kR0}),
             {.reason = Reason::kSignsContradictory, .where = "the border"});
  ExpectOnly(JudgeFound(true, "", {ScanOrientation::kR0}), {.reason = Reason::kSignsContradictory});
}

// What the marks leave open, exterior orientation decides: no reason to call them weak.
TEST(JudgeFound, WhatIsLeftOpenIsNamedAndOk) {
  const ScanOrientation r0 = ScanOrientation::kR0, r180 = ScanOrientation::kR180;
  const Findings findings = JudgeFound(true, "the border", {r180, r0});
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].reason, Reason::kSignsContradictory);
  EXPECT_EQ(findings[1],
            (Finding{.reason = Reason::kOrientationOpen,
                     .where = std::string(Name(r180)) + ", " + std::string(Name(r0))}));
  EXPECT_EQ(StatusOf(findings), Status::kOk);
}

TEST(AddToInterior, TheStatusBecomesTheWorstAndNeverBetter) {
  InteriorResult result;
  result.status = Status::kOk;
  Add(Finding{Reason::kFilmDistorted}, &result);
  EXPECT_EQ(result.status, Status::kOk);
  Add(Findings{{Reason::kFewMarks, Status::kWeak}, {Reason::kFilmDistorted}}, &result);
  EXPECT_EQ(result.status, Status::kWeak);
  Add(Findings{{Reason::kFilmDistorted}}, &result);
  EXPECT_EQ(result.status, Status::kWeak);
  result.status = Status::kFailed;
  Add(Finding{Reason::kShear, Status::kWeak}, &result);
  EXPECT_EQ(result.status, Status::kFailed);
  std::vector<Reason> reasons;
  for (const Finding& finding : result.findings) reasons.push_back(finding.reason);
  EXPECT_EQ(reasons,
            (std::vector<Reason>{Reason::kFilmDistorted, Reason::kFewMarks, Reason::kFilmDistorted,
                                 Reason::kFilmDistorted, Reason::kShear}))
      << "in the order in which they were added";
}

TEST(AddToInterior, NoFindingChangesNothing) {
  InteriorResult result;
  result.status = Status::kOk;
  Add(std::optional<Finding>(), &result);
  EXPECT_EQ(result.status, Status::kOk);
  EXPECT_TRUE(result.findings.empty());
}

TEST(JudgeRejected, IsWeakWhereAnotherMarkMayBeTheWrongOne) {
  EXPECT_FALSE(JudgeRejected({}));
  const auto finding = JudgeRejected({"2", "5"});
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->reason, Reason::kWrongMarkUnclear);
  EXPECT_EQ(finding->at_best, Status::kWeak);
  EXPECT_EQ(finding->where, "2, 5");
}

}  // namespace
}  // namespace orient::interior

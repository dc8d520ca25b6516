// Which way the film lies: symbols, data strip and border on whole simulated frames.
#include "interior/orientation/film_orientation.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>

#include "interior/interior.h"
#include "tests/support/film_frame.h"
#include "tests/support/film_signs.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kPixelMm = 0.1;

// A 4 cm frame with ring marks in its corners and 9 mm of rebate.
CameraFile SmallCamera() { return RingCamera(20, 40); }

MarkSymbol Symbol(SymbolKind kind, int count, bool place_known) {
  if (!place_known) return {kind, count, std::nullopt, std::nullopt};
  return {kind, count, kSymbolAt_mm, kSymbolStep_mm};
}

// Marks 1 to 4 with so many lines.
CameraFile NumberedCamera(bool place_known) {
  CameraFile camera = SmallCamera();
  for (size_t i = 0; i < camera.fiducials.size(); ++i)
    camera.fiducials[i].symbol = Symbol(SymbolKind::kLines, static_cast<int>(i) + 1, place_known);
  return camera;
}

FilmFrameSpec Spec(const CameraFile& camera, ScanOrientation orientation, unsigned seed = 3) {
  FilmFrameSpec spec;
  spec.camera = camera;
  spec.pixel_mm = kPixelMm;
  spec.rebate_mm = 9;
  spec.orientation = orientation;
  spec.turn_rad = 0.01;
  spec.shift_px = {3.3, -2.6};
  spec.seed = seed;
  return spec;
}

InteriorResult Orient(const FilmFrame& frame, const CameraFile& camera,
                      std::optional<ScanOrientation> orientation = std::nullopt) {
  const TemporaryFolder folder;
  WriteScan(folder / "scan.png", frame.scan);
  InteriorOptions options;
  options.pixel_size_um = 1e3 * kPixelMm;
  options.orientation = orientation;
  return OrientInterior(Raster::Open(folder / "scan.png"), camera, ShapesOf(camera), options);
}

bool Holds(const std::vector<ScanOrientation>& orientations, ScanOrientation one) {
  return std::find(orientations.begin(), orientations.end(), one) != orientations.end();
}

// What the marks alone say, had they been measured without error and the film been taken to lie r0.
InteriorResult MarksOnly(const FilmFrame& frame, const FilmFrameSpec& spec) {
  InteriorResult truth;
  truth.polarity = spec.polarity;
  truth.photo_from_pixel = frame.pixel_from_photo.Inverse();
  truth.possible_orientations = {spec.orientation};
  for (const ScanOrientation other : kAllScanOrientations)
    if (other != spec.orientation) truth.possible_orientations.push_back(other);
  for (size_t i = 0; i < frame.mark_pixels.size(); ++i)
    truth.marks.push_back({spec.camera.fiducials[i].id, MarkState::kUsed, frame.mark_pixels[i],
                           Vector2d(0.02, 0.02), std::nullopt, 0.9});
  return InOrientation(truth, spec.camera, ShapesOf(spec.camera), ScanOrientation::kR0).value();
}

// Which ways stay open once `camera`'s symbols and border have been looked for on the film.
OrientationDecision DecisionOn(const FilmFrameSpec& spec, const CameraFile& camera) {
  const FilmFrame frame = RenderFilmFrame(spec);
  const TemporaryFolder folder;
  WriteScan(folder / "scan.png", frame.scan);
  const OrientationClass open(kAllScanOrientations.begin(), kAllScanOrientations.end());
  return Decide(open, VotesOfFilm(Raster::Open(folder / "scan.png"), camera, ShapesOf(camera),
                                  MarksOnly(frame, spec), open));
}

void ExpectDecided(const CameraFile& camera, ScanOrientation orientation,
                   Polarity polarity = Polarity::kPositive) {
  SCOPED_TRACE(std::string(Name(orientation)) + " " + std::string(Name(polarity)));
  FilmFrameSpec spec = Spec(camera, orientation);
  spec.polarity = polarity;
  EXPECT_EQ(DecisionOn(spec, camera).possible, OrientationClass{orientation});
}

// Truth in every respect, found from the scan alone.
void ExpectFound(const CameraFile& camera, const FilmFrameSpec& spec) {
  SCOPED_TRACE(std::string(Name(spec.orientation)) + " " + std::string(Name(spec.polarity)));
  constexpr double kTolerancePx = 0.25;
  const FilmFrame frame = RenderFilmFrame(spec);
  const InteriorResult result = Orient(frame, camera);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_EQ(result.orientation, spec.orientation);
  EXPECT_EQ(result.possible_orientations, OrientationClass{spec.orientation});
  EXPECT_EQ(result.polarity, spec.polarity);
  ASSERT_EQ(result.marks.size(), camera.fiducials.size());
  for (size_t i = 0; i < camera.fiducials.size(); ++i) {
    EXPECT_EQ(result.marks[i].id, camera.fiducials[i].id);
    const Vector2d pixel = result.photo_from_pixel->Inverse() * camera.fiducials[i].position_mm;
    EXPECT_LT((pixel - frame.mark_pixels[i]).norm(), kTolerancePx);
  }
}

TEST(FilmOrientation, IsFoundTogetherWithTheMarks) {
  FilmFrameSpec spec = Spec(NumberedCamera(true), ScanOrientation::kM90);
  spec.polarity = Polarity::kNegative;
  ExpectFound(spec.camera, spec);
}

TEST(SlowFilmOrientation, IsFoundTogetherWithTheMarksInAllWaysAndPolarities) {
  for (const bool place_known : {true, false})
    for (const ScanOrientation orientation : kAllScanOrientations)
      for (const Polarity polarity : {Polarity::kPositive, Polarity::kNegative}) {
        FilmFrameSpec spec = Spec(NumberedCamera(place_known), orientation);
        spec.polarity = polarity;
        ExpectFound(spec.camera, spec);
      }
}

TEST(FilmOrientation, LinesAtKnownPlacesTellIt) {
  for (const ScanOrientation orientation :
       {ScanOrientation::kR0, ScanOrientation::kR270, ScanOrientation::kM90})
    ExpectDecided(NumberedCamera(true), orientation,
                  IsMirrored(orientation) ? Polarity::kNegative : Polarity::kPositive);
}

TEST(FilmOrientation, LinesSomewhereBesideTheMarksTellIt) {
  for (const ScanOrientation orientation :
       {ScanOrientation::kR90, ScanOrientation::kM0, ScanOrientation::kM270})
    ExpectDecided(NumberedCamera(false), orientation);
}

TEST(FilmOrientation, DotsAreNotTakenForLines) {
  CameraFile dots = NumberedCamera(true);
  for (Fiducial& f : dots.fiducials) f.symbol->kind = SymbolKind::kDots;
  ExpectDecided(dots, ScanOrientation::kR180);
  const FilmFrameSpec spec = Spec(dots, ScanOrientation::kR180);
  EXPECT_EQ(DecisionOn(spec, NumberedCamera(true)).possible.size(), 8u);
  EXPECT_EQ(DecisionOn(spec, NumberedCamera(false)).possible.size(), 8u);
}

TEST(FilmOrientation, OneMarkWithADotTellsIt) {
  CameraFile camera = SmallCamera();
  camera.fiducials[2].symbol =
      MarkSymbol{SymbolKind::kDots, 1, Vector2d(2.6, 1.0), Vector2d(0.5, 0)};
  for (const ScanOrientation orientation : {ScanOrientation::kR270, ScanOrientation::kM90})
    ExpectDecided(camera, orientation);
}

TEST(FilmOrientation, ADataStripLeavesTheTwoWaysThatMirrorItOntoItself) {
  CameraFile camera = SmallCamera();
  camera.data_strip = FrameSide::kLeft;
  for (const ScanOrientation orientation : {ScanOrientation::kR180, ScanOrientation::kM90}) {
    FilmFrameSpec spec = Spec(camera, orientation);
    spec.polarity = Polarity::kNegative;
    const auto possible = DecisionOn(spec, camera).possible;
    EXPECT_EQ(possible.size(), 2u);
    EXPECT_TRUE(Holds(possible, orientation));
  }
}

TEST(FilmOrientation, WritingAtOneEndOfASideTellsAllEightWays) {
  CameraFile camera = SmallCamera();
  camera.border = {{BorderSign::kText, {-25, -12}, {-21, -2}}};
  for (const ScanOrientation orientation : {ScanOrientation::kR90, ScanOrientation::kM180})
    ExpectDecided(camera, orientation);
}

TEST(FilmOrientation, ANotchOfTheFrameTellsIt) {
  CameraFile dark = SmallCamera(), bright = SmallCamera();
  dark.border = {{BorderSign::kDark, {7, 15}, {12, 20}}};
  bright.border = {{BorderSign::kBright, {7, 20}, {12, 23}}};
  ExpectDecided(dark, ScanOrientation::kM270);
  ExpectDecided(bright, ScanOrientation::kM270, Polarity::kNegative);
}

TEST(FilmOrientation, WritingThatTheCameraFileDoesNotNameDecidesNothing) {
  CameraFile drawn = SmallCamera();
  drawn.data_strip = FrameSide::kTop;
  const FilmFrameSpec spec = Spec(drawn, ScanOrientation::kR90);
  EXPECT_EQ(DecisionOn(spec, SmallCamera()).possible.size(), 8u);
}

TEST(FilmOrientation, WhatIsNotOnTheFilmLeavesItOpen) {
  CameraFile strip = SmallCamera(), notch = SmallCamera();
  strip.data_strip = FrameSide::kLeft;
  notch.border = {{BorderSign::kBright, {7, 20}, {12, 23}}};
  const FilmFrameSpec spec = Spec(SmallCamera(), ScanOrientation::kR90);
  for (const CameraFile& camera : {NumberedCamera(true), NumberedCamera(false), strip, notch}) {
    const OrientationDecision decision = DecisionOn(spec, camera);
    EXPECT_EQ(decision.possible.size(), 8u);
    EXPECT_FALSE(decision.contradictory);
  }
}

TEST(FilmOrientation, ContradictingSymbolsLeaveItOpenAndSaySo) {
  CameraFile wrong = NumberedCamera(false);
  std::swap(wrong.fiducials[0].symbol, wrong.fiducials[1].symbol);
  std::swap(wrong.fiducials[0].symbol, wrong.fiducials[2].symbol);  // no scan orientation does that
  const FilmFrame frame = RenderFilmFrame(Spec(NumberedCamera(false), ScanOrientation::kR0));
  const InteriorResult result = Orient(frame, wrong);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_EQ(result.possible_orientations.size(), 8u);
  ASSERT_FALSE(result.findings.empty());
  EXPECT_NE(Sentence(result.findings.at(0)).find("contradict"), std::string::npos);
}

// Marks with symbols whose places are not told; on the film, mark 3 has six lines.
TEST(FilmOrientation, ASymbolClearlyReadThatNoWayOfLyingHasLeavesItOpenAndIsNamed) {
  const CameraFile camera = NumberedCamera(false);
  CameraFile drawn = camera;
  drawn.fiducials[2].symbol->count = 6;
  const InteriorResult result = Orient(RenderFilmFrame(Spec(drawn, ScanOrientation::kR0)), camera);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_FALSE(result.orientation);
  EXPECT_EQ(result.possible_orientations.size(), 8u);
  EXPECT_TRUE(Has(result.findings, Reason::kSignsContradictory));
  const std::string said = JoinedSentences(result.findings);
  EXPECT_NE(said.find("the symbol of mark "), std::string::npos) << said;
}

TEST(FilmOrientation, TheUsersWordIsDoubtedWhereTheSymbolsSayOtherwise) {
  const CameraFile camera = NumberedCamera(true);
  const FilmFrame frame = RenderFilmFrame(Spec(camera, ScanOrientation::kR90));
  const InteriorResult right = Orient(frame, camera, ScanOrientation::kR90);
  EXPECT_EQ(right.status, Status::kOk);
  const InteriorResult wrong = Orient(frame, camera, ScanOrientation::kM0);
  EXPECT_EQ(wrong.status, Status::kWeak);
  EXPECT_EQ(wrong.orientation, ScanOrientation::kM0);
  EXPECT_NE(Sentence(wrong.findings.back()).find("r90"), std::string::npos);
}

TEST(Decide, WithoutVotesAllStayOpenInTheirOrder) {
  const OrientationClass open(kAllScanOrientations.begin(), kAllScanOrientations.end());
  EXPECT_EQ(Decide(open, {}).possible, open);
  EXPECT_EQ(Decide(open, {{std::vector<double>(8, 0.0)}}).possible, open);
}

TEST(Decide, OneVoteShortOfSureExcludesNothing) {
  const OrientationClass open = {ScanOrientation::kR0, ScanOrientation::kR180};
  const OrientationDecision unsure = Decide(open, {{{0, kSureNats - 0.1}}});
  EXPECT_EQ(unsure.possible, (OrientationClass{ScanOrientation::kR180, ScanOrientation::kR0}));
  EXPECT_EQ(Decide(open, {{{0, kSureNats + 0.1}}}).possible,
            OrientationClass{ScanOrientation::kR180});
}

TEST(Decide, OneOfFourVotesAgainstIsAContradictionOneUnclearOfFiveIsNamedOnly) {
  const OrientationClass open = {ScanOrientation::kR0, ScanOrientation::kR180};
  std::vector<OrientationVote> votes(3, {{3, -3}});
  votes.push_back({{-1.8, 1.8}});
  EXPECT_TRUE(Decide(open, votes).contradictory);
  EXPECT_EQ(Decide(open, votes).possible, open);
  votes.push_back({{3, -3}});
  EXPECT_FALSE(Decide(open, votes).contradictory);
  EXPECT_EQ(Decide(open, votes).possible, OrientationClass{ScanOrientation::kR0});
  EXPECT_EQ(Decide(open, votes).dissenting, std::vector<size_t>{3});
}

TEST(Decide, SevenVotesOutvoteOneClearlyReadWhichIsNamedFewerLeaveItOpen) {
  const OrientationClass open = {ScanOrientation::kR0, ScanOrientation::kR180};
  for (const OrientationVote& clear : {OrientationVote{{-3, 3}}, OrientationVote{{-2, 2}},
                                       OrientationVote{{0, 0}, std::nullopt, true}}) {
    for (const size_t others : {6, 7}) {
      std::vector<OrientationVote> votes(others, {{3, -3}});
      votes.insert(votes.begin() + 4, clear);
      const OrientationDecision decision = Decide(open, votes);
      EXPECT_EQ(decision.contradictory, others < 7);
      EXPECT_EQ(decision.possible, others < 7 ? open : OrientationClass{ScanOrientation::kR0});
      EXPECT_EQ(decision.dissenting, std::vector<size_t>{4});
    }
  }
}

TEST(Decide, TwoClearVotesOfNineLeaveItOpen) {
  const OrientationClass open = {ScanOrientation::kR0, ScanOrientation::kR180};
  std::vector<OrientationVote> votes(7, {{3, -3}});
  votes.insert(votes.end(), 2, {{-3, 3}});
  EXPECT_TRUE(Decide(open, votes).contradictory);
}

TEST(AddRivals, PutsWhatIsLessThanFiveNatsAwayWhereItBelongs) {
  using enum ScanOrientation;
  OrientationDecision decision;
  decision.possible = {kR0, kM0};
  decision.nats = {0, -2};
  AddRivals({{kR90, 1}, {kR180, 5}, {kR270, 4.9}}, &decision);
  EXPECT_EQ(decision.possible, (std::vector<ScanOrientation>{kR0, kR90, kM0, kR270}));
  EXPECT_EQ(decision.nats, (std::vector<double>{0, -1, -2, -4.9}));
}

TEST(Decide, NeverExcludesTheWayThatEveryVoteLikesBest) {
  EXPECT_TRUE(rc::check([](const std::vector<std::array<std::uint8_t, 4>>& raw) {
    const OrientationClass open = {ScanOrientation::kR0, ScanOrientation::kR90,
                                   ScanOrientation::kR180, ScanOrientation::kR270};
    std::vector<OrientationVote> votes;
    for (const auto& bytes : raw) {
      OrientationVote vote;
      for (const std::uint8_t b : bytes) vote.nats.push_back(b % 7 - 3.0);
      vote.nats[2] = 3;
      votes.push_back(vote);
    }
    RC_ASSERT(Holds(Decide(open, votes).possible, ScanOrientation::kR180));
  }));
}

}  // namespace
}  // namespace orient::interior

#include "interior/constellation/clicked_film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/base/error.h"
#include "interior/interior.h"
#include "tests/support/expect_error.h"
#include "tests/support/film_frame.h"
#include "tests/support/scan_making.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kPixel_mm = 0.1;
constexpr double kRight_px = 1;

// A small film, some of whose marks are missing, on disk as a scan is.
class ClickedFilm : public testing::Test {
 protected:
  void Make(const std::vector<int>& missing = {}, unsigned seed = 7) {
    FilmFrameSpec spec;
    spec.camera = camera_;
    spec.pixel_mm = kPixel_mm;
    spec.turn_rad = 0.01;
    spec.shift_px = {9, -6};
    spec.missing = missing;
    spec.seed = seed;
    frame_ = RenderFilmFrame(spec);
    WriteTiffScan(folder_ / "scan.tif", frame_.scan, {.dpi = Vector2d::Constant(25.4 / kPixel_mm)});
  }
  MarkClick Click(std::size_t mark, const Vector2d& off_px = Vector2d::Zero()) const {
    return {camera_.fiducials[mark].id, frame_.mark_pixels[mark] + off_px, 1};
  }
  InteriorResult Orient(const std::vector<MarkClick>& clicks,
                        std::optional<Polarity> polarity = {}) const {
    InteriorOptions options;
    options.clicks = clicks;
    options.polarity = polarity;
    return OrientInterior(Raster::Open(folder_ / "scan.tif"), camera_, ShapesOf(camera_), options);
  }
  // Largest error of the transform at the marks, pixels, in the best of the possible scan
  // orientations.
  double Error(const InteriorResult& result) const {
    double least = 1e9;
    for (const ScanOrientation orientation : result.possible_orientations) {
      const auto turned = InOrientation(result, camera_, ShapesOf(camera_), orientation);
      const Affine2d pixel_from_photo = turned.value().photo_from_pixel.value().Inverse();
      double largest = 0;
      for (std::size_t i = 0; i < camera_.fiducials.size(); ++i)
        largest = std::max(
            largest,
            (pixel_from_photo * camera_.fiducials[i].position_mm - frame_.mark_pixels[i]).norm());
      least = std::min(least, largest);
    }
    return least;
  }
  static std::string Named(const InteriorResult& result, Reason reason) {
    for (const Finding& finding : result.findings)
      if (finding.reason == reason) return finding.where;
    return "";
  }
  // The clicks that are told for wrong, whatever the reason.
  static std::string Wrong(const InteriorResult& result) {
    return Named(result, Reason::kClickOffMark) + Named(result, Reason::kClickContradicted) +
           Named(result, Reason::kClickNotSeen);
  }

  CameraFile camera_ = RingCamera(30, 70);
  FilmFrame frame_;
  TemporaryFolder folder_;
};

TEST_F(ClickedFilm, TwoClicksShowTheOthersAndTheScanOrientation) {
  Make();
  const InteriorResult result = Orient({Click(0, {1, -1}), Click(1, {-1, 1})});
  EXPECT_EQ(result.status, Status::kOk);
  EXPECT_EQ(result.orientation, ScanOrientation::kR0);
  EXPECT_LT(Error(result), kRight_px);
  EXPECT_EQ(Wrong(result), "");
}

TEST_F(ClickedFilm, OneClickDoesWhereThePixelSizeIsKnown) {
  Make();
  const InteriorResult result = Orient({Click(2)});
  EXPECT_EQ(result.status, Status::kOk);
  EXPECT_LT(Error(result), kRight_px);
}

TEST_F(ClickedFilm, AWronglyStatedPolarityIsToldAndNeverOk) {
  Make();
  const std::vector<MarkClick> clicks = {Click(0, {1, -1}), Click(1, {-1, 1})};
  const InteriorResult right = Orient(clicks, Polarity::kPositive);
  EXPECT_EQ(right.status, Status::kOk) << JoinedSentences(right.findings);
  const InteriorResult wrong = Orient(clicks, Polarity::kNegative);
  EXPECT_NE(wrong.status, Status::kOk);
  EXPECT_EQ(Named(wrong, Reason::kPolarityUnlikeMarks), "positive");
}

TEST_F(ClickedFilm, ThreeMarksWithAClickOnTheFourthAreWeak) {
  Make({3});
  MarkClick lost = Click(3);
  lost.exact = true;
  const InteriorResult result = Orient({Click(0), Click(1), Click(2), lost});
  EXPECT_EQ(result.status, Status::kWeak);
  EXPECT_LT(Error(result), 2 * kRight_px);
  EXPECT_EQ(result.marks[3].state, MarkState::kUsed);
  EXPECT_EQ(*result.marks[3].pixel, lost.pixel);
  EXPECT_TRUE(Has(result.findings, Reason::kExactClicks));
}

TEST_F(ClickedFilm, AClickWhereNothingIsSeenIsNoMark) {
  Make({3});
  const InteriorResult result = Orient({Click(0), Click(1), Click(2), Click(3)});
  EXPECT_NE(result.status, Status::kOk);
  EXPECT_EQ(Wrong(result), "4");
}

TEST_F(ClickedFilm, AnExactClickFarOffIsContradicted) {
  Make();
  MarkClick wrong = Click(1, {30, 0});
  wrong.exact = true;
  const InteriorResult result = Orient({Click(0), wrong, Click(2), Click(3)});
  if (result.photo_from_pixel) {
    EXPECT_LT(Error(result), kRight_px);
  }
  EXPECT_NE(Wrong(result).find('2'), std::string::npos);
}

TEST_F(ClickedFilm, AnExactClickFarOffOnAMarkThatNothingShowsIsContradictedToo) {
  Make({3});
  MarkClick wrong = Click(3, {60, 0});
  wrong.exact = true;
  const InteriorResult result = Orient({Click(0), Click(1), Click(2), wrong});
  EXPECT_NE(Wrong(result).find('4'), std::string::npos);
  for (const MarkResult& mark : result.marks)
    EXPECT_FALSE(mark.id == "4" && mark.state == MarkState::kUsed);
}

TEST_F(ClickedFilm, AMarkThatTheCameraDoesNotHaveIsAnError) {
  Make();
  MarkClick unknown = Click(0);
  unknown.mark = "X";
  ExpectError<InputError>([&] { Orient({unknown}); }, {"mark X", "no mark of this name"});
}

// All four marks are clicked, one of them 3 mm off, or two confused: what is accepted is right, and
// the wrong ones are named.
void ExpectNamed(int trials, const std::function<void(unsigned)>& make,
                 const std::function<MarkClick(std::size_t, Vector2d)>& click,
                 const std::function<InteriorResult(const std::vector<MarkClick>&)>& orient,
                 const std::function<double(const InteriorResult&)>& error,
                 const std::function<std::string(const InteriorResult&)>& wrong) {
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937 random(static_cast<unsigned>(trial));
    if (trial % 20 == 0) make(static_cast<unsigned>(trial));
    const std::size_t i = random() % 4, j = (i + 1 + random() % 3) % 4;
    const double angle = 0.001 * static_cast<double>(random() % 6283);
    const Vector2d off = 3 / kPixel_mm * Vector2d(std::cos(angle), std::sin(angle));
    const bool confused = trial % 2 == 1;
    std::vector<MarkClick> clicks;
    for (std::size_t k = 0; k < 4; ++k)
      clicks.push_back(click(k, k == i && !confused ? off : Vector2d::Zero()));
    if (confused) std::swap(clicks[i].pixel, clicks[j].pixel);
    const InteriorResult result = orient(clicks);
    const std::string named = wrong(result);
    EXPECT_NE(named.find(clicks[i].mark), std::string::npos) << trial << ": " << named;
    if (confused) {
      EXPECT_NE(named.find(clicks[j].mark), std::string::npos) << trial << ": " << named;
    }
    if (result.status == Status::kOk) {
      EXPECT_LT(error(result), kRight_px) << trial;
    }
  }
}

class SlowClickedFilm : public ClickedFilm {};

TEST_F(ClickedFilm, WrongClicksAreNamedAndNotAccepted) {
  ExpectNamed(
      4, [&](unsigned seed) { Make({}, seed + 1); },
      [&](std::size_t k, const Vector2d& off) { return Click(k, off); },
      [&](const auto& clicks) { return Orient(clicks); },
      [&](const auto& result) { return Error(result); },
      [&](const auto& result) { return Wrong(result); });
}

TEST_F(SlowClickedFilm, WrongClicksAreNamedInTwoHundredOfTwoHundred) {
  ExpectNamed(
      200, [&](unsigned seed) { Make({}, seed + 1); },
      [&](std::size_t k, const Vector2d& off) { return Click(k, off); },
      [&](const auto& clicks) { return Orient(clicks); },
      [&](const auto& result) { return Error(result); },
      [&](const auto& result) { return Wrong(result); });
}

}  // namespace
}  // namespace orient::interior

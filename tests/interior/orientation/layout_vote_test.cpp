// Films whose marks are calibrated off a layout that looks the same in all eight ways.
#include "interior/orientation/layout_vote.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "interior/interior.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kPixelMm = 0.1;

// Eight marks at corners and sides, each coordinate off by a normal deviate.
CameraFile CalibratedCamera(double side_mm, double frame_mm, double departure_mm, unsigned seed) {
  CameraFile camera = RingCamera(side_mm, frame_mm);
  const std::vector<Vector2d> sides = {{side_mm, 0}, {0, side_mm}, {-side_mm, 0}, {0, -side_mm}};
  for (const Vector2d& at : sides)
    camera.fiducials.push_back({std::to_string(camera.fiducials.size() + 1), at,
                                camera.fiducials.front().mark, std::nullopt});
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (Fiducial& f : camera.fiducials)
    f.position_mm += departure_mm * Vector2d(normal(random), normal(random));
  return camera;
}

class CalibratedLayout : public testing::Test {
 protected:
  CalibratedLayout() {
    FilmFrameSpec spec;
    spec.camera = camera_;
    spec.pixel_mm = kPixelMm;
    spec.orientation = ScanOrientation::kR90;
    spec.turn_rad = 0.01;
    spec.noise = 2;
    WriteScan(folder_ / "scan.png", RenderFilmFrame(spec).scan);
  }
  InteriorResult Orient(std::optional<ScanOrientation> orientation,
                        std::optional<Scanner> scanner = std::nullopt) {
    const InteriorOptions options{1e3 * kPixelMm, std::nullopt, orientation, scanner, std::nullopt};
    return OrientInterior(Raster::Open(folder_ / "scan.png"), camera_, ShapesOf(camera_), options);
  }
  static void ExpectRight(const InteriorResult& result) {
    ASSERT_EQ(result.status, Status::kOk) << Sentence(result.findings.at(0));
    EXPECT_EQ(result.orientation, ScanOrientation::kR90);
    EXPECT_LT(*result.sigma0_um, 10);
    for (const MarkResult& mark : result.marks) EXPECT_EQ(mark.state, MarkState::kUsed) << mark.id;
    EXPECT_TRUE(result.findings.empty()) << Sentence(result.findings.at(0));
  }
  CameraFile camera_ = CalibratedCamera(30, 70, 0.07, 4);
  TemporaryFolder folder_;
};

TEST_F(CalibratedLayout, TellsTheOrientationAndIsJudgedInIt) { ExpectRight(Orient(std::nullopt)); }

TEST_F(CalibratedLayout, TellsTheOrientationOfAPhotogrammetricScan) {
  ExpectRight(Orient(std::nullopt, Scanner::kPhotogrammetric));
}

TEST_F(CalibratedLayout, OfPositionsNoBetterThanItsDeparturesLeavesTheOrientationOpen) {
  for (Fiducial& f : camera_.fiducials) f.sigma_mm = Vector2d(0.4, 0.4);
  const InteriorResult result = Orient(std::nullopt);
  EXPECT_EQ(result.status, Status::kOk);
  EXPECT_FALSE(result.orientation);
  EXPECT_EQ(result.possible_orientations.size(), kAllScanOrientations.size());
}

TEST_F(CalibratedLayout, ContradictsAWrongOrientationThatIsGiven) {
  const InteriorResult wrong = Orient(ScanOrientation::kR0);
  EXPECT_EQ(wrong.status, Status::kWeak);
  EXPECT_EQ(wrong.findings.back().reason, Reason::kOrientationUnlikeLayout);
  EXPECT_EQ(wrong.findings.back().where, "r90, not r0");
  EXPECT_EQ(wrong.orientation, ScanOrientation::kR0);
  ExpectRight(Orient(ScanOrientation::kR90));
}

// Measured marks of a film that lies r90, as a reading that took it to lie r0 has them.
struct Film {
  FilmReading reading;
  FilmMarks marks;
};

Film MakeFilm(const CameraFile& camera, double scatter_mm, std::mt19937* random) {
  std::normal_distribution<double> normal;
  const std::vector<int> relabel =
      RelabelAlike(camera.fiducials, ScanOrientation::kR0, ScanOrientation::kR90);
  const MarkRectangle rectangle = RectangleOfMarks(camera.fiducials);
  // A desktop scanner's two scales say nothing.
  Eigen::Matrix2d film = (1 + 0.003 * normal(*random)) * Eigen::Matrix2d::Identity();
  film(0, 0) *= 1 + 0.008 * normal(*random);
  Film result;
  result.reading.pixel_size = {kPixelMm, 0.008};
  result.reading.orientations.assign(kAllScanOrientations.begin(), kAllScanOrientations.end());
  result.reading.prior = PriorOf(Scanner::kDesktop, result.reading.pixel_size, {5, 5}, 0.06);
  for (size_t i = 0; i < camera.fiducials.size(); ++i) {
    const Vector2d scatter = scatter_mm * Vector2d(normal(*random), normal(*random));
    const Vector2d at = film * PlaceOnScan(camera.fiducials[relabel[i]].position_mm, rectangle,
                                           ScanOrientation::kR90) +
                        scatter;
    result.reading.marks.push_back(
        {PlaceOnScan(camera.fiducials[i].position_mm, rectangle, ScanOrientation::kR0), {}, 100});
    FilmMark mark;
    mark.state = MarkState::kUsed;
    mark.position = MarkPosition();
    mark.position->pixel = at / kPixelMm;
    mark.position->covariance = 1e-4 * Eigen::Matrix2d::Identity();
    result.marks.push_back(mark);
  }
  return result;
}

struct Tally {
  double decided = 0;   // r90 and nothing else is left
  double excluded = 0;  // r90 is not left
};

Tally Decisions(double departure_mm, double scatter_mm, int trials) {
  std::mt19937 random(TestSeed());
  Tally tally;
  for (int i = 0; i < trials; ++i) {
    const CameraFile camera =
        CalibratedCamera(106, 230, departure_mm, static_cast<unsigned>(random()));
    const Film film = MakeFilm(camera, scatter_mm, &random);
    const OrientationClass& open = film.reading.orientations;
    const auto possible =
        Decide(open, {VoteOfLayout(camera, film.reading, film.marks, open, std::nullopt)}).possible;
    const bool holds =
        std::find(possible.begin(), possible.end(), ScanOrientation::kR90) != possible.end();
    tally.excluded += holds ? 0 : 1.0 / trials;
    tally.decided += holds && possible.size() == 1 ? 1.0 / trials : 0;
  }
  std::printf("departure %.3f mm, scatter %.3f mm: decided %.3f, truth excluded %.4f\n",
              departure_mm, scatter_mm, tally.decided, tally.excluded);
  return tally;
}

void ExpectHonestVotes(int trials) {
  for (const double scatter_mm : {0.005, 0.02, 0.04, 0.1})
    for (const double departure_mm : {0.005, 0.02, 0.07})
      EXPECT_LE(Decisions(departure_mm, scatter_mm, trials).excluded, 0.02);
  EXPECT_GE(Decisions(0.07, 0.01, trials).decided, 0.9);
  EXPECT_EQ(Decisions(0, 0.01, trials).decided, 0);
}
TEST(VoteOfLayout, RarelyExcludesTheTruth) { ExpectHonestVotes(300); }
TEST(SlowVoteOfLayout, RarelyExcludesTheTruth) { ExpectHonestVotes(3000); }

}  // namespace
}  // namespace orient::interior

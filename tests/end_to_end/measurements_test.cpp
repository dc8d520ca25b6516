// What a person measured in the four real NGI frames: two of them are oriented from four clicks
// each, with patches and without. What a person says of scans, through the program.
#include "core/measurements/measurements.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <random>

#include "core/terrain/photo_view.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/end_to_end/spoilt_block.h"
#include "tests/support/film_frame.h"
#include "tests/support/ngi.h"
#include "tests/support/run_orient.h"
#include "tests/support/scan_making.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kClick_px = 0.7;
const std::vector<std::string> kClicked = {"0251", "0253"};

class ClickedNgi : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = SharedData("ngi");
    if (!folder) GTEST_SKIP() << "real data absent (ORIENT_SHARED_DATA): ngi";
    ngi_ = std::make_unique<Ngi>(*folder);
    Run({"patchdb", "create", Database(), "--crs", ngi_->CrsFile()});
  }

  static void Run(const std::vector<std::string>& words) {
    const ProgramRun done = RunOrient(words);
    ASSERT_EQ(done.exit_code, 0) << done.err;
  }

  std::string Database() const { return folder_ / "patches.gpkg"; }

  // Patches of the other strip's orthophotos.
  void Harvest() const {
    Run({"patchdb", "harvest-ortho", Database(), "--dem", ngi_->folder + "/dem.tif", "--ortho",
         ngi_->Orthophoto("0182"), ngi_->Orthophoto("0184")});
  }

  // Four clicks near each frame's corners, with errors of a hand, on ground points read from the
  // DEM.
  Measurements Clicks() const {
    Measurements measurements;
    std::mt19937 random(5);
    std::normal_distribution<double> hand(0, kClick_px);
    for (const std::string& number : kClicked) {
      const PhotoView view{ngi_->camera.camera, DigitalPhotoFromPixel(ngi_->camera.camera),
                           ngi_->Published(number).pose};
      int count = 0;
      for (const double col : {90.0, 550.0})
        for (const double row : {120.0, 1030.0}) {
          const Eigen::Vector2d pixel(col, row);
          const std::string name = number + "_" + std::to_string(++count);
          measurements.points.push_back({name, view.GroundFromPixel(pixel, ngi_->surface).value(),
                                         Eigen::Vector3d(3, 3, 3), PointRole::kControl});
          measurements.image_points.push_back({ngi_->Published(number).photo, name,
                                               pixel + Eigen::Vector2d(hand(random), hand(random)),
                                               std::nullopt, kClick_px});
        }
    }
    return measurements;
  }

  ProgramRun Exterior(const Measurements& measurements,
                      const std::string& more = "--overwrite") const {
    WriteImagePoints(folder_.Path(), measurements.image_points);
    WritePoints(folder_.Path(), measurements.points);
    if (!measurements.decisions.empty()) WriteDecisions(folder_.Path(), measurements.decisions);
    std::vector<std::string> words = {"exterior"};
    for (const std::string& number : kClicked) words.push_back(ngi_->Photo(number));
    words.insert(words.end(), {"--camera", ngi_->folder + "/camera.toml", "--measurements",
                               folder_.Path(), "--dem", ngi_->folder + "/dem.tif", "--patchdb",
                               Database(), "--out", folder_ / "out", "--no-feedback", more});
    return RunOrient(words);
  }
  ExteriorResult Result(const std::string& number) const {
    return ReadExteriorResult(ExteriorResultPath(folder_ / "out", ngi_->Published(number).photo));
  }

  std::unique_ptr<Ngi> ngi_;
  TemporaryFolder folder_;
};

TEST_F(ClickedNgi, WithoutPatchesFourClicksGiveAWeakPoseWithinThreePixels) {
  const ProgramRun run = Exterior(Clicks());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const std::string& number : kClicked) {
    const ExteriorResult result = Result(number);
    EXPECT_EQ(result.status, Status::kWeak);
    EXPECT_TRUE(Has(result.findings, Reason::kByPointsAlone));
    ASSERT_TRUE(result.pose);
    std::cout << number << " by four clicks: " << ngi_->FrameRms(result) << " px\n";
    EXPECT_LT(ngi_->FrameRms(result), 3);
  }
}

TEST_F(ClickedNgi, ADecisionRedoesItsPhotoAlone) {
  Measurements measurements = Clicks();
  Exterior(measurements);
  const ExteriorResult before = Result(kClicked[1]);
  measurements.decisions = {{ngi_->Published(kClicked[0]).photo,
                             DecisionKind::kAccept,
                             "",
                             "looked at",
                             {"J. Smith", "2024-05-01"}}};
  const ProgramRun run = Exterior(measurements, "--resume");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const ExteriorResult accepted = Result(kClicked[0]);
  EXPECT_EQ(accepted.status, Status::kOk);
  ASSERT_TRUE(Has(accepted.findings, Reason::kAcceptedByPerson));
  EXPECT_NE(JoinedSentences(accepted.findings).find("J. Smith, 2024-05-01: looked at"),
            std::string::npos);
  EXPECT_EQ(Result(kClicked[1]).made_from, before.made_from);
  EXPECT_EQ(Result(kClicked[1]).status, Status::kWeak);
  measurements.decisions[0].kind = DecisionKind::kReject;
  EXPECT_EQ(Exterior(measurements, "--resume").exit_code, 3);
  EXPECT_EQ(Result(kClicked[0]).status, Status::kFailed);
  EXPECT_FALSE(Result(kClicked[0]).pose);
}

class SlowClickedNgi : public ClickedNgi {};

TEST_F(SlowClickedNgi, ThePatchesFinishWhatFourClicksBegan) {
  Harvest();
  const ProgramRun run = Exterior(Clicks());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const std::string& number : kClicked) {
    const ExteriorResult result = Result(number);
    ASSERT_NE(result.status, Status::kFailed) << JoinedSentences(result.findings);
    EXPECT_TRUE(Has(result.findings, Reason::kStartedByPoints));
    EXPECT_FALSE(Has(result.findings, Reason::kPointsOffPose));
    std::cout << number << " by patches after four clicks: " << ngi_->FrameRms(result) << " px\n";
    EXPECT_LT(ngi_->FrameRms(result), 0.6);
  }
}

// The other two photos have approximations, these two nothing but the clicks.
TEST_F(SlowClickedNgi, ABlockTakesPhotosFromFourClicksToItsUsualFigures) {
  Harvest();
  const Measurements measurements = Clicks();
  WriteImagePoints(folder_.Path(), measurements.image_points);
  WritePoints(folder_.Path(), measurements.points);
  OrientationTable known = ngi_->published;
  std::erase_if(known.rows, [&](const OrientationRow& row) {
    return row.photo == ngi_->Published("0251").photo || row.photo == ngi_->Published("0253").photo;
  });
  for (OrientationRow& row : known.rows) row.pose.position_m += Eigen::Vector3d(8, -9, 6);
  WriteOrientationTable(folder_ / "approx.csv", known);
  std::ofstream(folder_ / "block.toml")
      << "crs = \"+proj=tmerc +lat_0=0 +lon_0=25 +datum=WGS84 +units=m\"\ncamera = \""
      << ngi_->folder << "/camera.toml\"\ndem = \"" << ngi_->folder
      << "/dem.tif\"\npatchdb = \"patches.gpkg\"\nphotos = [\"" << ngi_->folder
      << "/photos/*.tif\"]\napproximations = \"approx.csv\"\nmeasurements = \".\"\n";
  const ProgramRun run = RunOrient({"block", folder_ / "block.toml", "--no-feedback"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("control"), std::string::npos);
  for (const std::string& number : kClicked) {
    const ExteriorResult result = Result(number);
    EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
    std::cout << number << " in the block: " << ngi_->FrameRms(result) << " px\n";
    EXPECT_LT(ngi_->FrameRms(result), 0.6);
  }
}

TEST_F(ClickedNgi, AWrongClickIsNamedAndDoesNotMoveThePhoto) {
  Measurements measurements = Clicks();
  const std::string photo = ngi_->Published("0251").photo;
  const PhotoView view{ngi_->camera.camera, DigitalPhotoFromPixel(ngi_->camera.camera),
                       ngi_->Published("0251").pose};
  const Eigen::Vector2d middle(320, 570);
  measurements.points.push_back({"spoilt", view.GroundFromPixel(middle, ngi_->surface).value(),
                                 Eigen::Vector3d(3, 3, 3), PointRole::kControl});
  measurements.image_points.push_back(
      {photo, "spoilt", middle + Eigen::Vector2d(40, 0), std::nullopt, kClick_px});
  Exterior(measurements);
  const ExteriorResult result = Result("0251");
  ASSERT_TRUE(result.pose);
  EXPECT_LT(ngi_->FrameRms(result), 3);
  bool named = false;
  for (const Finding& finding : result.findings)
    if (finding.reason == Reason::kPointsWrong) named = finding.where == "spoilt";
  EXPECT_TRUE(named) << JoinedSentences(result.findings);
}

// Two scans of a small film.
class ClickedScans : public testing::Test {
 protected:
  void SetUp() override {
    FilmFrameSpec spec;
    spec.camera = RingCamera(30, 70);
    WriteCameraFile(Camera(), spec.camera);
    for (const char* name : {"a", "b"}) {
      ++spec.seed;
      frame_ = RenderFilmFrame(spec);
      WriteTiffScan(folder_ / (std::string(name) + ".tif"), frame_.scan,
                    {.dpi = Eigen::Vector2d::Constant(25.4 / spec.pixel_mm)});
    }
  }
  std::string Camera() const { return folder_ / "ring.toml"; }
  ProgramRun Interior(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"interior", folder_ / "a.tif", folder_ / "b.tif", "--camera",
                                      Camera(),   "--out",           folder_ / "out"};
    words.insert(words.end(), more.begin(), more.end());
    return RunOrient(words);
  }
  InteriorResult Result(const std::string& photo) const {
    return ReadInteriorResult(InteriorResultPath(folder_ / "out", photo));
  }

  FilmFrame frame_;  // of b, the last one
  TemporaryFolder folder_;
};

TEST_F(ClickedScans, OnlyThePhotoOfWhichSomethingIsSaidIsDoneAgain) {
  ASSERT_EQ(Interior({}).exit_code, 0);
  const InteriorResult a = Result("a"), b = Result("b");
  EXPECT_FALSE(b.orientation) << "four like marks leave it open";
  WriteMarks(folder_.Path(), {{"b", "1", frame_.mark_pixels[0], 1, false, {}},
                              {"b", "2", frame_.mark_pixels[1], 1, false, {}}});
  const ProgramRun run = Interior({"--resume", "--measurements", folder_.Path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Result("a").made_from, a.made_from);
  EXPECT_NE(Result("b").made_from, b.made_from);
  EXPECT_EQ(Result("b").orientation, ScanOrientation::kR0);
  EXPECT_EQ(Result("b").status, Status::kOk);
}

TEST_F(ClickedScans, ADecisionHoldsForItsPhoto) {
  WriteDecisions(folder_.Path(), {{"a", DecisionKind::kReject, "", "torn", {"J. Smith", ""}},
                                  {"b", DecisionKind::kOrientation, "r180", "", {}}});
  EXPECT_EQ(Interior({"--measurements", folder_.Path()}).exit_code, 3);
  EXPECT_EQ(Result("a").status, Status::kFailed);
  EXPECT_FALSE(Result("a").photo_from_pixel);
  EXPECT_EQ(JoinedSentences({Result("a").findings.front()}), "Rejected by J. Smith: torn.");
  EXPECT_EQ(Result("b").orientation, ScanOrientation::kR180);
}

TEST_F(ClickedScans, ADecisionOnAnotherCameraThanTheRunsIsRefused) {
  WriteDecisions(folder_.Path(), {{"a", DecisionKind::kCamera, "wild_rc10", "", {}}});
  const ProgramRun run = Interior({"--measurements", folder_.Path()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("photo a to camera wild_rc10"), std::string::npos) << run.err;
}

// Five right points in one corner, beside an approximation that is worse than stated: the photo is
// found by its patches as it is without them, where no point says otherwise.
TEST(RightPoints, ThatSayLittleTakeNoPhotoFromItsPatches) {
  const TemporaryFolder folder;
  const std::string block = SoundBlock(true);
  const TruePhoto photo = ReadTruth(block).front();
  OrientationTable table = ReadOrientationTable(block + "/approx.csv");
  for (OrientationRow& row : table.rows) {
    row.sigma.reset();
    row.pose.position_m.x() += 100;
    row.pose.opk_rad.z() += 0.7;
  }
  WriteOrientationTable(folder / "approx.csv", table);
  std::vector<SeenPoint> corner = photo.seen;
  std::sort(corner.begin(), corner.end(), [](const SeenPoint& a, const SeenPoint& b) {
    return a.pixel.squaredNorm() < b.pixel.squaredNorm();
  });
  ASSERT_GE(corner.size(), 5u);
  Measurements points;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::string name = "p" + std::to_string(i);
    points.points.push_back(
        {name, corner[i].ground_m, Eigen::Vector3d::Constant(20), PointRole::kControl});
    points.image_points.push_back({photo.name, name, corner[i].pixel, std::nullopt, 20.0});
  }
  WriteImagePoints(folder.Path(), points.image_points);
  WritePoints(folder.Path(), points.points);
  const auto orient = [&](const std::string& out, std::vector<std::string> more) {
    std::vector<std::string> words = {"exterior",
                                      block + "/scans/" + photo.name + ".tif",
                                      "--camera",
                                      block + "/camera.toml",
                                      "--approximations",
                                      folder / "approx.csv",
                                      "--dem",
                                      block + "/dem.tif",
                                      "--patchdb",
                                      block + "/patches.gpkg",
                                      "--position-sigma-m",
                                      "5",
                                      "--attitude-sigma-deg",
                                      "1",
                                      "--no-feedback",
                                      "--out",
                                      folder / out};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = RunOrient(words);
    EXPECT_LE(run.exit_code, 3) << run.err;
    return ReadExteriorResult(ExteriorResultPath(folder / out, photo.name));
  };
  const ExteriorResult without = orient("without", {});
  const ExteriorResult with = orient("with", {"--measurements", folder.Path()});
  ASSERT_TRUE(without.pose);
  ASSERT_TRUE(with.pose);
  EXPECT_LT((without.pose->position_m - photo.pose.position_m).norm(), 2);
  EXPECT_LT((with.pose->position_m - photo.pose.position_m).norm(), 2);
  EXPECT_LE(with.status, without.status);  // ok comes first
  EXPECT_FALSE(Has(with.findings, Reason::kByPointsAlone));
}

}  // namespace
}  // namespace orient

// A camera made from clicks on one scan orients other scans of the same camera.
#include "block/roll/new_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>

#include "core/base/error.h"
#include "interior/interior.h"
#include "tests/support/expect_error.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

using Eigen::Vector2d;

constexpr double kPixelMm = 0.08;  // coarse: quick to fit

FilmFrameSpec Film(unsigned seed) {
  FilmFrameSpec spec;
  spec.camera = RingCamera(25, 60);
  spec.pixel_mm = kPixelMm;
  spec.seed = seed;
  spec.shift_px = Vector2d(3.0 * seed, 2.0 * seed);
  spec.turn_rad = 0.002 * seed;
  return spec;
}

std::vector<ClickedScan> One(ClickedScan scan) {
  std::vector<ClickedScan> scans;
  scans.push_back(std::move(scan));
  return scans;
}

class NewCameraTest : public testing::Test {
 protected:
  // Clicked up to two pixels beside the marks.
  ClickedScan Clicked(const FilmFrameSpec& spec, const std::string& name) {
    const FilmFrame frame = RenderFilmFrame(spec);
    const std::string path = folder_ / (name + ".png");
    WriteScan(path, frame.scan);
    ClickedScan scan{name, Raster::Open(path), {}};
    std::mt19937 random(spec.seed);
    std::uniform_real_distribution<double> beside(-2, 2);
    for (size_t i = 0; i < frame.mark_pixels.size(); ++i)
      scan.clicks.push_back({spec.camera.fiducials[i].id,
                             frame.mark_pixels[i] + Vector2d(beside(random), beside(random)), 1});
    return scan;
  }

  static NewCameraOptions Options() {
    NewCameraOptions options;
    options.name = "new";
    options.principal_distance_mm = 153;
    options.pixel_size_um = 1e3 * kPixelMm;
    options.photogrammetric = true;
    return options;
  }

  // Another frame, whose marks the new camera finds, all of them and no others.
  void ExpectItReads(const NewCamera& made, const FilmFrameSpec& spec) {
    const FilmFrame frame = RenderFilmFrame(spec);
    const std::string path = folder_ / "other.png";
    WriteScan(path, frame.scan);
    interior::InteriorOptions stated;
    stated.pixel_size_um = 1e3 * kPixelMm;
    const InteriorResult result = interior::OrientInterior(
        Raster::Open(path), made.file, interior::ShapesOf(made.file, made.pictures), stated);
    EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
    for (const MarkResult& mark : result.marks) {
      ASSERT_TRUE(mark.pixel) << mark.id;
      double nearest = 1e9;
      for (const Vector2d& truth : frame.mark_pixels)
        nearest = std::min(nearest, (*mark.pixel - truth).norm());
      EXPECT_LT(nearest, 0.15) << mark.id;
    }
  }

  TemporaryFolder folder_;
};

using SlowNewCameraTest = NewCameraTest;

TEST_F(NewCameraTest, OfOneScanReadsAnother) {
  const NewCamera made = MakeCamera(One(Clicked(Film(1), "first")), Options());
  ASSERT_EQ(made.file.fiducials.size(), 4u);
  EXPECT_EQ(made.file.marks.size(), 1u);  // four marks of one look
  EXPECT_TRUE(made.pictures.empty());
  const CameraFile truth = RingCamera(25, 60);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT((made.file.fiducials[i].position_mm - truth.fiducials[i].position_mm).norm(), 0.02)
        << i;
    EXPECT_GT(made.marks[i].correlation, 0.9);
  }
  ExpectItReads(made, Film(5));
}

TEST_F(SlowNewCameraTest, WithDistancesNeedsNoPixelSize) {
  NewCameraOptions options = Options();
  options.pixel_size_um.reset();
  options.distances = {{"1", "2", 50 * std::sqrt(2.0)}, {"3", "4", 50 * std::sqrt(2.0)}};
  const NewCamera made = MakeCamera(One(Clicked(Film(2), "first")), options);
  EXPECT_NEAR(made.pixel_size_um, 1e3 * kPixelMm, 0.3);  // by the clicks
  for (const double residual : made.distance_residual_mm) EXPECT_LT(std::abs(residual), 0.01);
}

TEST_F(SlowNewCameraTest, WithStatedPositionsReadsAScanThatLiesOtherwise) {
  FilmFrameSpec spec = Film(3);
  spec.orientation = ScanOrientation::kM90;
  NewCameraOptions options = Options();
  options.pixel_size_um.reset();
  for (const Fiducial& f : spec.camera.fiducials)
    options.positions.push_back({f.id, f.position_mm});
  ExpectError<InputError>([&] { MakeCamera(One(Clicked(spec, "first")), options); },
                          {"mirrored", "--orientation m0"});
  options.orientation = ScanOrientation::kM0;  // that it is mirrored; the positions tell the rest
  const NewCamera made = MakeCamera(One(Clicked(spec, "first")), options);
  EXPECT_NEAR(made.pixel_size_um, 1e3 * kPixelMm, 0.3);
  EXPECT_EQ(made.file.fiducials[0].position_mm, spec.camera.fiducials[0].position_mm);
  ExpectItReads(made, Film(4));
}

TEST_F(SlowNewCameraTest, OfANegativeDrawsWhatIsBrightOnThePositive) {
  FilmFrameSpec spec = Film(6);
  spec.polarity = Polarity::kNegative;
  NewCameraOptions options = Options();
  options.polarity = Polarity::kNegative;
  const NewCamera made = MakeCamera(One(Clicked(spec, "first")), options);
  ASSERT_EQ(made.file.marks.size(), 1u);
  for (const MarkElement& element : made.file.marks.begin()->second.elements)
    EXPECT_EQ(BrightnessOf(element), 1);
}

TEST_F(NewCameraTest, WhatNoDrawingExplainsBecomesAPicture) {
  FilmFrameSpec spec = Film(7);
  std::vector<MarkElement>& scattered = spec.camera.marks["corner"].elements;
  scattered.clear();
  for (const Vector2d& at :
       {Vector2d(-1.2, 0.9), Vector2d(-0.9, -1.1), Vector2d(-0.3, 0.5), Vector2d(0.2, -0.4),
        Vector2d(0.4, 1.2), Vector2d(1.3, 0.1), Vector2d(0.9, -1.3)})
    scattered.push_back(DotElement{0.45, at});
  NewCameraOptions options = Options();
  ClickedScan first = Clicked(spec, "first");
  first.clicks.resize(3);  // all that is needed, and quicker
  const auto scans = One(std::move(first));
  const NewCamera made = MakeCamera(scans, options);
  for (const auto& [name, picture] : made.pictures) {
    EXPECT_TRUE(made.file.marks.at(name).image.has_value()) << name;
    EXPECT_EQ(*std::max_element(picture.values.begin(), picture.values.end()), 255.0f);
  }
  EXPECT_FALSE(made.pictures.empty());
}

TEST_F(NewCameraTest, ConfusedMarksContradictStatedPositions) {
  ClickedScan scan = Clicked(Film(1), "first");
  std::swap(scan.clicks[0].mark, scan.clicks[2].mark);
  NewCameraOptions options = Options();
  for (const Fiducial& f : RingCamera(25, 60).fiducials)
    options.positions.push_back({f.id, f.position_mm});
  const auto scans = One(std::move(scan));
  ExpectError<InputError>([&] { MakeCamera(scans, options); }, {"first", "contradict", "mark"});
}

TEST_F(NewCameraTest, AMistypedDistanceIsNamed) {
  NewCameraOptions options = Options();
  options.distances = {{"1", "2", 70.71}, {"3", "4", 70.71}, {"1", "3", 40.0}};
  const auto scans = One(Clicked(Film(1), "first"));
  ExpectError<InputError>([&] { MakeCamera(scans, options); }, {"from 1 to 3", "40.000"});
}

TEST_F(NewCameraTest, MarksConfusedOnASecondScanAreNamed) {
  std::vector<ClickedScan> scans = One(Clicked(Film(1), "first"));
  scans.push_back(Clicked(Film(2), "second"));
  std::swap(scans[1].clicks[1].mark, scans[1].clicks[3].mark);
  ExpectError<InputError>([&] { MakeCamera(scans, Options()); }, {"mark", "photo", "confused"});
}

TEST_F(SlowNewCameraTest, ADistanceThatTheScansContradictIsNamed) {
  NewCameraOptions options = Options();
  options.distances = {{"1", "2", 70.711}, {"3", "4", 70.711}, {"1", "3", 51.0}};
  const auto scans = One(Clicked(Film(1), "first"));
  ExpectError<InputError>([&] { MakeCamera(scans, options); }, {"mistyped"});
}

TEST_F(SlowNewCameraTest, ExactClicksAreTheMeasurement) {
  ClickedScan scan = Clicked(Film(1), "first");
  for (interior::MarkClick& click : scan.clicks) click.exact = true;
  const std::vector<interior::MarkClick> clicks = scan.clicks;
  const NewCamera made = MakeCamera(One(std::move(scan)), Options());
  for (size_t i = 0; i < clicks.size(); ++i)
    EXPECT_EQ(made.marks[i].first_place, std::optional(clicks[i].pixel));
}

TEST_F(NewCameraTest, AVagueClickIsRefused) {
  ClickedScan scan = Clicked(Film(1), "first");
  scan.clicks[2].sigma_px = 30000;
  const auto scans = One(std::move(scan));
  ExpectError<InputError>([&] { MakeCamera(scans, Options()); }, {"mark 3", "first", "30000"});
}

TEST_F(NewCameraTest, TwoMarksAtOnePlaceAreNamed) {
  ClickedScan scan = Clicked(Film(1), "first");
  scan.clicks[2].pixel = scan.clicks[0].pixel;
  const auto scans = One(std::move(scan));
  ExpectError<InputError>([&] { MakeCamera(scans, Options()); }, {"marks 1 and 3", "one place"});
}

TEST_F(NewCameraTest, MarksOnOneLineAreRefused) {
  ClickedScan scan = Clicked(Film(1), "first");
  scan.clicks.resize(3);
  scan.clicks[2].pixel = (scan.clicks[0].pixel + scan.clicks[1].pixel) / 2;
  const auto scans = One(std::move(scan));
  ExpectError<InputError>([&] { MakeCamera(scans, Options()); }, {"one line"});
}

// A second scan that lies otherwise shows the same marks.
TEST_F(SlowNewCameraTest, OfScansThatLieDifferentlyHasOneDrawing) {
  std::vector<ClickedScan> scans = One(Clicked(Film(1), "first"));
  FilmFrameSpec turned = Film(2);
  turned.orientation = ScanOrientation::kR90;
  scans.push_back(Clicked(turned, "second"));
  const NewCamera made = MakeCamera(scans, Options());
  EXPECT_EQ(made.file.marks.size(), 1u);
  for (const NewMark& mark : made.marks) {
    EXPECT_EQ(mark.scans, 2);
    EXPECT_GT(mark.correlation, 0.9);
  }
}

TEST_F(NewCameraTest, WithoutAnyScaleSaysWhatToGive) {
  NewCameraOptions options = Options();
  options.pixel_size_um.reset();
  const auto scans = One(Clicked(Film(1), "first"));
  ExpectError<InputError>([&] { MakeCamera(scans, options); }, {"scale", "--pixel-size-um"});
}

TEST_F(NewCameraTest, OfTwoMarksIsRefused) {
  ClickedScan scan = Clicked(Film(1), "first");
  scan.clicks.resize(2);
  const auto scans = One(std::move(scan));
  ExpectError<InputError>([&] { MakeCamera(scans, Options()); }, {"2 marks", "three"});
}

// Marks of a real frame as measured by eye.
std::vector<interior::MarkClick> HandMarks(const std::string& folder, const std::string& frame) {
  std::ifstream file(folder + "/marks.csv");
  std::vector<interior::MarkClick> marks;
  for (std::string line; std::getline(file, line);) {
    std::stringstream cells(line);
    std::string of_frame, name, col, row;
    std::getline(cells, of_frame, ',');
    std::getline(cells, name, ',');
    std::getline(cells, col, ',');
    std::getline(cells, row, ',');
    if (of_frame == frame && !col.empty() && name.size() == 2)  // corners only
      marks.push_back({name, {std::stod(col), std::stod(row)}});
  }
  return marks;
}

// Two frames of one camera (Wild RC10, lens 13043), desktop scans: the first one's corner marks are
// clicked, to whole pixels, the second one's are found.
TEST(NewCameraOfRealFilm, ReadsTheOtherFrameOfTheCamera) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  std::vector<ClickedScan> scans;
  scans.push_back(
      {"0c8e8831", Raster::Open(folder + "/0c8e8831.jpg"), HandMarks(folder, "0c8e8831")});
  ASSERT_EQ(scans[0].clicks.size(), 4u);
  for (interior::MarkClick& click : scans[0].clicks) click.pixel = click.pixel.array().round();
  NewCameraOptions options;
  options.name = "new";
  options.principal_distance_mm = 152.75;
  options.pixel_size_um = 127;
  const NewCamera made = MakeCamera(scans, options);
  interior::InteriorOptions desktop;
  desktop.scanner = interior::Scanner::kDesktop;
  const InteriorResult result =
      interior::OrientInterior(Raster::Open(folder + "/5bdd5cf4.jpg"), made.file,
                               interior::ShapesOf(made.file, made.pictures), desktop);
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  const auto hand = HandMarks(folder, "5bdd5cf4");
  for (const MarkResult& mark : result.marks) {
    ASSERT_TRUE(mark.pixel) << mark.id;
    double nearest = 1e9;
    for (const auto& click : hand) nearest = std::min(nearest, (*mark.pixel - click.pixel).norm());
    EXPECT_LT(nearest, 0.8) << mark.id;
  }
}

}  // namespace
}  // namespace orient::block

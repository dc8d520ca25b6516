// A whole scan of a camera with a réseau.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "core/raster/raster.h"
#include "interior/constellation/film_search.h"
#include "interior/constellation/guided_search.h"
#include "interior/interior.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

// 5 x 5 crosses 13 mm apart on a film of 70 mm, like a small Hasselblad's.
CameraFile CrossCamera() {
  CameraFile file = RingCamera(26, 70);
  file.fiducials.clear();
  file.marks.clear();
  MarkDrawing cross;
  cross.elements = {CrossElement{3, 0.15, 0, 0}};
  cross.background = MarkBackground::kImage;
  file.marks["cross"] = cross;
  for (int row = -2; row <= 2; ++row)
    for (int col = -2; col <= 2; ++col)
      file.fiducials.push_back({std::to_string(file.fiducials.size() + 1),
                                Vector2d(13.0 * col, 13.0 * row), "cross", std::nullopt});
  return file;
}

// Four bare crosses in the picture.
InteriorResult OrientFourCrosses(const CrossElement& cross, Polarity polarity,
                                 Vector2d* first_mark) {
  const TemporaryFolder folder;
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  spec.camera.marks["cross"].elements = {cross};
  const auto all = spec.camera.fiducials;
  spec.camera.fiducials = {all[0], all[4], all[20], all[24]};
  spec.dark_corners = false;
  spec.polarity = polarity;
  const FilmFrame frame = RenderFilmFrame(spec);
  WriteScan(folder / "a.png", frame.scan);
  *first_mark = frame.mark_pixels[0];
  InteriorOptions options;
  options.pixel_size_um = 100;
  options.orientation = ScanOrientation::kR0;
  return OrientInterior(Raster::Open(folder / "a.png"), spec.camera, ShapesOf(spec.camera),
                        options);
}

TEST(BareCrosses, DarkOnesAndThoseBesideTheirMarksCentreAreFound) {
  struct Case {
    double brightness;
    Vector2d at_mm;
    Polarity polarity;
  };
  for (const Case& c :
       {Case{1, {0.7, -0.4}, Polarity::kPositive}, Case{-1, {0, 0}, Polarity::kPositive},
        Case{-1, {0.7, -0.4}, Polarity::kNegative}}) {
    SCOPED_TRACE(std::to_string(c.brightness) + " " + std::to_string(c.at_mm.x()));
    Vector2d truth;
    const InteriorResult result =
        OrientFourCrosses({3, 0.2, 0, 0, c.at_mm, c.brightness}, c.polarity, &truth);
    EXPECT_EQ(result.status, Status::kOk) << Sentence(result.findings.at(0));
    EXPECT_EQ(result.polarity, c.polarity);
    ASSERT_TRUE(result.marks[0].pixel);
    EXPECT_LT((*result.marks[0].pixel - truth).norm(), 0.2);
  }
}

TEST(ReseauPhoto, AnchorsAreTheCornersAndTheMiddlesOfTheSides) {
  EXPECT_EQ(AnchorMarks(CrossCamera().fiducials),
            (std::vector<size_t>{0, 2, 4, 10, 14, 20, 22, 24}));
}

TEST(ReseauPhoto, MeshShiftsCarryMostCrossesIntoOthers) {
  const auto shifts = MeshShifts(CrossCamera().fiducials);
  ASSERT_EQ(shifts.size(), 8u);  // to the next crosses, diagonals included
  for (const Vector2d& shift : shifts) EXPECT_NEAR(shift.cwiseAbs().maxCoeff(), 13, 1e-9);
  auto irregular = CrossCamera().fiducials;
  for (size_t i = 0; i < irregular.size(); ++i)
    irregular[i].position_mm.x() += 0.2 * static_cast<double>(i * i);
  EXPECT_TRUE(MeshShifts(irregular).empty());
}

// The crosses alone, a mesh off, would be a reading of the film.
TEST(ReseauPhoto, MeshShiftsAreThoseOfTheCrossesAmongAsManyFiducialMarks) {
  std::vector<Fiducial> mixed;
  for (const Fiducial& cross : CrossCamera().fiducials)
    if (cross.position_mm.cwiseAbs().maxCoeff() < 20) mixed.push_back(cross);
  ASSERT_EQ(mixed.size(), 9u);
  EXPECT_EQ(MeshShifts(mixed).size(), 4u);  // diagonals carry four of nine crosses only
  for (const Vector2d& at :
       {Vector2d(-31, -30), Vector2d(32, 30), Vector2d(-30, 33), Vector2d(31, -33),
        Vector2d(-30, 1), Vector2d(33, 2), Vector2d(3, 31), Vector2d(1, -30)})
    mixed.push_back({"F" + std::to_string(mixed.size()), at, "corner", std::nullopt});
  const auto shifts = MeshShifts(mixed);
  ASSERT_EQ(shifts.size(), 4u);
  for (const Vector2d& shift : shifts) EXPECT_NEAR(shift.norm(), 13, 1e-9);
}

// A positive film between two negatives on one scan: the second negative is the second set of marks
// of a reading that is itself not the best one.
TEST(ReseauPhoto, EveryReadingsSecondSetOfMarksIsAWayToReadTheFilm) {
  const TemporaryFolder folder;
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  spec.camera.fiducials = {spec.camera.fiducials[0], spec.camera.fiducials[4],
                           spec.camera.fiducials[20], spec.camera.fiducials[24]};
  spec.rebate_mm = 0;  // no bed around the films, which would be looked at one by one
  const Image film = RenderFilmFrame(spec).scan;
  spec.polarity = Polarity::kNegative;
  const Image negative = RenderFilmFrame(spec).scan;
  Image scan(3 * film.width, film.height);
  for (int row = 0; row < film.height; ++row)
    for (int col = 0; col < scan.width; ++col)
      scan.At(col, row) = (col / film.width == 1 ? film : negative).At(col % film.width, row);
  WriteScan(folder / "a.png", scan);
  InteriorOptions options;
  options.pixel_size_um = 100;
  options.orientation = ScanOrientation::kR0;
  options.scanner = Scanner::kPhotogrammetric;
  const auto ways =
      ReadFilmAllWays(Raster::Open(folder / "a.png"), spec.camera, ShapesOf(spec.camera), options);
  const auto found_at = [&](Polarity polarity, double col) {
    return std::any_of(ways.begin(), ways.end(), [&](const FilmReading& way) {
      return way.polarity == polarity && way.best.Matched() == 4 && way.best.nats > 20 &&
             std::abs(way.candidates[0][way.best.choice[0]].pixel.x() - col) < 3;
    });
  };
  EXPECT_TRUE(found_at(Polarity::kPositive, film.width + 90));
  EXPECT_TRUE(found_at(Polarity::kNegative, 90));
  EXPECT_TRUE(found_at(Polarity::kNegative, 2 * film.width + 90));
}

// A scan of this film; `given`, `polarity`: what the run states.
InteriorResult OrientFilm(const FilmFrameSpec& spec, FilmFrame* frame,
                          std::optional<ScanOrientation> given = {},
                          std::optional<Polarity> polarity = {}) {
  const TemporaryFolder folder;
  *frame = RenderFilmFrame(spec);
  WriteScan(folder / "a.png", frame->scan);
  InteriorOptions options;
  options.pixel_size_um = 100;
  options.orientation = given;
  options.polarity = polarity;
  return OrientInterior(Raster::Open(folder / "a.png"), spec.camera, ShapesOf(spec.camera),
                        options);
}

TEST(ReseauPhoto, AWronglyStatedPolarityIsToldAndNeverOk) {
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  FilmFrame frame;
  const auto as = [&](Polarity polarity) {
    return OrientFilm(spec, &frame, ScanOrientation::kR0, polarity);
  };
  const InteriorResult right = as(Polarity::kPositive), wrong = as(Polarity::kNegative);
  EXPECT_EQ(right.status, Status::kOk) << JoinedSentences(right.findings);
  EXPECT_NE(wrong.status, Status::kOk);
  ASSERT_TRUE(Has(wrong.findings, Reason::kPolarityUnlikeMarks)) << JoinedSentences(wrong.findings);
  EXPECT_EQ(wrong.findings.front().where, "positive");
}

InteriorResult OrientWithout(const std::vector<int>& missing, FilmFrame* frame) {
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  spec.missing = missing;
  return OrientFilm(spec, frame, ScanOrientation::kR0);
}

// Without a side's three anchors and one of the opposite side, five anchors fit a film that lies a
// mesh farther on, where the opposite side's three are missing, and four where it is.
TEST(ReseauPhoto, AnchorsAMeshOffAreCorrectedByAllCrosses) {
  FilmFrame frame;
  const InteriorResult result = OrientWithout({0, 10, 14, 20}, &frame);
  ASSERT_EQ(result.status, Status::kOk) << Sentence(result.findings.at(0));
  EXPECT_LT((*result.marks[12].pixel - frame.mark_pixels[12]).norm(), 0.2);
}

// The anchors have their own, larger windows; each cross is looked for in one where they put it.
TEST(ReseauPhoto, AMissingCrossNamesItsWindowAroundItsPlace) {
  FilmFrame frame;
  const InteriorResult result = OrientWithout({0, 7, 24}, &frame);
  ASSERT_EQ(result.status, Status::kOk) << Sentence(result.findings.at(0));
  for (const size_t i : {0, 7, 24}) {
    const MarkResult& mark = result.marks.at(i);
    ASSERT_NE(mark.state, MarkState::kUsed);
    ASSERT_TRUE(mark.window) << mark.id;
    const Vector2d middle(mark.window->col + 0.5 * mark.window->width,
                          mark.window->row + 0.5 * mark.window->height);
    EXPECT_LT((middle - frame.mark_pixels[i]).norm(), 3) << mark.id;
    EXPECT_LT(mark.window->width, 40) << mark.id;
  }
}

TEST(ReseauPhoto, WithoutAWholeRowTheFilmMayLieAMeshOffAndIsNotOk) {
  FilmFrame frame;
  const InteriorResult result = OrientWithout({0, 5, 10, 15, 20}, &frame);
  EXPECT_NE(result.status, Status::kOk);
  EXPECT_LT(result.margin, 3);
}

// Nothing says that the film lies in the middle of a scan that is cut off.
TEST(ReseauPhoto, CutOffWithARowOfCrossesTheFilmMayLieAMeshOffAndIsNotOk) {
  const TemporaryFolder folder;
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  const Image whole = RenderFilmFrame(spec).scan;
  constexpr int kCut = 270;  // the outermost row lies 150 px from the edge, the next one 280
  Image cut(whole.width, whole.height - kCut);
  std::copy(whole.values.begin() + std::ptrdiff_t{kCut} * whole.width, whole.values.end(),
            cut.values.begin());
  WriteScan(folder / "a.png", cut);
  InteriorOptions options;
  options.pixel_size_um = 100;
  options.orientation = ScanOrientation::kR0;
  const InteriorResult result =
      OrientInterior(Raster::Open(folder / "a.png"), spec.camera, ShapesOf(spec.camera), options);
  EXPECT_NE(result.status, Status::kOk);
  EXPECT_LT(result.margin, 3);
}

TEST(ReseauPhoto, CrossesAreFoundAndGiveACorrection) {
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  spec.missing = {7, 13};
  FilmFrame frame;
  const InteriorResult result = OrientFilm(spec, &frame);
  ASSERT_TRUE(result.photo_from_pixel) << Sentence(result.findings.at(0));
  EXPECT_EQ(result.status, Status::kOk) << Sentence(result.findings.at(0));
  ASSERT_TRUE(result.reseau);
  EXPECT_GE(result.reseau->crosses, 20);
  EXPECT_LT(result.reseau->noise_um, 5);
  const Affine2d truth = frame.pixel_from_photo.Inverse();
  for (const Vector2d& pixel : {Vector2d(200, 300), Vector2d(410, 410), Vector2d(600, 180)}) {
    const Vector2d photo =
        PhotoFromPixel(*result.photo_from_pixel, &result.reseau->correction, pixel);
    // The scan of a layout that looks the same when turned may be read in any of those ways.
    EXPECT_NEAR(photo.norm(), (truth * pixel).norm(), 0.005) << "mm";
  }
}

TEST(ReseauPhoto, ACrossThatItsNeighboursContradictIsRejectedWithItsResidual) {
  const TemporaryFolder folder;
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  WriteScan(folder / "a.png", RenderFilmFrame(spec).scan);
  CameraFile mistyped = spec.camera;
  mistyped.fiducials[6].position_mm.x() += 0.06;
  InteriorOptions options;
  options.pixel_size_um = 100;
  options.orientation = ScanOrientation::kR0;
  const InteriorResult result =
      OrientInterior(Raster::Open(folder / "a.png"), mistyped, ShapesOf(mistyped), options);
  ASSERT_TRUE(result.reseau) << Sentence(result.findings.at(0));
  EXPECT_EQ(result.marks[6].state, MarkState::kRejected);
  ASSERT_TRUE(result.marks[6].residual_um);
  EXPECT_NEAR(result.marks[6].residual_um->x(), 60, 10);
  // The affine and sigma0 are those of the used ones alone.
  double squares = 0;
  int used = 0;
  for (const MarkResult& mark : result.marks) {
    if (mark.state != MarkState::kUsed) continue;
    ++used;
    squares += mark.residual_um->squaredNorm();
  }
  EXPECT_EQ(used, result.reseau->crosses);
  EXPECT_NEAR(*result.sigma0_um, std::sqrt(squares / (2 * used - 6)), 1e-6);
  const auto again = InOrientation(result, mistyped, ShapesOf(mistyped), ScanOrientation::kR0);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->marks[6].state, MarkState::kRejected);
}

// A camera file that lacks a cross tells the scan orientations apart by that cross only; a film
// that lacks another one, and has that one, says nothing about it.
TEST(ReseauPhoto, AWrongOrientationIsNeverOkWhereNoCrossTellsItFromTheRightOne) {
  const TemporaryFolder folder;
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  spec.orientation = ScanOrientation::kR90;
  spec.missing = {6};
  WriteScan(folder / "a.png", RenderFilmFrame(spec).scan);
  CameraFile gap = spec.camera;
  gap.fiducials.erase(gap.fiducials.begin() + 7);
  InteriorOptions options;
  options.pixel_size_um = 100;
  const Raster scan = Raster::Open(folder / "a.png");
  const InteriorResult open = OrientInterior(scan, gap, ShapesOf(gap), options);
  EXPECT_NE(open.status, Status::kOk);
  EXPECT_LT(open.margin, 5);
  EXPECT_FALSE(open.findings.empty());
  options.orientation = ScanOrientation::kR90;
  EXPECT_EQ(OrientInterior(scan, gap, ShapesOf(gap), options).status, Status::kOk);
}

// The layout fits itself in all eight ways but for the drawing of its middle mark.
TEST(ReseauPhoto, AllWaysAreOpenWhereTheMarkThatTellsThemApartIsMissing) {
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  spec.camera.marks["three arms"] = spec.camera.marks.at("cross");
  spec.camera.marks["three arms"].elements = {LineElement{{-2, 0}, {2, 0}, 0.15},
                                              LineElement{{0, 0}, {0, 2}, 0.15}};
  spec.camera.fiducials[12].mark = "three arms";
  spec.orientation = ScanOrientation::kR90;
  spec.missing = {12};
  FilmFrame frame;
  const InteriorResult result = OrientFilm(spec, &frame);
  EXPECT_EQ(result.status, Status::kWeak);
  EXPECT_FALSE(result.orientation);
  EXPECT_EQ(result.possible_orientations.size(), 8u);
  EXPECT_EQ(result.orientation_nats.size(), 8u);
  const auto right = InOrientation(result, spec.camera, ShapesOf(spec.camera), spec.orientation);
  ASSERT_TRUE(right);
  EXPECT_EQ(right->marks[12].state, MarkState::kMissing);
  for (size_t i = 0; i < frame.mark_pixels.size(); ++i) {
    const Vector2d at = *right->photo_from_pixel * frame.mark_pixels[i];
    EXPECT_LT((at - spec.camera.fiducials[i].position_mm).norm(), 0.01) << "mm";
  }
}

TEST(LibraryReseau, WithThinSymmetricCrossesLeavesAllWaysOpen) {
  const CameraFile camera = ReadCameraFile(ProjectFile("data/cameras/hasselblad_mk_reseau.toml"));
  const auto classes = OrientationClasses(camera.fiducials, ShapesOf(camera));
  ASSERT_EQ(classes.size(), 1u);
  EXPECT_EQ(classes[0].size(), 8u);
}

TEST(ReseauPhoto, ACrossMissingInTheFileAndOnTheFilmTellsTheOrientation) {
  FilmFrameSpec spec;
  spec.camera = CrossCamera();
  spec.camera.fiducials.erase(spec.camera.fiducials.begin() + 7);
  spec.orientation = ScanOrientation::kR90;
  FilmFrame frame;
  const InteriorResult result = OrientFilm(spec, &frame);
  ASSERT_EQ(result.status, Status::kOk) << Sentence(result.findings.at(0));
  const auto& possible = result.possible_orientations;
  EXPECT_NE(std::find(possible.begin(), possible.end(), spec.orientation), possible.end());
  EXPECT_EQ(possible.size(), 2u);
}

}  // namespace
}  // namespace orient::interior

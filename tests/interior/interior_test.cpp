// Whole photos: simulated frames with exact truth.
#include "interior/interior.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "core/base/error.h"
#include "core/raster/resample.h"
#include "interior/constellation/film_search.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

// What the found transform and the truth may differ at a mark, px: several times the precision of
// one mark with this grain.
constexpr double kTransformTolerancePx = 0.15;
constexpr double kMarkTolerancePx = 0.25;
constexpr double kPixelMm = 0.1;

// A 7 cm frame is quick to render and has everything that a 23 cm frame has.
CameraFile SmallCamera() { return RingCamera(30, 70); }

CameraFile AsymmetricCamera() {
  CameraFile camera = SmallCamera();
  camera.fiducials.push_back({"5", {30, 9}, "corner", std::nullopt});
  return camera;
}

FilmFrameSpec Spec(const CameraFile& camera, unsigned seed) {
  FilmFrameSpec spec;
  spec.camera = camera;
  spec.pixel_mm = kPixelMm;
  spec.turn_rad = 0.01;
  spec.shift_px = {7.3, -4.6};
  spec.seed = seed;
  return spec;
}

InteriorOptions SizeGiven(std::optional<ScanOrientation> orientation = std::nullopt) {
  return {1e3 * kPixelMm, std::nullopt, orientation};
}

class InteriorOfSimulatedFrame : public testing::Test {
 protected:
  InteriorResult Orient(const Image& scan, const CameraFile& camera,
                        const InteriorOptions& options = SizeGiven()) {
    const std::string path = folder_ / "scan.png";
    WriteScan(path, scan);
    return OrientInterior(Raster::Open(path), camera, ShapesOf(camera), options);
  }
  // Largest distance, px, between where truth and the result see the camera's marks.
  static double Error(const Affine2d& photo_from_pixel, const FilmFrame& frame,
                      const CameraFile& camera) {
    double worst = 0;
    const Affine2d pixel_from_photo = photo_from_pixel.Inverse();
    for (size_t i = 0; i < camera.fiducials.size(); ++i)
      worst = std::max(
          worst,
          (pixel_from_photo * camera.fiducials[i].position_mm - frame.mark_pixels[i]).norm());
    return worst;
  }
  void ExpectOneOfThePossible(ScanOrientation orientation, Polarity polarity) {
    SCOPED_TRACE(std::string(Name(orientation)) + " " + std::string(Name(polarity)));
    const CameraFile camera = SmallCamera();
    FilmFrameSpec spec = Spec(camera, 3);
    spec.orientation = orientation;
    spec.polarity = polarity;
    const FilmFrame frame = RenderFilmFrame(spec);
    const InteriorResult result = Orient(frame.scan, camera);
    ASSERT_EQ(result.status, Status::kOk);
    EXPECT_EQ(result.polarity, polarity);
    EXPECT_FALSE(result.orientation);
    EXPECT_EQ(result.possible_orientations.size(), 8u);
    const auto turned = InOrientation(result, camera, ShapesOf(camera), orientation);
    ASSERT_TRUE(turned);
    EXPECT_LT(Error(*turned->photo_from_pixel, frame, camera), kTransformTolerancePx);
    EXPECT_EQ(NearestScanOrientation(*turned->photo_from_pixel), orientation);
    for (size_t i = 0; i < camera.fiducials.size(); ++i) {
      EXPECT_EQ(turned->marks[i].id, camera.fiducials[i].id);
      EXPECT_LT((*turned->marks[i].pixel - frame.mark_pixels[i]).norm(), kMarkTolerancePx);
    }
  }
  void ExpectTextureIsNeverTaken(unsigned from, unsigned to) {
    const CameraFile camera = SmallCamera();
    for (unsigned seed = from; seed < to; ++seed)
      EXPECT_EQ(Orient(RenderTexture(820, 820, seed), camera).status, Status::kFailed) << seed;
  }
  TemporaryFolder folder_;
};
// Labelled slow by its name.
class SlowInteriorOfSimulatedFrame : public InteriorOfSimulatedFrame {};

// Strokes of a pixel, 12 grey values above the dark corners, whose grain has a sigma of 4: the
// marks correlate with less than 0.45.
TEST_F(InteriorOfSimulatedFrame, ThinCrossesOfThreeSigmaOfTheGrainAreUsed) {
  CameraFile camera = SmallCamera();
  camera.marks["corner"].elements = {CrossElement{4.0, kPixelMm, 0.4, std::numbers::pi / 4}};
  FilmFrameSpec spec = Spec(camera, 3);
  spec.mark_brightness = 30;
  const FilmFrame frame = RenderFilmFrame(spec);
  const InteriorResult result = Orient(frame.scan, camera, SizeGiven(ScanOrientation::kR0));
  ASSERT_EQ(result.status, Status::kOk);
  for (const MarkResult& mark : result.marks) {
    EXPECT_EQ(mark.state, MarkState::kUsed) << mark.id;
    EXPECT_LT(mark.score.value(), 0.45) << mark.id;
  }
  EXPECT_LT(Error(*result.photo_from_pixel, frame, camera), 0.6);  // four sigma
}

// At half the resolution strokes of 0.8 px and the dark edges that sharpening gives them cancel.
TEST_F(InteriorOfSimulatedFrame, ThinCrossesThatTheScannerSharpenedAreFoundWhereverTheyLie) {
  CameraFile camera = SmallCamera();
  camera.marks["corner"].elements = {CrossElement{4.6, 0.13, 0.76, std::numbers::pi / 4}};
  FilmFrameSpec spec = Spec(camera, 3);
  spec.pixel_mm = 0.13 / 0.8;
  spec.blur_sigma_px = 0.4;
  InteriorOptions options;
  options.pixel_size_um = 1e3 * spec.pixel_mm;
  for (const double shift : {0.0, 0.25, 0.5, 0.75}) {
    spec.shift_px = {shift, -shift};
    FilmFrame frame = RenderFilmFrame(spec);
    const Image mean = GaussianBlur(frame.scan, 1);
    for (size_t i = 0; i < mean.values.size(); ++i)
      frame.scan.values[i] = std::clamp(2 * frame.scan.values[i] - mean.values[i], 0.0f, 255.0f);
    const InteriorResult result = Orient(frame.scan, camera, options);
    EXPECT_EQ(result.status, Status::kOk) << shift;
    for (const MarkResult& mark : result.marks)
      EXPECT_EQ(mark.state, MarkState::kUsed) << mark.id << " at " << shift;
  }
}

TEST_F(InteriorOfSimulatedFrame, EveryOrientationIsAmongThePossibleOnes) {
  for (size_t i = 0; i < kAllScanOrientations.size(); ++i)
    ExpectOneOfThePossible(kAllScanOrientations[i],
                           i % 3 == 0 ? Polarity::kNegative : Polarity::kPositive);
}

// Two marks are cut off with the scan's left side, and the film's turn takes others out of their
// windows; the marks between show where.
TEST_F(InteriorOfSimulatedFrame, MarksOfATurnedFilmThatIsCutOffAreFoundOutsideTheirWindows) {
  CameraFile camera = RingCamera();
  for (const Vector2d& side :
       {Vector2d(-110, 0), Vector2d(110, 0), Vector2d(0, 110), Vector2d(0, -110)})
    camera.fiducials.push_back(
        {std::to_string(camera.fiducials.size() + 1), side, "corner", std::nullopt});
  FilmFrameSpec spec = Spec(camera, 8);
  spec.turn_rad = 0.07;
  const FilmFrame frame = RenderFilmFrame(spec);
  std::vector<double> cols;
  for (const Vector2d& mark : frame.mark_pixels) cols.push_back(mark.x());
  std::sort(cols.begin(), cols.end());
  const int cut = static_cast<int>(cols[1] + 20);
  Image scan(frame.scan.width - cut, frame.scan.height, 0.0f);
  for (int row = 0; row < scan.height; ++row)
    for (int col = 0; col < scan.width; ++col) scan.At(col, row) = frame.scan.At(col + cut, row);
  const InteriorResult result = Orient(scan, camera);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_EQ(std::count_if(result.marks.begin(), result.marks.end(),
                          [](const auto& mark) { return mark.state == MarkState::kUsed; }),
            6);
  const auto turned = InOrientation(result, camera, ShapesOf(camera), ScanOrientation::kR0);
  ASSERT_TRUE(turned);
  for (size_t i = 0; i < camera.fiducials.size(); ++i) {
    if (turned->marks[i].state != MarkState::kUsed) continue;
    const Vector2d truth = frame.mark_pixels[i] - Vector2d(cut, 0);
    EXPECT_LT((*turned->marks[i].pixel - truth).norm(), kMarkTolerancePx) << i;
  }
}

TEST_F(SlowInteriorOfSimulatedFrame, EveryOrientationInBothPolaritiesIsAmongThePossibleOnes) {
  for (const ScanOrientation orientation : kAllScanOrientations)
    for (const Polarity polarity : {Polarity::kPositive, Polarity::kNegative})
      ExpectOneOfThePossible(orientation, polarity);
}

TEST_F(InteriorOfSimulatedFrame, AnAsymmetricLayoutSaysHowTheFilmLies) {
  const CameraFile camera = AsymmetricCamera();
  for (const ScanOrientation orientation : {ScanOrientation::kR270, ScanOrientation::kM90}) {
    FilmFrameSpec spec = Spec(camera, 4);
    spec.orientation = orientation;
    const FilmFrame frame = RenderFilmFrame(spec);
    const InteriorResult result = Orient(frame.scan, camera);
    ASSERT_EQ(result.status, Status::kOk) << Name(orientation);
    EXPECT_EQ(result.orientation, orientation);
    EXPECT_LT(Error(*result.photo_from_pixel, frame, camera), kTransformTolerancePx);
  }
}

TEST_F(InteriorOfSimulatedFrame, TheUsersOrientationIsTaken) {
  const CameraFile camera = SmallCamera();
  FilmFrameSpec spec = Spec(camera, 5);
  spec.orientation = ScanOrientation::kR90;
  const FilmFrame frame = RenderFilmFrame(spec);
  const InteriorResult result = Orient(frame.scan, camera, SizeGiven(ScanOrientation::kR90));
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_EQ(result.orientation, ScanOrientation::kR90);
  EXPECT_LT(Error(*result.photo_from_pixel, frame, camera), kTransformTolerancePx);
}

TEST_F(InteriorOfSimulatedFrame, AWronglyStatedPolarityIsToldAndNeverOk) {
  const CameraFile camera = SmallCamera();
  for (const Polarity polarity : {Polarity::kPositive, Polarity::kNegative}) {
    FilmFrameSpec spec = Spec(camera, 5);
    spec.polarity = polarity;
    const FilmFrame frame = RenderFilmFrame(spec);
    InteriorOptions options = SizeGiven();
    options.polarity = polarity;
    const InteriorResult right = Orient(frame.scan, camera, options);
    EXPECT_EQ(right.status, Status::kOk);
    EXPECT_FALSE(Has(right.findings, Reason::kPolarityUnlikeMarks));
    options.polarity = Opposite(polarity);
    const InteriorResult wrong = Orient(frame.scan, camera, options);
    EXPECT_NE(wrong.status, Status::kOk);
    ASSERT_FALSE(wrong.findings.empty());
    EXPECT_EQ(wrong.findings.front().reason, Reason::kPolarityUnlikeMarks);
    EXPECT_EQ(wrong.findings.front().where, Name(polarity));
  }
}

TEST_F(InteriorOfSimulatedFrame, AFilmFarFromTheScansMiddleIsFoundInTheWholeRange) {
  const CameraFile camera = AsymmetricCamera();
  for (const double shift_px : {60.0, 90.0}) {  // at the edge of the nearby windows, and beyond
    FilmFrameSpec spec = Spec(camera, 12);
    spec.shift_px = {shift_px, -40};
    const FilmFrame frame = RenderFilmFrame(spec);
    const InteriorResult result = Orient(frame.scan, camera);
    ASSERT_EQ(result.status, Status::kOk) << shift_px;
    EXPECT_LT(Error(*result.photo_from_pixel, frame, camera), kTransformTolerancePx);
  }
}

TEST_F(InteriorOfSimulatedFrame, TheNearbyWindowsGiveTheMarksOfTheWholeRange) {
  const CameraFile camera = AsymmetricCamera();
  const std::string path = folder_ / "scan.png";
  WriteScan(path, RenderFilmFrame(Spec(camera, 13)).scan);
  const Raster scan = Raster::Open(path);
  const FilmReading nearby =
      ReadFilm(scan, camera, ShapesOf(camera), SizeGiven(), SearchRange::kNearby);
  const FilmReading whole = ReadFilm(scan, camera, ShapesOf(camera), SizeGiven());
  EXPECT_LT(nearby.marks[0].window_mm2, whole.marks[0].window_mm2);
  for (size_t i = 0; i < camera.fiducials.size(); ++i) {
    ASSERT_GE(nearby.best.choice[i], 0);
    ASSERT_GE(whole.best.choice[i], 0);
    EXPECT_LT((nearby.candidates[i][nearby.best.choice[i]].pixel -
               whole.candidates[i][whole.best.choice[i]].pixel)
                  .norm(),
              0.5);
  }
}

TEST_F(InteriorOfSimulatedFrame, PixelSizeComesFromTheMarksWhereNothingTellsIt) {
  const CameraFile camera = SmallCamera();
  const FilmFrame frame = RenderFilmFrame(Spec(camera, 6));
  const InteriorResult result = Orient(frame.scan, camera, {});
  EXPECT_EQ(result.status, Status::kWeak);  // four marks may be those of a film of any size
  ASSERT_TRUE(result.pixel_size_um);
  EXPECT_NEAR(*result.pixel_size_um, 1e3 * kPixelMm, 0.15);
}

TEST_F(InteriorOfSimulatedFrame, TwoScalesThatDifferByTwoPercentAreTaken) {
  const CameraFile camera = SmallCamera();
  FilmFrameSpec spec = Spec(camera, 7);
  spec.scale = {1.01, 0.99};
  const FilmFrame frame = RenderFilmFrame(spec);
  const InteriorResult result = Orient(frame.scan, camera);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_LT(Error(*result.photo_from_pixel, frame, camera), kTransformTolerancePx);
}

TEST_F(InteriorOfSimulatedFrame, ThreeOfFourMarksAreNeverOk) {
  const CameraFile camera = SmallCamera();
  for (int missing = 0; missing < 4; ++missing) {
    FilmFrameSpec spec = Spec(camera, 8 + missing);
    spec.missing = {missing};
    const FilmFrame frame = RenderFilmFrame(spec);
    const InteriorResult result = Orient(frame.scan, camera);
    EXPECT_NE(result.status, Status::kOk);
    EXPECT_FALSE(result.findings.empty());
  }
}

TEST_F(InteriorOfSimulatedFrame, OneMissingOfFiveIsReportedMissing) {
  const CameraFile camera = AsymmetricCamera();
  FilmFrameSpec spec = Spec(camera, 12);
  spec.missing = {1};
  const FilmFrame frame = RenderFilmFrame(spec);
  const InteriorResult result = Orient(frame.scan, camera);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_NE(result.marks[1].state, MarkState::kUsed);
  EXPECT_LT(Error(*result.photo_from_pixel, frame, camera), kTransformTolerancePx);
}

TEST_F(InteriorOfSimulatedFrame, AFrameWithoutMarksFails) {
  const CameraFile camera = SmallCamera();
  FilmFrameSpec spec = Spec(camera, 13);
  spec.marks = false;
  const InteriorResult result = Orient(RenderFilmFrame(spec).scan, camera);
  EXPECT_EQ(result.status, Status::kFailed);
  EXPECT_FALSE(result.photo_from_pixel);
  EXPECT_FALSE(result.findings.empty());
}

TEST_F(InteriorOfSimulatedFrame, AnotherCamerasMarksAreNotTaken) {
  const CameraFile camera = SmallCamera();
  CameraFile other = camera;
  other.marks["corner"].elements = {CrossElement{3.5, 0.2, 0, 0}};
  EXPECT_NE(Orient(RenderFilmFrame(Spec(other, 14)).scan, camera).status, Status::kOk);
  CameraFile elsewhere = camera;
  elsewhere.fiducials = RingCamera(27, 70).fiducials;
  EXPECT_NE(Orient(RenderFilmFrame(Spec(elsewhere, 15)).scan, camera).status, Status::kOk);
}

TEST_F(InteriorOfSimulatedFrame, ACutOffSideIsNotOk) {
  const CameraFile camera = SmallCamera();
  const FilmFrame frame = RenderFilmFrame(Spec(camera, 16));
  const int cut = static_cast<int>(12 / kPixelMm);
  Image half(frame.scan.width - cut, frame.scan.height);
  for (int r = 0; r < half.height; ++r)
    for (int c = 0; c < half.width; ++c) half.At(c, r) = frame.scan.At(c + cut, r);
  const InteriorResult result = Orient(half, camera);
  EXPECT_EQ(result.status, Status::kFailed);
}

TEST_F(InteriorOfSimulatedFrame, PhotoTextureAloneIsNeverTaken) {
  ExpectTextureIsNeverTaken(100, 105);
}

TEST_F(SlowInteriorOfSimulatedFrame, PhotoTextureAloneIsNeverTaken) {
  ExpectTextureIsNeverTaken(200, 260);
}

TEST_F(InteriorOfSimulatedFrame, SigmasAreHonest) {
  const CameraFile camera = SmallCamera();
  double squares = 0;
  int count = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    FilmFrameSpec spec = Spec(camera, 200 + seed);
    spec.shift_px = Vector2d(0.13 * seed, -0.29 * seed);
    spec.noise = 10;
    spec.orientation = ScanOrientation::kR0;
    const FilmFrame frame = RenderFilmFrame(spec);
    const InteriorResult result = Orient(frame.scan, camera);
    ASSERT_EQ(result.status, Status::kOk) << seed;
    for (size_t i = 0; i < camera.fiducials.size(); ++i) {
      if (result.marks[i].state != MarkState::kUsed) continue;
      const Vector2d error = *result.marks[i].pixel - frame.mark_pixels[i];
      squares += (error.array() / result.marks[i].sigma_px->array()).square().sum();
      count += 2;
    }
  }
  const double rms = std::sqrt(squares / count);
  RecordProperty("rms_normalised_error", std::to_string(rms));
  EXPECT_GT(rms, 0.8);
  EXPECT_LT(rms, 1.25);
}

TEST_F(InteriorOfSimulatedFrame, AFilmCameraWithoutFiducialsIsRefused) {
  CameraFile camera = SmallCamera();
  const FilmFrame frame = RenderFilmFrame(Spec(camera, 17));
  camera.fiducials.clear();
  EXPECT_THROW(Orient(frame.scan, camera), InputError);
}

TEST_F(InteriorOfSimulatedFrame, ADigitalCameraHasItsFixedTransform) {
  CameraFile camera;
  camera.camera.kind = CameraKind::kDigital;
  camera.camera.frame_mm = Vector2d(6.4, 4.8);
  camera.camera.image_px = Eigen::Vector2i(64, 48);
  const InteriorResult result = Orient(RenderTexture(64, 48, 1), camera);
  ASSERT_EQ(result.status, Status::kOk);
  EXPECT_EQ(result.orientation, ScanOrientation::kR0);
  EXPECT_NEAR(*result.pixel_size_um, 100, 1e-9);
  EXPECT_TRUE((*result.photo_from_pixel * Vector2d(0, 0)).isApprox(Vector2d(-3.2, 2.4)));
  const InteriorResult other = Orient(RenderTexture(48, 64, 1), camera);
  EXPECT_EQ(other.status, Status::kFailed);
  EXPECT_FALSE(other.findings.empty());
}

}  // namespace
}  // namespace orient::interior

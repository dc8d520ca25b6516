#include "interior/camera_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {
namespace fs = std::filesystem;

using Eigen::Vector2d;

struct OwnedCamera {
  std::string name;
  CameraFile file;
  MarkShapes shapes;
};

// Deque-like: the pointers of KnownCamera stay valid while this lives.
class Cameras {
 public:
  size_t Add(const std::string& name, const CameraFile& file) {
    owned_.push_back(std::make_unique<OwnedCamera>(OwnedCamera{name, file, ShapesOf(file)}));
    known_.push_back({name, &owned_.back()->file, &owned_.back()->shapes});
    return known_.size() - 1;
  }
  const std::vector<KnownCamera>& Known() const { return known_; }

 private:
  std::vector<std::unique_ptr<OwnedCamera>> owned_;
  std::vector<KnownCamera> known_;
};

CameraFile WithLens(CameraFile camera, double principal_distance_mm) {
  camera.camera.principal_distance_mm = principal_distance_mm;
  return camera;
}

CameraFile WithSides(CameraFile camera, double side_mm) {
  const std::string mark = camera.fiducials.front().mark;
  camera.fiducials.push_back({"5", {-side_mm, 0}, mark, std::nullopt});
  camera.fiducials.push_back({"6", {side_mm, 0}, mark, std::nullopt});
  camera.fiducials.push_back({"7", {0, side_mm}, mark, std::nullopt});
  camera.fiducials.push_back({"8", {0, -side_mm}, mark, std::nullopt});
  return camera;
}

CameraFile WithDrawing(CameraFile camera, const std::vector<MarkElement>& elements) {
  for (auto& [name, drawing] : camera.marks) drawing.elements = elements;
  return camera;
}

constexpr double kPixelUm = 100;

// All marks found on a scan of 2400 x 2400 px, the film's middle in its middle. Where the marks lie
// on the scan is what `pixel_um` makes of the camera's geometry.
CameraReading Reading(const Cameras& cameras, size_t camera, double nats,
                      Status status = Status::kOk, double pixel_um = kPixelUm) {
  CameraReading reading{camera, {}, nats};
  InteriorResult& result = reading.result;
  result.status = status;
  result.width = result.height = 2400;
  result.pixel_size_um = pixel_um;
  result.polarity = Polarity::kPositive;
  result.possible_orientations = {ScanOrientation::kR0};
  const double p = 1e-3 * pixel_um;
  result.photo_from_pixel =
      Affine2d{Eigen::Matrix2d(Vector2d(p, -p).asDiagonal()), Vector2d(-1200 * p, 1200 * p)};
  for (const Fiducial& f : cameras.Known()[camera].file->fiducials)
    result.marks.push_back({f.id, MarkState::kUsed,
                            Vector2d(f.position_mm.x() / p + 1200, 1200 - f.position_mm.y() / p),
                            std::nullopt, std::nullopt, std::nullopt});
  return reading;
}

bool Says(const InteriorResult& result, const std::string& word) {
  return JoinedSentences(result.findings).find(word) != std::string::npos;
}

class CameraChoiceTest : public testing::Test {
 protected:
  CameraChoice Choose(const std::vector<CameraReading>& readings,
                      std::optional<double> pixel_um = kPixelUm) const {
    return ChooseCamera(cameras_.Known(), readings, pixel_um);
  }
  Cameras cameras_;
  const size_t wide_ = cameras_.Add("wide", RingCamera(106, 230));
  const size_t tele_ = cameras_.Add("tele", WithLens(RingCamera(106, 230), 210));
  const size_t inner_ = cameras_.Add("inner", RingCamera(104, 230));
  const size_t eight_ = cameras_.Add("eight", WithSides(RingCamera(106, 230), 110));
};

TEST_F(CameraChoiceTest, TheOnlyCameraThatFitsIsChosen) {
  const CameraChoice choice =
      Choose({Reading(cameras_, inner_, 2, Status::kFailed), Reading(cameras_, wide_, 12)});
  ASSERT_TRUE(choice.camera);
  EXPECT_EQ(*choice.camera, wide_);
  EXPECT_EQ(choice.result.status, Status::kOk);
  EXPECT_EQ(choice.result.cameras, std::vector<std::string>{"wide"});
  EXPECT_TRUE(Says(choice.result, "Check that its principal distance is calibrated"));
}

TEST_F(CameraChoiceTest, MarksOfThePolarityThatTheUserExcludedAreToldWhicheverCamerasTheyAre) {
  CameraReading unlike = Reading(cameras_, inner_, 2, Status::kFailed);
  unlike.result.findings = {{Reason::kPolarityUnlikeMarks, Status::kFailed, 30, 5, "negative"}};
  const InteriorResult unknown =
      Choose({unlike, Reading(cameras_, wide_, 3, Status::kFailed)}).result;
  EXPECT_EQ(unknown.status, Status::kFailed);
  EXPECT_TRUE(Has(unknown.findings, Reason::kPolarityUnlikeMarks));
  const CameraChoice clutter = Choose({unlike, Reading(cameras_, wide_, 27)});
  EXPECT_EQ(clutter.camera, wide_);
  EXPECT_EQ(clutter.result.status, Status::kWeak);
  EXPECT_TRUE(Has(clutter.result.findings, Reason::kPolarityUnlikeMarks));
  EXPECT_EQ(Choose({unlike, Reading(cameras_, wide_, 28)}).result.status, Status::kOk);
}

TEST_F(CameraChoiceTest, CamerasThatWereNotTriedAreNamed) {
  CameraFile crosses = RingCamera(20, 60);
  while (crosses.fiducials.size() <= kMostMarksOfUnknownCamera)
    crosses.fiducials.push_back(crosses.fiducials.back());
  cameras_.Add("crosses", crosses);
  CameraFile digital = RingCamera();
  digital.camera.kind = CameraKind::kDigital;
  cameras_.Add("digital", digital);
  const std::string said = "Not tried, as they have more than 12 marks: crosses.";
  const auto found = Choose({Reading(cameras_, wide_, 12), Reading(cameras_, tele_, 12)}).result;
  EXPECT_TRUE(Says(found, said)) << JoinedSentences(found.findings);
  EXPECT_TRUE(Says(found,
                   "Not tried, because at the stated pixel size their marks do not fit on the scan "
                   "or their films are a small part of it: inner, eight."));
  const auto unknown = Choose({Reading(cameras_, wide_, 2, Status::kFailed)}).result;
  EXPECT_TRUE(Says(unknown, said)) << JoinedSentences(unknown.findings);
  EXPECT_TRUE(Says(unknown, "none of the cameras tried (1)"));
}

TEST_F(CameraChoiceTest, CamerasWithOtherLensesAreATieAndNamed) {
  const CameraChoice choice = Choose({Reading(cameras_, wide_, 12), Reading(cameras_, tele_, 12)});
  ASSERT_TRUE(choice.camera);
  EXPECT_EQ(choice.result.status, Status::kOk);
  EXPECT_EQ(choice.result.cameras, (std::vector<std::string>{"wide", "tele"}));
  EXPECT_TRUE(Says(choice.result, "principal distance"));
}

TEST_F(CameraChoiceTest, AnotherGeometryNearlyAsGoodLeavesItUnknown) {
  const CameraChoice choice =
      Choose({Reading(cameras_, wide_, 12), Reading(cameras_, inner_, 9.5, Status::kOk, 98.1)});
  EXPECT_FALSE(choice.camera);
  EXPECT_EQ(choice.result.status, Status::kFailed);
  EXPECT_FALSE(choice.result.photo_from_pixel);
  EXPECT_TRUE(Says(choice.result, "wide"));
  EXPECT_TRUE(Says(choice.result, "inner"));
}

TEST_F(CameraChoiceTest, AnotherGeometryClearlyBehindIsNoRival) {
  const CameraChoice choice =
      Choose({Reading(cameras_, inner_, 8.5, Status::kOk, 98.1), Reading(cameras_, wide_, 12)});
  ASSERT_TRUE(choice.camera);
  EXPECT_EQ(*choice.camera, wide_);
}

TEST_F(CameraChoiceTest, MoreMarksInTheSamePlacesAreNoRival) {
  const CameraChoice choice = Choose({Reading(cameras_, wide_, 12), Reading(cameras_, eight_, 22)});
  ASSERT_TRUE(choice.camera);
  EXPECT_EQ(*choice.camera, eight_);
  EXPECT_EQ(choice.result.cameras, std::vector<std::string>{"eight"});
}

TEST_F(CameraChoiceTest, TooFewMarksInTheSamePlacesAreNoRivalAndInOthersAre) {
  const auto half_found = [&](size_t camera, double pixel_um) {
    CameraReading reading = Reading(cameras_, camera, 11.8, Status::kFailed, pixel_um);
    reading.result.photo_from_pixel.reset();
    reading.result.possible_orientations.clear();
    for (size_t i = 4; i < reading.result.marks.size(); ++i)
      reading.result.marks[i].state = MarkState::kMissing;
    return reading;
  };
  EXPECT_TRUE(Choose({Reading(cameras_, wide_, 12), half_found(eight_, kPixelUm)}).camera);
  EXPECT_FALSE(Choose({Reading(cameras_, wide_, 12), half_found(inner_, 98.1)}).camera);
}

TEST_F(CameraChoiceTest, ACameraThatIsOnlyWeakIsNotChosen) {
  EXPECT_FALSE(Choose({Reading(cameras_, wide_, 12, Status::kWeak)}).camera);
  EXPECT_FALSE(Choose({}).camera);
}

TEST_F(CameraChoiceTest, AStrongerWeakReadingOfAnotherGeometryLeavesItUnknown) {
  EXPECT_FALSE(
      Choose({Reading(cameras_, inner_, 14, Status::kWeak, 98.1), Reading(cameras_, wide_, 12)})
          .camera);
}

TEST_F(CameraChoiceTest, WithoutAPixelSizeFourMarksAreWeak) {
  const CameraChoice choice = Choose({Reading(cameras_, wide_, 12)}, std::nullopt);
  ASSERT_TRUE(choice.camera);
  EXPECT_EQ(choice.result.status, Status::kWeak);
  EXPECT_TRUE(Says(choice.result, "--pixel-size-um"));
}

TEST_F(CameraChoiceTest, WithoutAPixelSizeAShapeOfItsOwnTellsTheSize) {
  EXPECT_EQ(Choose({Reading(cameras_, eight_, 22)}, std::nullopt).result.status, Status::kOk);
  cameras_.Add("small", WithSides(RingCamera(53, 115), 55));
  EXPECT_EQ(Choose({Reading(cameras_, eight_, 22)}, std::nullopt).result.status, Status::kWeak);
}

TEST_F(CameraChoiceTest, APixelSizeSomewhatOffTheStatedOneIsWeak) {
  const CameraChoice choice = Choose({Reading(cameras_, wide_, 12, Status::kOk, 102)});
  EXPECT_EQ(choice.result.status, Status::kWeak);
  EXPECT_TRUE(Says(choice.result, "2.0 % larger"));
}

TEST_F(CameraChoiceTest, ContradictingTheStatedPixelSizeCostsFourNats) {
  // Read with 130 um pixels the "inner" marks lie elsewhere and its 12 nats count 8.
  const auto other = Reading(cameras_, inner_, 12, Status::kOk, 130);
  EXPECT_TRUE(Choose({other, Reading(cameras_, wide_, 11.5)}).camera);
  EXPECT_FALSE(Choose({other, Reading(cameras_, wide_, 10.5)}).camera);
}

// Simulated frames of 7 cm cameras with different marks and places.
class SlowUnknownCameraOfSimulatedFrame : public testing::Test {
 protected:
  static CameraFile Crosses() {
    return WithDrawing(RingCamera(30, 70), {CrossElement{4.1, 0.2, 0.7, 0.7853981634}});
  }
  CameraChoice Orient(const Image& scan, std::optional<double> pixel_um) const {
    const std::string path = folder_ / "scan.png";
    WriteScan(path, scan);
    InteriorOptions options;
    options.pixel_size_um = pixel_um;
    return OrientWithUnknownCamera(Raster::Open(path), cameras_.Known(), options);
  }
  static Image Scan(const CameraFile& camera, unsigned seed) {
    FilmFrameSpec spec;
    spec.camera = camera;
    spec.turn_rad = 0.01;
    spec.seed = seed;
    return RenderFilmFrame(spec).scan;
  }
  TemporaryFolder folder_;
  Cameras cameras_;
  const size_t ring_ = cameras_.Add("ring", RingCamera(30, 70));
  const size_t cross_ = cameras_.Add("cross", Crosses());
  const size_t inner_ = cameras_.Add("inner", RingCamera(27, 70));
  const size_t eight_ = cameras_.Add("eight", WithSides(RingCamera(30, 70), 32));
};

using UnknownCameraTooLargeForTheScan = SlowUnknownCameraOfSimulatedFrame;
using UnknownCameraOfSimulatedFrame = SlowUnknownCameraOfSimulatedFrame;

// The stated pixel size may be wrong: marks of the same shape do not tell, others do.
TEST_F(UnknownCameraTooLargeForTheScan, IsTriedIfItsMarksHaveTheShapeOfThoseFound) {
  cameras_.Add("large", RingCamera(60, 130));
  cameras_.Add("large eight", WithSides(RingCamera(60, 130), 64));
  const CameraChoice choice = Orient(Scan(RingCamera(30, 70), 7), kPixelUm);
  ASSERT_TRUE(choice.camera);
  EXPECT_EQ(choice.result.status, Status::kOk);
  EXPECT_TRUE(Says(choice.result, "a small part of it: large eight."))
      << JoinedSentences(choice.result.findings);
}

// A clear ring is no cross whose grain happens to be a ring.
TEST_F(UnknownCameraOfSimulatedFrame, IsFound) {
  for (const size_t camera : {ring_, inner_, eight_}) {
    const CameraChoice choice = Orient(Scan(*cameras_.Known()[camera].file, 7), kPixelUm);
    ASSERT_TRUE(choice.camera) << cameras_.Known()[camera].name;
    EXPECT_EQ(*choice.camera, camera);
    EXPECT_EQ(choice.result.status, Status::kOk);
  }
}

TEST_F(SlowUnknownCameraOfSimulatedFrame, WithOtherMarksInTheSamePlacesGivesTheSameTransform) {
  const CameraChoice choice = Orient(Scan(Crosses(), 5), kPixelUm);
  ASSERT_TRUE(choice.camera);
  EXPECT_TRUE(*choice.camera == cross_ || *choice.camera == ring_);
  EXPECT_NEAR(*choice.result.pixel_size_um, kPixelUm, 0.2);
}

TEST_F(SlowUnknownCameraOfSimulatedFrame, OfALayoutThatIsNotKnownIsNeverOk) {
  for (const double place_mm : {25.0, 28.5, 29.3}) {
    const CameraChoice choice = Orient(Scan(RingCamera(place_mm, 70), 3), kPixelUm);
    EXPECT_NE(choice.result.status, Status::kOk) << place_mm;
  }
}

TEST_F(SlowUnknownCameraOfSimulatedFrame, WithoutMarksIsUnknown) {
  const CameraChoice choice = Orient(RenderTexture(760, 740, 11), kPixelUm);
  EXPECT_FALSE(choice.camera);
  EXPECT_EQ(choice.result.status, Status::kFailed);
  EXPECT_TRUE(Says(choice.result, "unknown"));
}

TEST_F(SlowUnknownCameraOfSimulatedFrame, WithoutAPixelSizeIsNeverOkWhereTheMarksAreASquare) {
  EXPECT_NE(Orient(Scan(RingCamera(30, 70), 2), std::nullopt).result.status, Status::kOk);
}

// The whole library on real frames: the right family, or unknown (the curled print).
struct FrameAndFamily {
  std::string frame, family;
  bool named = true;
  friend std::ostream& operator<<(std::ostream& out, const FrameAndFamily& value) {
    return out << value.frame;
  }
};
class SlowLibraryOnRealFrame : public testing::TestWithParam<FrameAndFamily> {};

TEST_P(SlowLibraryOnRealFrame, NamesTheRightFamilyOrNoneOfACurledPrint) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  Cameras cameras;
  for (const auto& entry : fs::directory_iterator(ProjectFile("data/cameras")))
    if (entry.path().extension() == ".toml")
      cameras.Add(entry.path().stem().string(), ReadCameraFile(entry.path().string()));
  const CameraChoice choice = OrientWithUnknownCamera(
      Raster::Open(folder + "/" + GetParam().frame + ".jpg"), cameras.Known());
  for (const std::string& m : Sentences(choice.result.findings)) std::cout << m << "\n";
  EXPECT_EQ(choice.camera.has_value(), GetParam().named);
  if (!choice.camera) {
    EXPECT_EQ(choice.result.status, Status::kFailed);
    return;
  }
  EXPECT_EQ(cameras.Known()[*choice.camera].name.rfind(GetParam().family, 0), 0U)
      << cameras.Known()[*choice.camera].name;
}
INSTANTIATE_TEST_SUITE_P(Film, SlowLibraryOnRealFrame,
                         testing::Values(FrameAndFamily{"0bbe1004", "wild_rc10"},
                                         FrameAndFamily{"0c8e8831", "wild_rc10"},
                                         FrameAndFamily{"5bdd5cf4", "wild_rc10"},
                                         FrameAndFamily{"66685fc2", "wild_18cm"},
                                         FrameAndFamily{"0cec8b13", "wild_rc", false},
                                         FrameAndFamily{"0b4cb981", "zeiss_rmk"}));

// Without a drawing of its marks a camera that is tried ends the run.
TEST(UnknownCamera, FilmThatWouldBeLostOnTheScanIsNotSoughtWhereAnotherFits) {
  FilmFrameSpec spec;
  spec.camera = RingCamera();
  const FilmFrame frame = RenderFilmFrame(spec);
  const TemporaryFolder folder;
  WriteScan(folder / "scan.png", frame.scan);
  const MarkShapes right = ShapesOf(spec.camera), none;
  CameraFile small = RingCamera(40, 100);
  InteriorOptions options;
  options.pixel_size_um = 1e3 * spec.pixel_mm;
  const Raster scan = Raster::Open(folder / "scan.png");
  const CameraChoice choice = OrientWithUnknownCamera(
      scan, {{"small", &small, &none}, {"right", &spec.camera, &right}}, options);
  EXPECT_EQ(choice.camera, 1u);
  EXPECT_THROW(OrientWithUnknownCamera(scan, {{"small", &small, &none}}, options),
               std::invalid_argument);
}

}  // namespace
}  // namespace orient::interior

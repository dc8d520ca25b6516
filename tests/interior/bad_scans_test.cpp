// What bad input gets: scans without marks, of another camera, cut, turned, inverted, of one bit,
// with a nonsense resolution tag, with a neighbour in view ... simulated and real. A result may be
// weak or failed with a reason; `ok` must be right.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>

#include "core/error.h"
#include "interior/interior.h"
#include "tests/support/film_frame.h"
#include "tests/support/scan_making.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kMarkTolerance_px = 1, kTransformTolerance_px = 2;
constexpr float kWhiteBed = 250, kBlackBed = 18;

// A scan, the camera file that belongs to it, and what is known of the way the film lies.
struct KnownScan {
  std::string name;
  TrueScan scan;
  CameraFile camera;
  double pixel_mm = 0.1;
  // Real frames: their orientation was not measured, any of the eight will do.
  bool any_way = false;
};

// What a scan becomes and how it is read.
struct Trial {
  TrueScan scan;
  const KnownScan* of = nullptr;
  const CameraFile* read_as = nullptr;  // empty: with its own camera file
  std::optional<Vector2d> dpi;          // empty: the right one
  InteriorOptions options = {};
  bool one_bit = false;
  double share_of_file = 1;  // the rest is cut off
  // No transform could be right: nothing on the scan, or two films with equal claims.
  bool no_answer = false;
};

CameraFile LibraryCamera(const std::string& name) {
  return ReadCameraFile(ProjectFile("data/cameras/" + name + ".toml"));
}

KnownScan SimulatedOf(const std::string& name, const CameraFile& camera, double pixel_mm,
                      unsigned seed, bool marks) {
  KnownScan known{name, {}, camera, pixel_mm};
  FilmFrameSpec spec;
  spec.camera = known.camera;
  spec.pixel_mm = pixel_mm;
  spec.turn_rad = 0.006;
  spec.shift_px = {3.3, -2.6};
  spec.marks = marks;
  spec.seed = seed;
  const FilmFrame frame = RenderFilmFrame(spec);
  known.scan = {frame.scan, frame.pixel_from_photo, {}, Polarity::kPositive};
  for (const Vector2d& mark : frame.mark_pixels) known.scan.marks.push_back({mark, 0});
  return known;
}

KnownScan Simulated(const std::string& camera, double pixel_mm, unsigned seed = 1,
                    bool marks = true) {
  return SimulatedOf(camera, LibraryCamera(camera), pixel_mm, seed, marks);
}

// Corner marks, marks at the sides, both, and crosses in the picture.
const std::vector<std::pair<std::string, double>>& SimulatedCameras() {
  static const std::vector<std::pair<std::string, double>> cameras = {{"wild_rc10", 0.15},
                                                                      {"zeiss_rmk_top15", 0.125},
                                                                      {"zeiss_rmk_mid", 0.125},
                                                                      {"wild_18cm", 0.125},
                                                                      {"wild_p31", 0.05}};
  return cameras;
}

std::vector<KnownScan> AllSimulated(bool marks = true) {
  std::vector<KnownScan> scans;
  unsigned seed = 40;
  for (const auto& [camera, pixel_mm] : SimulatedCameras())
    scans.push_back(Simulated(camera, pixel_mm, ++seed, marks));
  return scans;
}

// A film of 7 cm with the RC10's marks is quick to render and to search.
const KnownScan& SmallFilm() {
  static const KnownScan scan = SimulatedOf("small film", RingCamera(30, 70), 0.1, 7, true);
  return scan;
}

// Photo places of the hand marks: corners (TL TR BR BL) or middles of the sides (T R B L).
std::optional<Vector2d> HandPlace(const std::string& mark, double corner_mm, double side_mm) {
  const std::map<std::string, Vector2d> corners = {
      {"TL", {-1, 1}}, {"TR", {1, 1}}, {"BR", {1, -1}}, {"BL", {-1, -1}}};
  const std::map<std::string, Vector2d> sides = {
      {"T", {0, 1}}, {"R", {1, 0}}, {"B", {0, -1}}, {"L", {-1, 0}}};
  if (corner_mm > 0 && corners.contains(mark)) return corner_mm * corners.at(mark);
  if (side_mm > 0 && sides.contains(mark)) return side_mm * sides.at(mark);
  return std::nullopt;
}

KnownScan RealFrame(const std::string& folder, const std::string& frame, const std::string& camera,
                    double corner_mm, double side_mm) {
  KnownScan known{frame, {}, LibraryCamera(camera), 0.127, true};
  const Raster raster = Raster::Open(folder + "/" + frame + ".jpg");
  known.pixel_mm = 25.4 / raster.DpiTag().value();
  known.scan.image = raster.ReadGrey().image;
  std::ifstream file(folder + "/marks.csv");
  std::vector<PointPair2d> pairs;
  for (std::string line; std::getline(file, line);) {
    std::stringstream cells(line);
    std::string of_frame, name, col, row, sigma;
    for (std::string* cell : {&of_frame, &name, &col, &row, &sigma})
      std::getline(cells, *cell, ',');
    const auto place = HandPlace(name, corner_mm, side_mm);
    if (of_frame != frame || col.empty() || !place) continue;
    const Vector2d pixel(std::stod(col), std::stod(row));
    known.scan.marks.push_back({pixel, std::stod(sigma)});
    pairs.push_back({*place, pixel});
  }
  known.scan.pixel_from_photo = FitAffine(pairs).value().transform;
  return known;
}

std::vector<KnownScan> AllReal(const std::string& folder) {
  return {RealFrame(folder, "0bbe1004", "wild_rc10", 106, 0),
          RealFrame(folder, "0c8e8831", "wild_rc10", 106, 0),
          RealFrame(folder, "5bdd5cf4", "wild_rc10", 106, 0),
          RealFrame(folder, "66685fc2", "wild_18cm", 82, 0),
          RealFrame(folder, "0b4cb981", "zeiss_rmk_mid", 0, 113)};
}

// Largest distance, px, of the transform from the truth at the marks of the camera it was read with
// and at the film's corners; over the ways the result leaves open the least.
double TransformError(const Trial& trial, const InteriorResult& found, const CameraFile& camera) {
  std::vector<Vector2d> places;
  for (const Fiducial& f : camera.fiducials) places.push_back(f.position_mm);
  const Vector2d half = 0.5 * trial.of->camera.camera.frame_mm;
  for (const Vector2d& sign : {Vector2d(-1, -1), Vector2d(1, -1), Vector2d(1, 1), Vector2d(-1, 1)})
    places.push_back(sign.cwiseProduct(half));
  double least = std::numeric_limits<double>::infinity();
  for (const ScanOrientation possible : found.possible_orientations) {
    const auto turned = InOrientation(found, camera, ShapesOf(camera), possible);
    if (!turned) continue;
    const Affine2d pixel_from_photo = turned->photo_from_pixel->Inverse();
    for (const ScanOrientation way : kAllScanOrientations) {
      if (!trial.of->any_way && way != ScanOrientation::kR0) continue;
      const Matrix2d turn = PhotoFromPixelAxes(way) * PhotoFromPixelAxes(ScanOrientation::kR0);
      double worst = 0;
      for (const Vector2d& place : places)
        worst = std::max(
            worst,
            (pixel_from_photo * place - trial.scan.pixel_from_photo * (turn * place)).norm());
      least = std::min(least, worst);
    }
  }
  return least;
}

// How far the worst used mark is from a true one, in units of what is allowed.
double WorstMark(const Trial& trial, const InteriorResult& found) {
  double worst = 0;
  for (const MarkResult& mark : found.marks) {
    if (mark.state != MarkState::kUsed) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const TruePlace& place : trial.scan.marks) {
      const double sigma = std::hypot(mark.sigma_px->maxCoeff(), place.sigma_px);
      const double allowed = std::max(kMarkTolerance_px, 3 * sigma);
      least = std::min(least, (*mark.pixel - place.pixel).norm() / allowed);
    }
    worst = std::max(worst, least);
  }
  return worst;
}

// One line of the table.
struct Row {
  int scans = 0, ok_right = 0, ok_wrong = 0, weak_right = 0, weak_wrong = 0, failed = 0;

  void Print(const std::string& name) const {
    std::printf("%-58s %4d scans: ok %4d, weak %3d (and %d off), failed %4d, ok and WRONG %d\n",
                name.c_str(), scans, ok_right, weak_right, weak_wrong, failed, ok_wrong);
    std::fflush(stdout);
  }
};

class BadScans : public testing::Test {
 protected:
  ~BadScans() override {
    row_.Print(testing::UnitTest::GetInstance()->current_test_info()->name());
  }

  void Try(const std::string& what, const Trial& trial) {
    SCOPED_TRACE(trial.of->name + ": " + what);
    const std::string path = folder_ / "scan.tif";
    const double dpi = 25.4 / trial.of->pixel_mm;
    WriteTiffScan(path, trial.scan.image, {trial.dpi.value_or(Vector2d(dpi, dpi)), trial.one_bit});
    if (trial.share_of_file < 1) {
      const auto bytes = static_cast<double>(std::filesystem::file_size(path));
      std::filesystem::resize_file(path, static_cast<std::uintmax_t>(trial.share_of_file * bytes));
    }
    TryFile(what, path, trial);
  }

  void TryFile(const std::string& what, const std::string& path, const Trial& trial) {
    const CameraFile& camera = trial.read_as ? *trial.read_as : trial.of->camera;
    ++row_.scans;
    InteriorResult found;
    try {
      found = OrientInterior(Raster::Open(path), camera, ShapesOf(camera), trial.options);
    } catch (const InputError& error) {
      found.messages.emplace_back(error.what());
    }
    Count(what, trial, camera, found);
  }

 private:
  static constexpr size_t kShortestReason = 20;

  void Count(const std::string& what, const Trial& trial, const CameraFile& camera,
             const InteriorResult& found) {
    if (found.status != Status::kOk) {
      ASSERT_FALSE(found.messages.empty());
      EXPECT_GT(found.messages.front().size(), kShortestReason) << found.messages.front();
    }
    if (found.status == Status::kFailed) {
      ++row_.failed;
      Say(what, trial, found, 0, 0);
      return;
    }
    const double off = trial.no_answer ? std::numeric_limits<double>::infinity()
                                       : TransformError(trial, found, camera);
    const double mark = WorstMark(trial, found);
    const bool right =
        off <= kTransformTolerance_px && mark <= 1 && found.polarity == trial.scan.polarity;
    Say(what, trial, found, off, mark);
    if (found.status == Status::kOk) {
      EXPECT_TRUE(right) << "transform off by " << off << " px, marks by " << mark
                         << " of what is allowed";
      ++(right ? row_.ok_right : row_.ok_wrong);
    } else {
      ++(right ? row_.weak_right : row_.weak_wrong);
    }
  }

  // ORIENT_VERBOSE: every result with its reason.
  static void Say(const std::string& what, const Trial& trial, const InteriorResult& found,
                  double off, double mark) {
    if (std::getenv("ORIENT_VERBOSE") == nullptr) return;
    std::cout << "  " << trial.of->name << ", " << what << ": " << Name(found.status);
    if (found.status != Status::kFailed)
      std::cout << " (off " << off << " px, marks " << mark << ")";
    for (const std::string& message : found.messages) std::cout << " | " << message;
    std::cout << std::endl;
  }

  TemporaryFolder folder_;
  Row row_;
};
class SlowBadScans : public BadScans {};

Trial With(const KnownScan& known, TrueScan scan) {
  Trial trial;
  trial.scan = std::move(scan);
  trial.of = &known;
  return trial;
}
Trial Plain(const KnownScan& known) { return With(known, known.scan); }

int Pixels(const KnownScan& known, double mm) {
  return static_cast<int>(std::lround(mm / known.pixel_mm));
}

std::vector<std::pair<std::string, Margins>> Cuts(int px) {
  return {{"left", {px, 0, 0, 0}},        {"top", {0, px, 0, 0}},
          {"right", {0, 0, px, 0}},       {"bottom", {0, 0, 0, px}},
          {"upper left", {px, px, 0, 0}}, {"upper right", {0, px, px, 0}},
          {"lower left", {px, 0, 0, px}}, {"lower right", {0, 0, px, px}}};
}

std::vector<std::pair<std::string, Trial>> Ways(const KnownScan& known) {
  return {{"upside down", With(known, UpsideDown(known.scan))},
          {"mirrored", With(known, MirroredScan(known.scan))},
          {"negative", With(known, NegativeScan(known.scan))},
          {"upside down and negative", With(known, NegativeScan(UpsideDown(known.scan)))},
          {"mirrored, turned and negative",
           With(known, NegativeScan(TurnedScan(MirroredScan(known.scan), 90, kWhiteBed)))}};
}

std::vector<std::pair<std::string, std::optional<Vector2d>>> NonsenseTags(const KnownScan& known) {
  const double right = 25.4 / known.pixel_mm;
  return {{"no tag", Vector2d(0, 0)},
          {"1 dpi", Vector2d(1, 1)},
          {"72 dpi", Vector2d(72, 72)},
          {"25400 dpi", Vector2d(25400, 25400)},
          {"ten times the right dpi", Vector2d(10 * right, 10 * right)},
          {"a tenth of the right dpi", Vector2d(0.1 * right, 0.1 * right)},
          {"1.1 times the right dpi", Vector2d(1.1 * right, 1.1 * right)},
          {"0.9 times the right dpi", Vector2d(0.9 * right, 0.9 * right)},
          {"dpi of y half that of x", Vector2d(right, 0.5 * right)}};
}

Trial Tagged(const KnownScan& known, const std::optional<Vector2d>& dpi) {
  Trial trial = Plain(known);
  trial.dpi = dpi;
  return trial;
}

Trial OneBit(const KnownScan& known, std::optional<float> threshold) {
  Trial trial = With(known, Bilevel(known.scan, threshold));
  trial.one_bit = true;
  return trial;
}

// The next frame of the film to the right or below, half of it in view.
Trial WithNeighbour(const KnownScan& known, const Image& next, bool below, double share) {
  const int overlap = Pixels(known, 4);
  const int hidden = static_cast<int>((1 - share) * (below ? next.height : next.width));
  TrueScan both = below ? Above(known.scan, next, overlap) : Beside(known.scan, next, overlap);
  return With(known, Cut(both, {0, 0, below ? 0 : hidden, below ? hidden : 0}));
}

// The middle of two frames: half of either.
Trial HalfAndHalf(const KnownScan& known, const Image& next) {
  const TrueScan both = Beside(known.scan, next, Pixels(known, 4));
  Trial trial = With(known, Cut(both, {known.scan.image.width / 2, 0, next.width / 2, 0}));
  trial.no_answer = true;
  return trial;
}

// ---------------------------------------------------------------------------------------- quick

TEST_F(BadScans, CutNoMarksAndNeighbour) {
  const KnownScan& known = SmallFilm();
  Try("cut at the left", With(known, Cut(known.scan, {Pixels(known, 14), 0, 0, 0})));
  Try("upside down and negative", With(known, NegativeScan(UpsideDown(known.scan))));
  Try("neighbour", WithNeighbour(known, MirroredScan(known.scan).image, false, 0.5));
  const KnownScan without = SimulatedOf("no marks", RingCamera(30, 70), 0.1, 3, false);
  Trial nothing = Plain(without);
  nothing.no_answer = true;
  Try("no marks", nothing);
}

TEST_F(BadScans, OneBitAndNonsenseTag) {
  const KnownScan& known = SmallFilm();
  Try("1 bit", OneBit(known, 128));
  Try("1 dpi", Tagged(known, Vector2d(1, 1)));
  Try("25400 dpi", Tagged(known, Vector2d(25400, 25400)));
}

TEST_F(BadScans, AnotherCameraAndHalfAFile) {
  const KnownScan& known = SmallFilm();
  const CameraFile other = RingCamera(27, 70);
  Trial wrong = Plain(known);
  wrong.read_as = &other;
  Try("read as a smaller camera", wrong);
  // So near that its search windows and the scale's prior take the marks for its own.
  const CameraFile like = RingCamera(30.6, 70);
  wrong.read_as = &like;
  Try("read as a camera of 2 % larger distances", wrong);
  Trial half = Plain(known);
  half.share_of_file = 0.5;
  Try("half of the file", half);
  Try("turned by 20 degrees", With(known, TurnedScan(known.scan, 20, kWhiteBed)));
}

// ------------------------------------------------------------------------------------ simulated

TEST_F(SlowBadScans, NoMarkAtAll) {
  for (const KnownScan& known : AllSimulated(false)) {
    Trial trial = Plain(known);
    trial.no_answer = true;
    Try("rebate without marks", trial);
    trial.dpi = Vector2d(0, 0);
    Try("rebate without marks, no tag", trial);
    trial.scan.image = RenderTexture(known.scan.image.width, known.scan.image.height, 77);
    Try("texture alone, no tag", trial);
  }
}

TEST_F(SlowBadScans, OtherCamerasFiles) {
  const std::vector<KnownScan> scans = AllSimulated();
  const std::vector<std::string> others = {"wild_rc8_23", "zeiss_rmk_corner", "zeiss_rmk_corner_21",
                                           "fairchild_kc6a", "wild_rc10_8"};
  std::vector<CameraFile> cameras;
  for (const KnownScan& known : scans) cameras.push_back(known.camera);
  for (const std::string& other : others) cameras.push_back(LibraryCamera(other));
  for (size_t i = 0; i < scans.size(); ++i)
    for (size_t j = 0; j < cameras.size(); ++j) {
      if (i == j) continue;
      Trial trial = Plain(scans[i]);
      trial.read_as = &cameras[j];
      Try("read as " + cameras[j].camera.name, trial);
    }
}

TEST_F(SlowBadScans, OtherCamerasFilesWithoutATag) {
  const std::vector<KnownScan> scans = AllSimulated();
  for (const KnownScan& known : scans)
    for (const KnownScan& other : scans) {
      if (&known == &other) continue;
      Trial trial = Tagged(known, Vector2d(0, 0));
      trial.read_as = &other.camera;
      Try("read as " + other.name + ", no tag", trial);
    }
}

TEST_F(SlowBadScans, CutOff) {
  for (const KnownScan& known : AllSimulated())
    for (const auto& [where, margins] :
         Cuts(Pixels(known, 0.07 * known.camera.camera.frame_mm.x())))
      Try("cut off: " + where, With(known, Cut(known.scan, margins)));
}

TEST_F(SlowBadScans, UpsideDownMirroredAndNegative) {
  for (const KnownScan& known : AllSimulated())
    for (const auto& [how, trial] : Ways(known)) Try(how, trial);
}

TEST_F(SlowBadScans, OneBit) {
  for (const KnownScan& known : AllSimulated()) {
    Try("threshold", OneBit(known, 128));
    Try("low threshold", OneBit(known, 60));
    Try("error diffusion", OneBit(known, std::nullopt));
  }
}

TEST_F(SlowBadScans, NonsenseResolutionTags) {
  for (const KnownScan& known : AllSimulated())
    for (const auto& [how, dpi] : NonsenseTags(known)) Try(how, Tagged(known, dpi));
}

TEST_F(SlowBadScans, NeighbouringFrame) {
  for (const auto& [camera, pixel_mm] : SimulatedCameras()) {
    const KnownScan known = Simulated(camera, pixel_mm, 11);
    const Image next = Simulated(camera, pixel_mm, 12).scan.image;
    Try("half of the next one at the right", WithNeighbour(known, next, false, 0.5));
    Try("a third of the next one below", WithNeighbour(known, next, true, 0.33));
    Try("half of two", HalfAndHalf(known, next));
    Trial both = WithNeighbour(known, next, false, 1);
    both.no_answer = true;
    Try("two whole frames", both);
  }
}

TEST_F(SlowBadScans, OnAScannerBed) {
  for (const auto& [camera, pixel_mm] : std::vector<std::pair<std::string, double>>{
           {"wild_rc10", 0.15}, {"zeiss_rmk_mid", 0.15}, {"wild_p31", 0.06}}) {
    const KnownScan known = Simulated(camera, pixel_mm, 21);
    const int wide = Pixels(known, 0.25 * known.camera.camera.frame_mm.x());
    const KnownScan second = Simulated(camera, pixel_mm, 22);
    for (const float bed : {kWhiteBed, 0.0f}) {
      const TrueScan on_bed = Cut(known.scan, {-wide, -wide / 2, -wide / 3, -2 * wide}, bed);
      Try(bed > 0 ? "white bed" : "black bed", With(known, on_bed));
      const TrueScan other = Cut(second.scan, {-wide, -wide / 2, -wide, -2 * wide}, bed);
      Trial two = With(known, Beside(on_bed, other.image, 0));
      two.no_answer = true;
      Try("two frames on a bed", two);
    }
  }
}

TEST_F(SlowBadScans, WrongPolarityStated) {
  for (const KnownScan& known : AllSimulated()) {
    Trial trial = Plain(known);
    trial.options.polarity = Polarity::kNegative;
    Try("positive, said to be negative", trial);
  }
}

TEST_F(SlowBadScans, BlankAndSaturated) {
  for (const std::string camera : {"wild_rc10", "zeiss_rmk_mid"}) {
    const KnownScan known = Simulated(camera, 0.1);
    for (const float tone : {0.0f, 128.0f, 255.0f}) {
      Trial trial = Plain(known);
      trial.no_answer = true;
      std::fill(trial.scan.image.values.begin(), trial.scan.image.values.end(), tone);
      Try("blank " + std::to_string(static_cast<int>(tone)), trial);
      trial.scan = NoisyScan(trial.scan, 20, 5);
      Try("noise around " + std::to_string(static_cast<int>(tone)), trial);
    }
  }
}

TEST_F(SlowBadScans, VignetteAndFog) {
  for (const KnownScan& known : AllSimulated()) {
    Try("vignette", With(known, FoggedScan(known.scan, 0.15, 0)));
    Try("fog", With(known, FoggedScan(known.scan, 1, 150)));
    Try("vignette and fog", With(known, FoggedScan(known.scan, 0.1, 80)));
  }
}

TEST_F(SlowBadScans, HalfOfTheFile) {
  for (const KnownScan& known : AllSimulated()) {
    Trial trial = Plain(known);
    trial.share_of_file = 0.5;
    Try("half of the file", trial);
    trial.share_of_file = 0.001;
    Try("the file's first bytes", trial);
  }
}

TEST_F(SlowBadScans, HeavyNoise) {
  for (const KnownScan& known : AllSimulated()) {
    Try("noise of 25", With(known, NoisyScan(known.scan, 25, 8)));
    Try("noise of 60", With(known, NoisyScan(known.scan, 60, 9)));
  }
}

TEST_F(SlowBadScans, Turned) {
  for (const KnownScan& known : AllSimulated())
    for (const double degrees : {2.0, 5.0, 10.0, 20.0, 45.0})
      Try("turned by " + std::to_string(static_cast<int>(degrees)) + " degrees",
          With(known, TurnedScan(known.scan, degrees, degrees < 8 ? kBlackBed : kWhiteBed)));
}

// ----------------------------------------------------------------------------------------- real

TEST_F(SlowBadScans, RealFramesUpsideDownMirroredAndNegative) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder))
    for (const auto& [how, trial] : Ways(known)) Try(how, trial);
}

TEST_F(SlowBadScans, RealFramesCutOff) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder))
    for (const auto& [where, margins] : Cuts(Pixels(known, 32)))
      Try("cut off: " + where, With(known, Cut(known.scan, margins)));
}

TEST_F(SlowBadScans, RealFramesOneBit) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder)) {
    Try("threshold", OneBit(known, 110));
    Try("error diffusion", OneBit(known, std::nullopt));
  }
}

TEST_F(SlowBadScans, RealFramesWithNonsenseResolutionTags) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder))
    for (const auto& [how, dpi] : NonsenseTags(known)) Try(how, Tagged(known, dpi));
}

TEST_F(SlowBadScans, RealFramesReadAsOthersWithoutATag) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  std::vector<CameraFile> cameras;
  for (const std::string name : {"wild_rc10", "zeiss_rmk_mid", "wild_18cm", "zeiss_rmk_corner",
                                 "wild_rc30", "fairchild_t11", "zeiss_rmk_top15"})
    cameras.push_back(LibraryCamera(name));
  for (const KnownScan& known : AllReal(folder))
    for (const CameraFile& camera : cameras) {
      if (camera.camera.name == known.camera.camera.name) continue;
      Trial trial = Tagged(known, Vector2d(0, 0));
      trial.read_as = &camera;
      Try("read as " + camera.camera.name + ", no tag", trial);
    }
}

TEST_F(SlowBadScans, RealFramesFoggedNoisyAndTurned) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder)) {
    Try("vignette", With(known, FoggedScan(known.scan, 0.2, 0)));
    Try("fog", With(known, FoggedScan(known.scan, 1, 120)));
    Try("noise of 40", With(known, NoisyScan(known.scan, 40, 3)));
    for (const double degrees : {3.0, 12.0, 30.0})
      Try("turned by " + std::to_string(static_cast<int>(degrees)) + " degrees",
          With(known, TurnedScan(known.scan, degrees, kWhiteBed)));
  }
}

TEST_F(SlowBadScans, RealFramesBesideOthersAndOnABed) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const std::vector<KnownScan> frames = AllReal(folder);
  for (const KnownScan& known : frames) {
    const Image& next = (&known == &frames[1] ? frames[2] : frames[1]).scan.image;
    Try("half of another at the right", WithNeighbour(known, next, false, 0.5));
    Try("a third of another below", WithNeighbour(known, next, true, 0.33));
    Try("half of two", HalfAndHalf(known, next));
    const int wide = Pixels(known, 50);
    Try("white bed", With(known, Cut(known.scan, {-wide, -wide, -2 * wide, -wide / 2})));
  }
}

TEST_F(SlowBadScans, RealFilesCutShort) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  const TemporaryFolder copies;
  for (const KnownScan& known : AllReal(folder))
    for (const double share : {0.9, 0.5, 0.1}) {
      const std::string copy = copies / (known.name + std::to_string(share) + ".jpg");
      std::filesystem::copy_file(folder + "/" + known.name + ".jpg", copy);
      std::filesystem::permissions(copy, std::filesystem::perms::owner_all);
      const auto bytes = static_cast<double>(std::filesystem::file_size(copy));
      std::filesystem::resize_file(copy, static_cast<std::uintmax_t>(share * bytes));
      SCOPED_TRACE(known.name + " cut short");
      TryFile("the file's first " + std::to_string(share), copy, Plain(known));
    }
}

}  // namespace
}  // namespace orient

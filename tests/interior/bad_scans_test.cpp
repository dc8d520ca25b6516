// What bad input gets: scans without marks, of another camera, cut, turned, inverted, of one bit,
// with a nonsense resolution tag, with a neighbour in view ... as simulated. The real ones:
// bad_real_scans_test.cpp.
#include "tests/interior/bad_scans.h"

#include <algorithm>

#include "tests/support/film_frame.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

class SlowBadScans : public BadScans {};

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
  // Without a tag nothing but the marks' distances would tell.
  wrong.dpi = Vector2d(0, 0);
  Try("read as a camera of 2 % larger distances, no tag", wrong);
  Trial half = Plain(known);
  half.share_of_file = 0.5;
  Try("half of the file", half);
  Try("turned by 20 degrees", With(known, TurnedScan(known.scan, 20, kWhiteBed)));
}

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

}  // namespace
}  // namespace orient::interior

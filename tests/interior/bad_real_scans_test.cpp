// What bad input made of real frames gets.
#include <filesystem>

#include "tests/interior/bad_scans.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

class SlowBadRealScans : public BadScans {};

std::vector<KnownScan> AllReal(const std::string& folder) {
  return {RealFrame(folder, "0bbe1004", "wild_rc10", 106, 0),
          RealFrame(folder, "0c8e8831", "wild_rc10", 106, 0),
          RealFrame(folder, "5bdd5cf4", "wild_rc10", 106, 0),
          RealFrame(folder, "66685fc2", "wild_18cm", 82, 0),
          RealFrame(folder, "0b4cb981", "zeiss_rmk_mid", 0, 113)};
}

TEST_F(SlowBadRealScans, UpsideDownMirroredAndNegative) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder))
    for (const auto& [how, trial] : Ways(known)) Try(how, trial);
}

TEST_F(SlowBadRealScans, CutOff) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder))
    for (const auto& [where, margins] : Cuts(Pixels(known, 32)))
      Try("cut off: " + where, With(known, Cut(known.scan, margins)));
}

TEST_F(SlowBadRealScans, OneBit) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder)) {
    Try("threshold", OneBit(known, 110));
    Try("error diffusion", OneBit(known, std::nullopt));
  }
}

TEST_F(SlowBadRealScans, WithNonsenseResolutionTags) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "film");
  for (const KnownScan& known : AllReal(folder))
    for (const auto& [how, dpi] : NonsenseTags(known)) Try(how, Tagged(known, dpi));
}

TEST_F(SlowBadRealScans, ReadAsOthersWithoutATag) {
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

TEST_F(SlowBadRealScans, FoggedNoisyAndTurned) {
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

TEST_F(SlowBadRealScans, BesideOthersAndOnABed) {
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

TEST_F(SlowBadRealScans, FilesCutShort) {
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
}  // namespace orient::interior

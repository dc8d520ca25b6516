// Signs and axes: however the film lay on the scanner, whatever its polarity and the photo's kappa,
// nobody has to say it and the true orientation comes out.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "core/files/orientation_table.h"
#include "core/geometry/rotation.h"
#include "core/raster/raster.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/geotiff.h"

namespace orient {
namespace {

// On bare ground; what comes out is half of these or better.
constexpr double kMaxProjectionRms_px = 0.15;
constexpr double kMaxPosition_m = 0.75;  // 1 px: position and tilt trade against one another
constexpr double kMaxAngle_deg = 0.05;

// Two strips flown to and fro: kappa and kappa + 180 degrees.
SimulationOptions TwoPhotos(double kappa_deg) {
  SimulationOptions options;
  options.seed = 11;
  options.photos = 2;
  options.strips = 2;
  options.gsd_m = 0.75;
  options.objects = false;     // what stands leans outwards and makes the ground look higher
  options.pixel_size_um = 75;  // 820 x 820 px
  options.kappa_deg = kappa_deg;
  options.position_error_m = 3;
  options.attitude_error_deg = 0.5;
  return options;
}

// 40 and -140, 130 and -50 degrees: one in each quadrant.
constexpr double kFirstKappa_deg = 40;
constexpr double kSecondKappa_deg = 130;

struct Variant {
  ScanOrientation orientation;
  Polarity polarity;

  std::string Text() const {
    return std::string(Name(orientation)) + "_" + std::string(Name(polarity));
  }
};

// A pixel (col, row) of an r0 scan in the scan of a film laid otherwise, in the conventions' words:
// mirrored left-right first, then turned counter-clockwise by quarters.
Eigen::Vector2d Relaid(ScanOrientation orientation, int width, int height, Eigen::Vector2d pixel) {
  if (IsMirrored(orientation)) pixel.x() = width - pixel.x();
  for (int quarter = static_cast<int>(orientation) % 4; quarter > 0; --quarter) {
    pixel = Eigen::Vector2d(pixel.y(), width - pixel.x());
    std::swap(width, height);
  }
  return pixel;
}

// Scans the film of an r0, positive, 8-bit scan again. This needs nothing of the simulator's own
// geometry, so the two can contradict one another.
void ScanAgain(const std::string& from, const Variant& variant, double pixel_size_mm,
               const std::string& to) {
  const Image scan = Raster::Open(from).ReadGrey().image;
  const bool square = scan.width == scan.height;
  if (!square) throw std::invalid_argument("film scans are square");
  std::vector<std::uint16_t> values(scan.values.size());
  for (int row = 0; row < scan.height; ++row)
    for (int col = 0; col < scan.width; ++col) {
      const Eigen::Vector2d place =
          Relaid(variant.orientation, scan.width, scan.height, {col + 0.5, row + 0.5});
      const float grey = scan.At(col, row);
      const auto index =
          static_cast<std::size_t>(place.y()) * static_cast<std::size_t>(scan.width) +
          static_cast<std::size_t>(place.x());
      values[index] =
          static_cast<std::uint16_t>(variant.polarity == Polarity::kNegative ? 255 - grey : grey);
    }
  simulation::WriteGreyTiff(to, scan.width, scan.height, values, 8, pixel_size_mm, std::nullopt);
}

// The scans of one block in several variants, each under a name of its own.
class Rescans {
 public:
  explicit Rescans(const std::string& block) : block_(block) {
    approximations_ = ReadOrientationTable(block + "/approx.csv");
  }

  // The scan is to lie at Path(...) already or be written there by the caller.
  void Add(const TruePhoto& photo, const Variant& variant, std::vector<SeenPoint> seen) {
    const std::string name = NameOf(photo, variant);
    expected_.push_back({name, photo.pose, variant, std::move(seen)});
    OrientationRow row = *approximations_.Find(photo.name);
    row.photo = name;
    table_.rows.push_back(row);
  }
  std::string Path(const TruePhoto& photo, const Variant& variant) const {
    return block_ + "/again_" + NameOf(photo, variant) + ".tif";
  }

  // Orients every scan knowing nothing of how it lies, and checks what comes out.
  void OrientAndCheck();
  // The same, told the scan orientation.
  void OrientAsToldAndCheck();

 private:
  struct Expected {
    std::string name;
    Pose pose;
    Variant variant;
    std::vector<SeenPoint> seen;
  };

  static std::string NameOf(const TruePhoto& photo, const Variant& variant) {
    return photo.name + "_" + variant.Text();
  }
  std::string Scan(const Expected& expected) const {
    return block_ + "/again_" + expected.name + ".tif";
  }
  void Interior(const std::vector<std::string>& scans, const std::vector<std::string>& further);
  void Exterior(const std::vector<std::string>& scans);
  void Check(const Expected& expected);

  std::string block_;
  OrientationTable approximations_, table_;
  std::vector<Expected> expected_;
};

void Rescans::Interior(const std::vector<std::string>& scans,
                       const std::vector<std::string>& further) {
  std::vector<std::string> arguments = {"interior", "--camera",      block_ + "/camera.toml",
                                        "--out",    block_ + "/out", "--overwrite"};
  arguments.insert(arguments.end(), further.begin(), further.end());
  arguments.insert(arguments.end(), scans.begin(), scans.end());
  const ProgramRun run = RunOrient(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
}

void Rescans::Exterior(const std::vector<std::string>& scans) {
  OrientationTable table = table_;
  table.crs = approximations_.crs;
  for (OrientationRow& row : table.rows) row.photo = "again_" + row.photo;
  WriteOrientationTable(block_ + "/again.csv", table);
  std::vector<std::string> arguments = {"exterior",
                                        "--camera",
                                        block_ + "/camera.toml",
                                        "--dem",
                                        block_ + "/dem.tif",
                                        "--approximations",
                                        block_ + "/again.csv",
                                        "--patchdb",
                                        block_ + "/patches.gpkg",
                                        "--interior",
                                        block_ + "/out",
                                        "--out",
                                        block_ + "/out",
                                        "--overwrite",
                                        "--no-feedback",
                                        "--position-sigma-m",
                                        "3",
                                        "--attitude-sigma-deg",
                                        "0.5"};
  arguments.insert(arguments.end(), scans.begin(), scans.end());
  const ProgramRun run = RunOrient(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
}

void Rescans::Check(const Expected& expected) {
  SCOPED_TRACE(expected.name);
  const std::string name = "again_" + expected.name;
  const CameraFile camera = ReadCameraFile(block_ + "/camera.toml");
  const InteriorResult interior = ReadInteriorResult(InteriorResultPath(block_ + "/out", name));
  const ExteriorResult result = ReadExteriorResult(ExteriorResultPath(block_ + "/out", name));
  EXPECT_EQ(interior.polarity, expected.variant.polarity);
  ASSERT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  ASSERT_TRUE(result.orientation.has_value());
  EXPECT_EQ(Name(*result.orientation), Name(expected.variant.orientation));
  const double rms = ProjectionRms(camera, interior, result, expected.seen);
  EXPECT_LE(rms, kMaxProjectionRms_px);
  const double position = (result.pose->position_m - expected.pose.position_m).norm();
  EXPECT_LE(position, kMaxPosition_m);
  double angle = 0;
  for (int i = 0; i < 3; ++i)
    angle = std::max(angle,
                     std::abs(NormalizeAngle(result.pose->opk_rad[i] - expected.pose.opk_rad[i])));
  EXPECT_LE(DegFromRad(angle), kMaxAngle_deg);
  std::printf("%-28s kappa %7.2f  projection rms %.3f px, position %.2f m, angle %.3f deg\n",
              expected.name.c_str(), DegFromRad(expected.pose.opk_rad[2]), rms, position,
              DegFromRad(angle));
}

void Rescans::OrientAndCheck() {
  std::vector<std::string> scans;
  for (const Expected& expected : expected_) scans.push_back(Scan(expected));
  ASSERT_NO_FATAL_FAILURE(Interior(scans, {}));
  Exterior(scans);
  for (const Expected& expected : expected_) Check(expected);
}

void Rescans::OrientAsToldAndCheck() {
  std::vector<std::string> scans;
  for (const Expected& expected : expected_) {
    scans.push_back(Scan(expected));
    ASSERT_NO_FATAL_FAILURE(Interior(
        {scans.back()}, {"--orientation", std::string(Name(expected.variant.orientation))}));
  }
  Exterior(scans);
  for (const Expected& expected : expected_) Check(expected);
}

constexpr auto kPositive = Polarity::kPositive;
constexpr auto kNegative = Polarity::kNegative;

// Adds the variants of one photo, its film scanned again.
void AddRescans(const std::string& block, const TruePhoto& photo,
                const std::vector<Variant>& variants, Rescans* rescans) {
  for (const Variant& variant : variants) {
    ScanAgain(block + "/scans/" + photo.name + ".tif", variant, photo.pixel_size_mm,
              rescans->Path(photo, variant));
    std::vector<SeenPoint> seen = photo.seen;
    for (SeenPoint& point : seen)
      point.pixel = Relaid(variant.orientation, photo.width, photo.height, point.pixel);
    rescans->Add(photo, variant, seen);
  }
}

TEST(ScanOrientations, OneOfEveryQuadrantIsFoundOutMirroredOrNotInBothPolarities) {
  const std::vector<std::vector<Variant>> variants = {
      {{ScanOrientation::kM90, kNegative}},    // 40
      {{ScanOrientation::kR90, kNegative}},    // -140
      {{ScanOrientation::kM0, kPositive}},     // 130
      {{ScanOrientation::kR270, kPositive}}};  // -50
  std::size_t next = 0;
  for (const double kappa : {kFirstKappa_deg, kSecondKappa_deg}) {
    const TemporaryFolder folder;
    MakeBlock(TwoPhotos(kappa), folder / "block");
    Rescans rescans(folder / "block");
    for (const TruePhoto& photo : ReadTruth(folder / "block"))
      AddRescans(folder / "block", photo, variants[next++], &rescans);
    rescans.OrientAndCheck();
  }
  EXPECT_EQ(next, variants.size());
}

TEST(ScanOrientations, GivenOnesAreBelieved) {
  const TemporaryFolder folder;
  SimulationOptions options = TwoPhotos(kSecondKappa_deg);
  options.photos = options.strips = 1;
  MakeBlock(options, folder / "block");
  const TruePhoto photo = ReadTruth(folder / "block").front();
  Rescans rescans(folder / "block");
  AddRescans(folder / "block", photo,
             {{ScanOrientation::kR90, kPositive}, {ScanOrientation::kM270, kNegative}}, &rescans);
  rescans.OrientAsToldAndCheck();
}

// One photo of an r0 scan, oriented as if it had been `wrong`.
struct WronglyTold {
  ProgramRun exterior;
  ExteriorResult result;
};

WronglyTold OrientToldWrongly(const std::string& wrong) {
  const TemporaryFolder folder;
  SimulationOptions options = TwoPhotos(kSecondKappa_deg);
  options.photos = options.strips = 1;
  MakeBlock(options, folder / "block");
  const auto path = [&](const char* name) { return folder / ("block/" + std::string(name)); };
  const ProgramRun interior =
      RunOrient({"interior", path("scans/new_1_1.tif"), "--camera", path("camera.toml"), "--out",
                 path("out"), "--orientation", wrong});
  EXPECT_EQ(interior.exit_code, 0) << interior.err;
  const ProgramRun exterior =
      RunOrient({"exterior", path("scans/new_1_1.tif"), "--camera", path("camera.toml"), "--dem",
                 path("dem.tif"), "--approximations", path("approx.csv"), "--patchdb",
                 path("patches.gpkg"), "--interior", path("out"), "--out", path("out"),
                 "--no-feedback", "--position-sigma-m", "3", "--attitude-sigma-deg", "0.5"});
  return {exterior, ReadExteriorResult(ExteriorResultPath(path("out"), "new_1_1"))};
}

// Square marks cannot contradict a wrong word about the scan, the patches can: one that is turned
// shows another kappa than the approximation says ...
TEST(ScanOrientations, ATurnedOneIsNeverOk) {
  const WronglyTold told = OrientToldWrongly("r180");
  EXPECT_EQ(told.exterior.exit_code, 0) << told.exterior.err;
  EXPECT_EQ(told.result.status, Status::kWeak);
  EXPECT_TRUE(told.result.pose.has_value());
  EXPECT_NE(told.exterior.out.find("sigma from its approximation"), std::string::npos)
      << told.exterior.out;
}

// ... and a mirrored one shows nothing of them, which takes every search to find out.
TEST(SlowScanOrientation, AMirroredOneIsNeverOk) {
  const WronglyTold told = OrientToldWrongly("m0");
  EXPECT_EQ(told.exterior.exit_code, 3) << told.exterior.out << told.exterior.err;
  EXPECT_EQ(told.result.status, Status::kFailed);
  EXPECT_FALSE(told.result.pose.has_value());
}

// All 64 combinations, as the simulator renders them.
class SlowScanOrientations : public testing::TestWithParam<double> {};

TEST_P(SlowScanOrientations, AllAreFoundOutInBothPolarities) {
  const TemporaryFolder folder;
  SimulationOptions options = TwoPhotos(GetParam());
  MakeBlock(options, folder / "block");
  Rescans rescans(folder / "block");
  for (const ScanOrientation orientation : kAllScanOrientations)
    for (const Polarity polarity : {kPositive, kNegative}) {
      options.orientation = orientation;
      options.polarity = polarity;
      Simulate(options, folder / "scanned");
      for (const TruePhoto& photo : ReadTruth(folder / "scanned")) {
        std::filesystem::rename(folder / ("scanned/scans/" + photo.name + ".tif"),
                                rescans.Path(photo, {orientation, polarity}));
        rescans.Add(photo, {orientation, polarity}, photo.seen);
      }
      std::filesystem::remove_all(folder / "scanned");
    }
  rescans.OrientAndCheck();
}

INSTANTIATE_TEST_SUITE_P(Kappa, SlowScanOrientations,
                         testing::Values(kFirstKappa_deg, kSecondKappa_deg));

}  // namespace
}  // namespace orient

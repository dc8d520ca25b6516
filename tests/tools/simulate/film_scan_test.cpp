// Scans of single film frames, and what interior orientation makes of them.
#include "tests/tools/simulate/film_scan.h"

#include <gtest/gtest.h>

#include <iostream>

#include "core/raster/raster.h"
#include "interior/interior.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/cameras.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;

struct Setting {
  SimulationOptions options;
  FilmScanOptions film;
  std::optional<interior::LocatorKind> locator = std::nullopt;
  std::vector<MarkCondition> damage = {};  // of marks in turn, from another one on in every scan
  int meshes = 5;                          // of a reseau, on every side of its middle
};

Setting Preset(CameraPreset preset, double pixel_um) {
  Setting setting;
  setting.options.camera = preset;
  setting.options.pixel_size_um = pixel_um;
  setting.options.mark_symbols = preset == CameraPreset::kRc30 || preset == CameraPreset::kDemo;
  return setting;
}

// Marks 45 grey values brighter than the rebate, under grain of 9.
Setting LowContrast(Setting setting) {
  setting.film.mark_tone = 0.06f + 45.0f / 255.0f;
  setting.options.grain = 9;
  return setting;
}

struct Scanned {
  SimulatedCamera camera;
  PhotoPlan plan;
  InteriorResult truth, found;
};

constexpr double kMesh_mm = 5;  // of the simulated reseau

// The setting's camera, a reseau's with its inner crosses only and the frame as much smaller.
SimulatedCamera CameraOf(const Setting& setting) {
  SimulatedCamera camera = NewCamera(setting.options);
  const double cut_mm = kMesh_mm * (5 - setting.meshes);
  if (setting.options.camera != CameraPreset::kReseau || cut_mm <= 0) return camera;
  const double most_mm = kMesh_mm * setting.meshes + 1;
  std::erase_if(camera.file.fiducials, [&](const Fiducial& cross) {
    return cross.position_mm.cwiseAbs().maxCoeff() > most_mm;
  });
  camera.file.camera.frame_mm.array() -= 2 * cut_mm;
  camera.film_half_mm -= cut_mm;
  const auto cut_px = static_cast<int>(std::lround(2 * cut_mm / camera.pixel_size_mm));
  camera.width_px -= cut_px;
  camera.height_px -= cut_px;
  return camera;
}

Scanned ScanAndOrient(const Setting& setting, int number) {
  const TemporaryFolder folder;
  const std::string path = folder / "scan.tif";
  const SimulatedCamera camera = CameraOf(setting);
  PhotoPlan plan = PlanPhoto(setting.options, camera, {}, false, number);
  for (size_t i = 0; i < setting.damage.size(); ++i)
    plan.marks[(i + static_cast<size_t>(number)) % plan.marks.size()] = setting.damage[i];
  Scanned scanned{camera, plan, {}, {}};
  WriteFilmScan(path, setting.options, setting.film, scanned.camera, plan);
  scanned.truth = TrueInterior(scanned.camera, plan);
  interior::InteriorOptions how;
  how.locator = setting.locator;
  scanned.found = interior::OrientInterior(Raster::Open(path), scanned.camera.file,
                                           interior::ShapesOf(scanned.camera.file), how);
  return scanned;
}

// What many scans come to.
struct Tally {
  int scans = 0, ok = 0, failed = 0;
  int polarity_wrong = 0, orientation_wrong = 0, orientation_open = 0;
  int marks = 0, used = 0, wrong = 0;
  double square_px = 0, square_normalised = 0;  // sums over both coordinates
  // Réseau: what the correction leaves at places between the crosses.
  int between = 0;
  double square_between_um = 0;

  double RmsPx() const { return std::sqrt(square_px / (2 * std::max(used, 1))); }
  double RmsBetween_um() const { return std::sqrt(square_between_um / (2 * std::max(between, 1))); }
  double RmsNormalised() const { return std::sqrt(square_normalised / (2 * std::max(used, 1))); }
};

void AddMarks(const Scanned& scan, const InteriorResult& found, Tally* tally) {
  constexpr double kWrong_px = 1;
  for (size_t i = 0; i < found.marks.size(); ++i) {
    const MarkResult& mark = found.marks[i];
    if (mark.state != MarkState::kUsed) continue;
    const auto& truth = scan.truth.marks[i].pixel;
    if (!truth || (*mark.pixel - *truth).norm() > kWrong_px) {
      ++tally->wrong;
      continue;
    }
    ++tally->used;
    const Vector2d error = *mark.pixel - *truth;
    tally->square_px += error.squaredNorm();
    tally->square_normalised += error.cwiseQuotient(*mark.sigma_px).squaredNorm();
  }
}

// The middles of the meshes.
void AddBetween(const Scanned& scan, const InteriorResult& found, Tally* tally) {
  if (!found.reseau) return;
  const auto meshes = static_cast<int>(std::sqrt(found.marks.size())) / 2;
  for (int row = -meshes; row < meshes; ++row)
    for (int col = -meshes; col < meshes; ++col) {
      const Vector2d photo = kMesh_mm * Vector2d(col + 0.5, row + 0.5);
      const Vector2d corrected =
          PhotoFromPixel(found.photo_from_pixel.value(), &found.reseau->correction,
                         scan.plan.scan.PixelFromPhoto(photo));
      tally->square_between_um += 1e6 * (corrected - photo).squaredNorm();
      ++tally->between;
    }
}

void Add(const Scanned& scan, Tally* tally) {
  ++tally->scans;
  tally->marks += static_cast<int>(scan.camera.file.fiducials.size());
  if (scan.found.status == Status::kFailed) {
    ++tally->failed;
    return;
  }
  if (scan.found.status == Status::kOk) ++tally->ok;
  if (scan.found.polarity != scan.truth.polarity) ++tally->polarity_wrong;
  const auto& possible = scan.found.possible_orientations;
  const ScanOrientation truth = scan.truth.orientation.value();
  if (possible.size() > 1) ++tally->orientation_open;
  if (std::find(possible.begin(), possible.end(), truth) == possible.end()) {
    ++tally->orientation_wrong;
    return;
  }
  const auto named = interior::InOrientation(scan.found, scan.camera.file,
                                             interior::ShapesOf(scan.camera.file), truth);
  AddMarks(scan, named.value(), tally);
  AddBetween(scan, named.value(), tally);
}

std::ostream& operator<<(std::ostream& out, const Tally& t) {
  return out << t.ok << " ok and " << t.failed << " failed of " << t.scans << " scans; " << t.used
             << " of " << t.marks << " marks used, " << t.wrong << " wrong; rms " << t.RmsPx()
             << " px, normalised " << t.RmsNormalised() << "; orientation open "
             << t.orientation_open << ", wrong " << t.orientation_wrong << "; polarity wrong "
             << t.polarity_wrong << "; between crosses " << t.RmsBetween_um() << " um";
}

// A scan in every scan orientation and both polarities, `rounds` times.
Tally AllWays(const Setting& setting, int rounds = 1) {
  Tally tally;
  Setting turned = setting;
  int number = 0;
  for (int round = 0; round < rounds; ++round)
    for (const ScanOrientation orientation : kAllScanOrientations)
      for (const Polarity polarity : {Polarity::kPositive, Polarity::kNegative}) {
        turned.options.orientation = orientation;
        turned.options.polarity = polarity;
        Add(ScanAndOrient(turned, ++number), &tally);
      }
  return tally;
}

// Every scan orientation once, positives and negatives in turn: where ways are not the point.
Tally EveryWayOnce(const Setting& setting) {
  Tally tally;
  Setting turned = setting;
  int number = 100;
  for (const ScanOrientation orientation : kAllScanOrientations) {
    turned.options.orientation = orientation;
    turned.options.polarity = ++number % 2 == 0 ? Polarity::kPositive : Polarity::kNegative;
    Add(ScanAndOrient(turned, number), &tally);
  }
  return tally;
}

constexpr double kNormalContrast_px = 0.05, kLowContrast_px = 0.1;

void ExpectNoneWrong(const Tally& tally) {
  std::cout << tally << "\n";
  EXPECT_EQ(tally.polarity_wrong, 0);
  EXPECT_EQ(tally.orientation_wrong, 0);
  EXPECT_EQ(tally.wrong, 0);
}

void ExpectNothingWrong(const Tally& tally, double most_px) {
  ExpectNoneWrong(tally);
  EXPECT_LE(tally.RmsPx(), most_px);
  EXPECT_GE(tally.RmsNormalised(), 0.8);
  EXPECT_LE(tally.RmsNormalised(), 1.25);
}

TEST(FilmScan, OnlyWhatInteriorOrientationLooksAtIsDrawn) {
  const TemporaryFolder folder;
  const Setting setting = Preset(CameraPreset::kRc10, 100);
  const SimulatedCamera camera = NewCamera(setting.options);
  const PhotoPlan plan = PlanPhoto(setting.options, camera, {}, false, 1);
  WriteFilmScan(folder / "scan.tif", setting.options, setting.film, camera, plan);
  const Raster scan = Raster::Open(folder / "scan.tif");
  EXPECT_EQ(scan.Width(), camera.width_px);
  EXPECT_NEAR(scan.DpiTag().value(), 254, 0.1);
  const int middle = camera.width_px / 2;
  EXPECT_EQ(scan.ReadGrey({middle, middle, 1, 1}).image.At(0, 0), 0);
  const Vector2d mark = plan.scan.PixelFromPhoto(camera.file.fiducials[0].position_mm);
  const Image around =
      scan.ReadGrey({static_cast<int>(mark.x()) - 8, static_cast<int>(mark.y()) - 8, 16, 16}).image;
  EXPECT_GT(*std::max_element(around.values.begin(), around.values.end()), 120);
  const PhotoPlan other = PlanPhoto(setting.options, camera, {}, false, 2);
  EXPECT_NE(TrueInterior(camera, plan).marks[0].pixel, TrueInterior(camera, other).marks[0].pixel);
}

TEST(FilmScan, ColourKeepsTheGreyValuesOrder) {
  const TemporaryFolder folder;
  Setting setting = Preset(CameraPreset::kUmk, 100);
  setting.film.rgb = true;
  const SimulatedCamera camera = NewCamera(setting.options);
  const PhotoPlan plan = PlanPhoto(setting.options, camera, {}, false, 1);
  WriteFilmScan(folder / "scan.tif", setting.options, setting.film, camera, plan);
  EXPECT_EQ(Raster::Open(folder / "scan.tif").Bands(), 3);
}

TEST(FilmScan, InteriorOfANumberedFilmIsTheTruth) {
  Setting setting = Preset(CameraPreset::kDemo, 50);
  setting.options.orientation = ScanOrientation::kM90;
  setting.options.polarity = Polarity::kNegative;
  const Scanned scan = ScanAndOrient(setting, 1);
  ASSERT_EQ(scan.found.status, Status::kOk);
  EXPECT_EQ(scan.found.orientation, ScanOrientation::kM90);
  EXPECT_EQ(scan.found.polarity, Polarity::kNegative);
  Tally tally;
  Add(scan, &tally);
  EXPECT_EQ(tally.used, 4);
  EXPECT_LE(tally.RmsPx(), kNormalContrast_px);
}

TEST(FilmScan, AMissingMarkIsReportedMissing) {
  Setting setting = Preset(CameraPreset::kDemo, 50);
  setting.options.missing_marks = 1;
  const Scanned scan = ScanAndOrient(setting, 2);
  Tally tally;
  Add(scan, &tally);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_NE(scan.found.status, Status::kOk);  // three of four are never enough
}

TEST(FilmScan, DamagedMarksAreRightOrNotUsed) {
  Setting setting = Preset(CameraPreset::kDemo, 50);
  setting.damage = {MarkCondition::kScratched, MarkCondition::kDusty, MarkCondition::kArmLost};
  Tally tally;
  Add(ScanAndOrient(setting, 4), &tally);
  EXPECT_EQ(tally.wrong, 0);
}

Setting Reseau() {
  Setting setting = Preset(CameraPreset::kReseau, 25);
  setting.options.film_bend_um = 30;
  return setting;
}

TEST(FilmScan, AReseausCrossesInThePictureCorrectTheFilm) {
  Setting setting = Reseau();
  setting.meshes = 2;
  setting.damage.assign(25, MarkCondition::kClean);
  setting.damage[6] = MarkCondition::kMissing;
  setting.damage[11] = MarkCondition::kDusty;
  Tally tally;
  Add(ScanAndOrient(setting, 1), &tally);
  std::cout << tally << "\n";
  EXPECT_EQ(tally.ok, 1);
  EXPECT_EQ(tally.wrong, 0);
  EXPECT_GE(tally.used, 19);
  EXPECT_LE(tally.RmsPx(), kNormalContrast_px);
  EXPECT_LT(tally.RmsBetween_um(), 3);
}

TEST(SlowSimulatedScans, Rc10) {
  const Tally tally = AllWays(Preset(CameraPreset::kRc10, 21));
  ExpectNothingWrong(tally, kNormalContrast_px);
  EXPECT_EQ(tally.used, tally.marks);
}

TEST(SlowSimulatedScans, Rc10LowContrast) {
  const Tally tally = EveryWayOnce(LowContrast(Preset(CameraPreset::kRc10, 21)));
  ExpectNothingWrong(tally, kLowContrast_px);
}

TEST(SlowSimulatedScans, Rc30WithSymbols) {
  const Tally tally = AllWays(Preset(CameraPreset::kRc30, 25));
  ExpectNothingWrong(tally, kNormalContrast_px);
  EXPECT_EQ(tally.ok, tally.scans);
  EXPECT_EQ(tally.orientation_open, 0);
}

TEST(SlowSimulatedScans, Rc30LowContrast) {
  const Tally tally = EveryWayOnce(LowContrast(Preset(CameraPreset::kRc30, 25)));
  ExpectNothingWrong(tally, kLowContrast_px);
  EXPECT_EQ(tally.orientation_open, 0);
}

TEST(SlowSimulatedScans, Lmk) {
  const Tally tally = EveryWayOnce(Preset(CameraPreset::kLmk, 25));
  ExpectNothingWrong(tally, kNormalContrast_px);
  EXPECT_EQ(tally.used, tally.marks);
  EXPECT_EQ(tally.orientation_open, 0);
}

TEST(SlowSimulatedScans, UmkInColour) {
  Setting setting = Preset(CameraPreset::kUmk, 12.5);
  setting.film.rgb = true;
  const Tally tally = EveryWayOnce(setting);
  ExpectNothingWrong(tally, kNormalContrast_px);
  EXPECT_EQ(tally.used, tally.marks);
}

TEST(SlowSimulatedScans, P31InClutter) {
  const Tally tally = EveryWayOnce(Preset(CameraPreset::kP31, 25));
  ExpectNothingWrong(tally, kNormalContrast_px);
}

TEST(SlowSimulatedScans, P31ByItsLinesIsMorePreciseThanByMatching) {
  Setting setting = Preset(CameraPreset::kP31, 25);
  setting.options.orientation = ScanOrientation::kR0;
  Tally lines, matched;
  for (int number = 1; number <= 4; ++number) {
    setting.locator = std::nullopt;
    Add(ScanAndOrient(setting, number), &lines);
    setting.locator = interior::LocatorKind::kNcc;
    Add(ScanAndOrient(setting, number), &matched);
  }
  std::cout << "lines: " << lines << "\nmatched: " << matched << "\n";
  EXPECT_LT(lines.RmsPx(), matched.RmsPx());
  EXPECT_GE(lines.used, matched.used);
}

// `usable`: the share of the crosses of which nothing is missing.
void ExpectGoodReseaus(const Tally& tally, double usable) {
  ExpectNothingWrong(tally, kNormalContrast_px);
  EXPECT_EQ(tally.ok, tally.scans);
  EXPECT_GT(tally.used, 0.88 * usable * tally.marks);
  EXPECT_LT(tally.RmsBetween_um(), 3);
}

TEST(SlowSimulatedScans, Reseau) { ExpectGoodReseaus(EveryWayOnce(Reseau()), 1); }

const std::vector<MarkCondition> kDamages = {MarkCondition::kScratched, MarkCondition::kDusty,
                                             MarkCondition::kArmLost, MarkCondition::kMissing};

TEST(SlowSimulatedScans, Rc30WithDirtyMarks) {
  Setting setting = Preset(CameraPreset::kRc30, 25);
  setting.damage = kDamages;
  const Tally tally = EveryWayOnce(setting);
  ExpectNoneWrong(tally);
}

TEST(SlowSimulatedScans, P31WithDirtyMarks) {
  Setting setting = Preset(CameraPreset::kP31, 25);
  setting.damage = {MarkCondition::kScratched, MarkCondition::kDusty, MarkCondition::kArmLost};
  const Tally tally = EveryWayOnce(setting);
  ExpectNoneWrong(tally);
}

TEST(SlowSimulatedScans, ReseauWithDirtyMarks) {
  Setting setting = Reseau();
  setting.damage.assign(121, MarkCondition::kClean);
  for (size_t i = 0; i < setting.damage.size(); i += 3)
    setting.damage[i] = kDamages[i / 3 % kDamages.size()];
  constexpr double kUsable = 5.0 / 6;  // a twelfth missing, another one without an arm
  ExpectGoodReseaus(EveryWayOnce(setting), kUsable);
}

}  // namespace
}  // namespace orient::simulation

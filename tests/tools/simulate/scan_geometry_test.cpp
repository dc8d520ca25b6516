#include "tools/simulate/scan_geometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/rotation.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;

constexpr double kExact_px = 1e-9;

ScanSetup Plain(ScanOrientation orientation) {
  ScanSetup setup;
  setup.width = 600;
  setup.height = 400;
  setup.pixel_size_mm = 0.1;
  setup.orientation = orientation;
  setup.half_frame_mm = 15;
  return setup;
}

void ExpectPixel(ScanOrientation orientation, double col, double row) {
  // On the positive this point lies 12 mm right of and 5 mm above the centre (300, 200).
  const Vector2d pixel = ScanGeometry(Plain(orientation)).PixelFromPhoto(Vector2d(12, 5));
  EXPECT_NEAR(pixel.x(), col, kExact_px) << Name(orientation);
  EXPECT_NEAR(pixel.y(), row, kExact_px) << Name(orientation);
}

TEST(ScanGeometry, EachOrientationPutsAPointOfTheUpperRightWhereTheWordsSay) {
  ExpectPixel(ScanOrientation::kR0, 420, 150);    // upper right
  ExpectPixel(ScanOrientation::kR90, 250, 80);    // turned counter-clockwise: upper left
  ExpectPixel(ScanOrientation::kR180, 180, 250);  // lower left
  ExpectPixel(ScanOrientation::kR270, 350, 320);  // lower right
  ExpectPixel(ScanOrientation::kM0, 180, 150);    // mirrored left-right: upper left
  ExpectPixel(ScanOrientation::kM90, 250, 320);   // and turned counter-clockwise: lower left
  ExpectPixel(ScanOrientation::kM180, 420, 250);  // lower right
  ExpectPixel(ScanOrientation::kM270, 350, 80);   // upper right
}

TEST(ScanGeometry, AgreesWithTheLibrarysAxes) {
  for (const ScanOrientation orientation : kAllScanOrientations) {
    const Affine2d affine = ScanGeometry(Plain(orientation)).BestAffine();
    EXPECT_LT((affine.A - 0.1 * PhotoFromPixelAxes(orientation)).norm(), 1e-12)
        << Name(orientation);
    EXPECT_EQ(NearestScanOrientation(affine), orientation);
  }
}

TEST(ScanGeometry, SmallTurnIsCounterClockwiseInTheScan) {
  ScanSetup setup = Plain(ScanOrientation::kR0);
  setup.rotation_rad = RadFromDeg(2);
  const Vector2d right = ScanGeometry(setup).PixelFromPhoto(Vector2d(10, 0));
  EXPECT_NEAR(right.x(), 300 + 100 * std::cos(RadFromDeg(2)), kExact_px);
  EXPECT_NEAR(right.y(), 200 - 100 * std::sin(RadFromDeg(2)), kExact_px);  // up: smaller row
}

TEST(ScanGeometry, ShiftMovesTheFilmRightAndUp) {
  ScanSetup setup = Plain(ScanOrientation::kM90);
  setup.shift_mm = {0.3, 0.2};
  const Vector2d centre = ScanGeometry(setup).PixelFromPhoto(Vector2d(0, 0));
  EXPECT_NEAR(centre.x(), 303, kExact_px);
  EXPECT_NEAR(centre.y(), 198, kExact_px);
}

TEST(ScanGeometry, RoundtripWithDeformedFilm) {
  ScanSetup setup = Plain(ScanOrientation::kM270);
  setup.rotation_rad = RadFromDeg(-0.7);
  setup.shift_mm = {0.31, -0.12};
  setup.stretch << 1.0004, 0.0002, -0.0001, 0.9993;
  setup.bend = RandomBend(setup.half_frame_mm, 8, 5);
  const ScanGeometry scan(setup);
  for (const Vector2d& photo : {Vector2d(0, 0), Vector2d(14, -13), Vector2d(-7, 15)}) {
    EXPECT_LT((scan.PhotoFromPixel(scan.PixelFromPhoto(photo)) - photo).norm(), 1e-9);
    EXPECT_LT((scan.BestAffine() * scan.PixelFromPhoto(photo) - photo).norm(), 0.05);
  }
}

TEST(ScanGeometry, BendHasTheSizeAskedFor) {
  constexpr double kWanted_um = 6;
  ScanSetup setup = Plain(ScanOrientation::kR0);
  EXPECT_LT(ScanGeometry(setup).BendRms(), 1e-12);  // a flat film is affine
  setup.bend = RandomBend(setup.half_frame_mm, kWanted_um, 7);
  EXPECT_NEAR(ScanGeometry(setup).BendRms() * 1e3, kWanted_um, 0.01);
}

}  // namespace
}  // namespace orient::simulation

#include "interior/constellation/layout.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <stdexcept>

#include "interior/interior.h"
#include "tests/support/film_frame.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

CameraFile WithExtraMark(const Vector2d& position_mm) {
  CameraFile camera = RingCamera();
  camera.fiducials.push_back({"5", position_mm, "corner", std::nullopt});
  return camera;
}

TEST(OrientationClasses, FourCornersLeaveAllEightOpenUnmirroredFirst) {
  const CameraFile camera = RingCamera();
  const auto classes = OrientationClasses(camera.fiducials, ShapesOf(camera));
  ASSERT_EQ(classes.size(), 1u);
  EXPECT_EQ(classes[0], OrientationClass(kAllScanOrientations.begin(), kAllScanOrientations.end()));
}

TEST(OrientationClasses, ANearlySquareLayoutIsOpenTooAsScannersDifferInScale) {
  CameraFile camera = RingCamera();
  for (Fiducial& f : camera.fiducials) f.position_mm.y() *= 1.01;
  EXPECT_EQ(OrientationClasses(camera.fiducials, ShapesOf(camera)).size(), 1u);
  for (Fiducial& f : camera.fiducials) f.position_mm.y() *= 1.2;
  const auto classes = OrientationClasses(camera.fiducials, ShapesOf(camera));
  ASSERT_EQ(classes.size(), 2u);  // lying along or across; each in four ways
  EXPECT_EQ(classes[0].size(), 4u);
}

TEST(OrientationClasses, AMarkOnOneSideTellsThemApart) {
  const CameraFile on_axis = WithExtraMark({106, 0});
  EXPECT_EQ(OrientationClasses(on_axis.fiducials, ShapesOf(on_axis)).size(), 4u);
  const CameraFile off_axis = WithExtraMark({106, 30});
  EXPECT_EQ(OrientationClasses(off_axis.fiducials, ShapesOf(off_axis)).size(), 8u);
}

TEST(OrientationClasses, DifferentDrawingsTellThemApart) {
  CameraFile camera = RingCamera();
  camera.marks["other"].elements = {CrossElement{4, 0.2, 0, 0}};
  camera.fiducials[0].mark = "other";
  const auto classes = OrientationClasses(camera.fiducials, ShapesOf(camera));
  ASSERT_EQ(classes.size(), 4u);  // a mirroring at the diagonal stays
  for (const auto& members : classes) EXPECT_EQ(members.size(), 2u);
}

TEST(Relabel, FollowsTheCornersRound) {
  const CameraFile camera =
      RingCamera();  // 1 lower left, 2 upper right, 3 upper left, 4 lower right
  const auto relabel =
      Relabel(camera.fiducials, ShapesOf(camera), ScanOrientation::kR0, ScanOrientation::kR90);
  ASSERT_TRUE(relabel);
  // The scan shows the positive turned counter-clockwise by 90 degrees: what lies at the scan's
  // lower left is the positive's upper left.
  EXPECT_EQ(*relabel, (std::vector<int>{2, 3, 1, 0}));
}

// Notches that point outwards are drawn one by one, and a turn of the film makes each the next.
TEST(Relabel, KnowsANotchOnTheNextSideAsTheSameNotchTurned) {
  CameraFile camera = RingCamera();
  const double quarter = 0.5 * std::numbers::pi;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "notch" + std::to_string(i);
    camera.marks[name].elements = {WedgeElement{1.4, 1.4, i * quarter}};
    camera.fiducials[i].mark = name;
    camera.fiducials[i].position_mm = Eigen::Rotation2Dd(i * quarter) * Vector2d(106, 0);
  }
  const auto classes = OrientationClasses(camera.fiducials, ShapesOf(camera));
  ASSERT_EQ(classes.size(), 1u);
  EXPECT_EQ(classes[0].size(), 8u);
  camera.marks["notch2"].elements = {WedgeElement{1.4, 1.4, 0}};  // points inwards
  EXPECT_EQ(OrientationClasses(camera.fiducials, ShapesOf(camera)).size(), 4u);
}

TEST(PlaceOnScan, RowsCountDownwards) {
  const MarkRectangle rectangle{{1, 2}, {212, 212}};
  EXPECT_TRUE(
      PlaceOnScan({107, 108}, rectangle, ScanOrientation::kR0).isApprox(Vector2d(106, -106)));
  EXPECT_TRUE(
      PlaceOnScan({107, 108}, rectangle, ScanOrientation::kR90).isApprox(Vector2d(-106, -106)));
}

TEST(SearchWindow, IsJiangsRange) {
  // 240 mm scan of 0.1 mm pixels, rectangle 212 mm: the mark moves by +-14 mm.
  const PixelWindow w = SearchWindow({-106, -106}, {212, 212}, {2400, 2400}, 0.1, 0);
  EXPECT_EQ(w.col, 0);
  EXPECT_EQ(w.width, 280);
  EXPECT_EQ(w.row, 0);
}

TEST(SearchWindow, IsNeverLessThan15MillimetresExceptAtTheScansBorder) {
  const PixelWindow w = SearchWindow({0, 0}, {212, 212}, {2120, 2120}, 0.1, 0);
  EXPECT_EQ(w.width, 150);
  EXPECT_EQ(w.col, 1060 - 75);
  const PixelWindow outside = SearchWindow({-200, 0}, {212, 212}, {2120, 2120}, 0.1, 0);
  EXPECT_EQ(outside.width, 0);
}

TEST(RectangleOfMarks, NeedsMarks) { EXPECT_THROW(RectangleOfMarks({}), std::invalid_argument); }

}  // namespace
}  // namespace orient::interior

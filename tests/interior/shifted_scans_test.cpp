// One film at every whole-pixel place on its scan: the same marks are found at the same places of
// the film. Strides, levels of the pyramid, windows and the suppression of neighbours must not
// show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "interior/interior.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr int kShifts = 16;  // per axis
constexpr double kPixelMm = 0.06;

// What all shifts of one film have in common, and how far a mark's places are from their mean.
struct Spread {
  int scans = 0;
  std::vector<int> used;  // scans per mark
  std::vector<std::vector<Vector2d>> places;
  int not_ok = 0;

  double Largest() const {
    double largest = 0;
    for (const auto& of_mark : places) {
      Vector2d mean = Vector2d::Zero();
      for (const Vector2d& p : of_mark) mean += p / static_cast<double>(of_mark.size());
      for (const Vector2d& p : of_mark) largest = std::max(largest, (p - mean).norm());
    }
    return largest;
  }
};

Image Cropped(const Image& image, int left, int top) {
  Image cut(image.width - kShifts, image.height - kShifts);
  for (int row = 0; row < cut.height; ++row)
    std::copy_n(image.Row(row + top) + left, cut.width, cut.Row(row));
  return cut;
}

class ShiftedScans : public testing::Test {
 protected:
  // Every `step`-th shift per axis.
  Spread Measure(const FilmFrame& frame, const CameraFile& camera, int step) {
    const MarkShapes shapes = ShapesOf(camera, pictures_);
    Spread spread;
    spread.used.resize(camera.fiducials.size());
    spread.places.resize(camera.fiducials.size());
    InteriorOptions options;
    options.pixel_size_um = 1e3 * kPixelMm;
    options.orientation = ScanOrientation::kR0;
    for (int top = 0; top < kShifts; top += step)
      for (int left = 0; left < kShifts; left += step) {
        WriteScan(folder_ / "scan.png", Cropped(frame.scan, left, top));
        const InteriorResult result =
            OrientInterior(Raster::Open(folder_ / "scan.png"), camera, shapes, options);
        ++spread.scans;
        if (result.status != Status::kOk) ++spread.not_ok;
        for (size_t i = 0; i < result.marks.size(); ++i) {
          if (result.marks[i].state != MarkState::kUsed) continue;
          ++spread.used[i];
          spread.places[i].push_back(*result.marks[i].pixel + Vector2d(left, top));
        }
      }
    return spread;
  }

  static void ExpectTheSame(const Spread& spread) {
    EXPECT_EQ(spread.not_ok, 0) << "of " << spread.scans;
    for (size_t i = 0; i < spread.used.size(); ++i) EXPECT_EQ(spread.used[i], spread.scans) << i;
    EXPECT_LT(spread.Largest(), 0.02);
  }

  static FilmFrame Film(const CameraFile& camera, bool dark_corners) {
    FilmFrameSpec spec;
    spec.camera = camera;
    spec.pixel_mm = kPixelMm;
    spec.dark_corners = dark_corners;
    spec.turn_rad = 0.006;
    spec.shift_px = {2.4, -3.7};
    spec.noise = 3;
    spec.seed = 12;
    return RenderFilmFrame(spec);
  }

  void ExpectSameRings(int step) {
    const CameraFile camera = RingCamera(30, 70);
    ExpectTheSame(Measure(Film(camera, true), camera, step));
  }

  // Thin strokes, a pixel wide.
  void ExpectSameThinCrosses(int step) {
    CameraFile camera = RingCamera(30, 70);
    camera.marks["corner"].elements = {CrossElement{3.0, kPixelMm, 0, 0}};
    ExpectTheSame(Measure(Film(camera, true), camera, step));
  }

  // Teeth, each pointing to the frame's middle.
  void ExpectSameNotches(int step) {
    CameraFile camera = RingCamera(30, 70);
    camera.marks.clear();
    for (Fiducial& f : camera.fiducials) {
      f.mark = "notch " + f.id;
      const Vector2d inwards = -f.position_mm;
      camera.marks[f.mark].elements = {
          WedgeElement{1.8, 1.8, std::atan2(inwards.y(), inwards.x())}};
    }
    ExpectTheSame(Measure(Film(camera, true), camera, step));
  }

  // Pictures of the marks, cut out of this very scan.
  void ExpectSamePictures(int step) {
    constexpr int kHalf = 34;
    const CameraFile drawn = RingCamera(30, 70);
    const FilmFrame frame = Film(drawn, true);
    CameraFile camera = drawn;
    camera.marks.clear();
    for (size_t i = 0; i < camera.fiducials.size(); ++i) {
      const std::string name = "cut " + camera.fiducials[i].id;
      camera.fiducials[i].mark = name;
      const Vector2d at = frame.mark_pixels[i];
      const Vector2d corner = at.array().floor() - kHalf;
      Image picture(2 * kHalf + 1, 2 * kHalf + 1);
      for (int row = 0; row < picture.height; ++row)
        std::copy_n(
            frame.scan.Row(static_cast<int>(corner.y()) + row) + static_cast<int>(corner.x()),
            picture.width, picture.Row(row));
      camera.marks[name].image = MarkImage{name, kPixelMm, at - corner};
      pictures_[name] = picture;
    }
    ExpectTheSame(Measure(frame, camera, step));
  }

  TemporaryFolder folder_;
  std::map<std::string, Image> pictures_;
};
using SlowShiftedScans = ShiftedScans;

TEST_F(ShiftedScans, ShowTheSameRings) { ExpectSameRings(7); }
TEST_F(ShiftedScans, ShowTheSamePictures) { ExpectSamePictures(7); }

TEST_F(SlowShiftedScans, All256ShowTheSameRings) { ExpectSameRings(1); }
TEST_F(SlowShiftedScans, All256ShowTheSameThinCrosses) { ExpectSameThinCrosses(1); }
TEST_F(SlowShiftedScans, All256ShowTheSameNotches) { ExpectSameNotches(1); }
TEST_F(SlowShiftedScans, All256ShowTheSamePictures) { ExpectSamePictures(1); }

}  // namespace
}  // namespace orient::interior

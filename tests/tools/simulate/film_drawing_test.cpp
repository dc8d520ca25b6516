#include "tools/simulate/film_drawing.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tools/simulate/cameras.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;

struct Film {
  SimulatedCamera camera;
  ScanGeometry scan;
  FilmFrame frame;
};

Film MakeFilm(SimulationOptions options, ScanOrientation orientation) {
  options.pixel_size_um = 50;
  const SimulatedCamera camera = NewCamera(options);
  ScanSetup setup;
  setup.width = camera.width_px;
  setup.height = camera.height_px;
  setup.pixel_size_mm = camera.pixel_size_mm;
  setup.orientation = orientation;
  setup.rotation_rad = 0.008;
  setup.shift_mm = {0.1, -0.13};
  setup.half_frame_mm = 28;
  FilmFrame frame;
  frame.camera = camera.file;
  frame.film_half_mm = camera.film_half_mm;
  frame.conditions.assign(camera.file.fiducials.size(), MarkCondition::kClean);
  return {camera, ScanGeometry(setup), frame};
}

Image Draw(const Film& film, float tone) {
  Image image(film.camera.width_px, film.camera.height_px, tone);
  DrawFilm(film.frame, film.scan, 0, &image);
  return image;
}

float ValueAt(const Image& image, const ScanGeometry& scan, const Vector2d& photo_mm) {
  const Vector2d pixel = scan.PixelFromPhoto(photo_mm);
  return image.At(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
}

// Centroid of what is brighter than the mark's dark surroundings.
Vector2d BrightCentroid(const Image& image, const Vector2d& centre, int reach_px) {
  Vector2d sum(0, 0);
  double total = 0;
  for (int row = static_cast<int>(centre.y()) - reach_px; row <= centre.y() + reach_px; ++row)
    for (int col = static_cast<int>(centre.x()) - reach_px; col <= centre.x() + reach_px; ++col) {
      const double bright = std::max(0.0, static_cast<double>(image.At(col, row)) - 0.06);
      sum += bright * Vector2d(col + 0.5, row + 0.5);
      total += bright;
    }
  return sum / total;
}

TEST(FilmDrawing, MarksLieAtTheirTruePixels) {
  constexpr double kWanted_px = 0.01;  // what the samples leave of a thin ring
  for (const ScanOrientation orientation : {ScanOrientation::kR0, ScanOrientation::kM270}) {
    const Film film = MakeFilm({}, orientation);
    const Image image = Draw(film, 0.4f);
    for (const Fiducial& fiducial : film.frame.camera.fiducials) {
      const Vector2d pixel = film.scan.PixelFromPhoto(fiducial.position_mm);
      EXPECT_LT((BrightCentroid(image, pixel, 25) - pixel).norm(), kWanted_px) << fiducial.id;
    }
  }
}

TEST(FilmDrawing, MissingMarkLeavesItsPlaceDark) {
  Film film = MakeFilm({}, ScanOrientation::kR0);
  film.frame.conditions[2] = MarkCondition::kMissing;
  const Image image = Draw(film, 0.4f);
  EXPECT_LT(ValueAt(image, film.scan, film.frame.camera.fiducials[2].position_mm), 0.1f);
  EXPECT_GT(ValueAt(image, film.scan, film.frame.camera.fiducials[1].position_mm), 0.9f);
}

TEST(FilmDrawing, DataStripIsOnThePhotosLeftSideOnly) {
  const Film film = MakeFilm({}, ScanOrientation::kR0);
  const Image image = Draw(film, 0.4f);
  int left = 0, right = 0, top = 0;
  for (double along = -25; along < 25; along += 0.05) {
    left += ValueAt(image, film.scan, {-28.9, along}) > 0.5f ? 1 : 0;
    right += ValueAt(image, film.scan, {28.9, along}) > 0.5f ? 1 : 0;
    top += ValueAt(image, film.scan, {along, 28.9}) > 0.5f ? 1 : 0;
  }
  EXPECT_GT(left, 30);
  EXPECT_EQ(right, 0);
  EXPECT_EQ(top, 0);
}

TEST(FilmDrawing, SymbolsCountTheMarks) {
  SimulationOptions options;
  options.mark_symbols = true;
  const Film film = MakeFilm(options, ScanOrientation::kR0);
  const Image image = Draw(film, 0.4f);
  for (size_t i = 0; i < film.frame.camera.fiducials.size(); ++i) {
    const Fiducial& fiducial = film.frame.camera.fiducials[i];
    EXPECT_EQ(fiducial.symbol->count, static_cast<int>(i) + 1);
    const Vector2d last = fiducial.position_mm + *fiducial.symbol->at_mm +
                          static_cast<double>(i) * *fiducial.symbol->step_mm;
    EXPECT_GT(ValueAt(image, film.scan, last), 0.8f);
    EXPECT_LT(ValueAt(image, film.scan, last + *fiducial.symbol->step_mm), 0.8f);
  }
}

TEST(FilmDrawing, CrossWithAGapIsOpenInTheMiddle) {
  MarkDrawing drawing;
  drawing.elements = {CrossElement{2.0, 0.1, 0.5, 0}};
  EXPECT_EQ(MarkBrightness(drawing, {0, 0}), 0);
  EXPECT_EQ(MarkBrightness(drawing, {0.3, 0.04}), 1);
  EXPECT_EQ(MarkBrightness(drawing, {-0.04, -0.99}), 1);
  EXPECT_EQ(MarkBrightness(drawing, {1.01, 0}), 0);
  EXPECT_EQ(MarkBrightness(drawing, {0.5, 0.06}), 0);
}

}  // namespace
}  // namespace orient::simulation

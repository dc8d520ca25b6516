// Do the speed-ups of Kersten & Haering's modified Hough transform still pay off?
//
//   hough_speed [WINDOWS]
//
// Prints the processor time for searching a 15 mm window at 25 um for a ring with a cross, also as
// a multiple of the coarse-to-fine search (a correlation at the resolution used by the locator,
// with its best positions refined), and how often the best position is the mark. Compared are the
// paper's sums of grey values under vectors, as published: at every pixel, at every second one, and
// with a half or a quarter of the vectors. The window is a texture of rectangles with grain; the
// mark is drawn faintly into it.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <numbers>
#include <random>
#include <string>

#include "core/matching/correlation.h"
#include "core/matching/spot_correlation.h"
#include "core/raster/resample.h"
#include "interior/locators/hough_locator.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kSide = 700;  // 15 mm, and a margin for the arms of the mark
constexpr double kPixelMm = 0.025;
constexpr double kReduction = 4;  // to about 32 pixels over the mark, as the locator does

double ProcessorMs() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

interior::MarkShape RingWithCross() {
  interior::MarkShape shape;
  shape.drawing.elements = {CircleElement{1.7, 0.2},
                            CrossElement{3.5, 0.13, 0.56, std::numbers::pi / 4}};
  return shape;
}

Matrix2d PixelFromMm(double pixel_mm) {
  return Matrix2d(Vector2d(1 / pixel_mm, -1 / pixel_mm).asDiagonal());
}

struct Window {
  Image image;
  Vector2d truth;
};

Window MakeWindow(const interior::MarkShape& shape, std::mt19937* random) {
  std::uniform_real_distribution<double> place(100, kSide - 100), grey(40, 200), size(10, 80);
  std::normal_distribution<float> grain(0, 12);
  Window window{Image(kSide, kSide, 90), {place(*random), place(*random)}};
  for (int k = 0; k < 150; ++k) {
    const Vector2d at(place(*random) - 50, place(*random) - 50);
    const int right = std::min(kSide, static_cast<int>(at.x() + size(*random)));
    const int bottom = std::min(kSide, static_cast<int>(at.y() + size(*random)));
    const auto value = static_cast<float>(grey(*random));
    for (int row = static_cast<int>(at.y()); row < bottom; ++row)
      for (int col = static_cast<int>(at.x()); col < right; ++col)
        window.image.At(col, row) = value;
  }
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col) {
      const Vector2d mm = kPixelMm * (Vector2d(col + 0.5, row + 0.5) - window.truth);
      if (mm.norm() < 2.5) window.image.At(col, row) = 30;  // a dark corner
      if (interior::StrokeDistance(shape.drawing, mm) < 0) window.image.At(col, row) += 40;
      window.image.At(col, row) += grain(*random);
    }
  return window;
}

// The locator's method: correlation at half the reduced resolution, then refinement of the best.
Vector2d CoarseToFine(const interior::MarkShape& shape, const Image& image) {
  const Image fine = ReduceBy(image, kReduction), coarse = ReduceBy(fine, 2);
  const interior::MarkTemplate full =
      interior::SkeletonTemplate(shape, PixelFromMm(kReduction * kPixelMm));
  const interior::MarkTemplate half =
      interior::SkeletonTemplate(shape, PixelFromMm(2 * kReduction * kPixelMm));
  constexpr int kPlaces = 30, kAround = 2;
  const SpotTemplate spot(full.values);
  const SpotImage places(fine);
  double best = -1;
  Vector2d found = Vector2d::Zero();
  for (const Peak& peak : FindPeaks(Correlate(half.values, coarse), kPlaces, 3, 0)) {
    const Vector2d corner = (2 * (peak.position + half.centre) - full.centre).array().round();
    for (int dr = -kAround; dr <= kAround; ++dr)
      for (int dc = -kAround; dc <= kAround; ++dc) {
        const Vector2d at = corner + Vector2d(dc, dr);
        const double score =
            places.Correlate(spot, static_cast<int>(at.x()), static_cast<int>(at.y()), 0.7);
        if (!(score > best)) continue;
        best = score;
        found = kReduction * (at + full.centre);
      }
  }
  return found;
}

// The paper's method: at every `step`th pixel in both directions, with every `share`th vector.
Vector2d SumsUnderVectors(const interior::MarkShape& shape, const Image& image, int step,
                          size_t share) {
  const interior::MarkTemplate skeleton = interior::SkeletonTemplate(shape, PixelFromMm(kPixelMm));
  const auto width = static_cast<std::ptrdiff_t>(image.width);
  std::vector<std::ptrdiff_t> on, beside;
  for (int row = 0; row < skeleton.values.height; ++row)
    for (int col = 0; col < skeleton.values.width; ++col) {
      const float value = skeleton.values.At(col, row);
      if (std::isnan(value)) continue;
      (value > 0 ? on : beside).push_back(row * width + col);
    }
  const auto mean = [&](const float* corner, const std::vector<std::ptrdiff_t>& vectors) {
    float sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < vectors.size(); i += share, ++count) sum += corner[vectors[i]];
    return sum / static_cast<float>(count);
  };
  float best = -1e9F;
  Vector2d found = Vector2d::Zero();
  for (int row = 0; row + skeleton.values.height <= image.height; row += step)
    for (int col = 0; col + skeleton.values.width <= image.width; col += step) {
      const float* corner = image.Row(row) + col;
      const float score = mean(corner, on) - mean(corner, beside);
      if (score <= best) continue;
      best = score;
      found = Vector2d(col, row) + skeleton.centre;
    }
  return found;
}

struct Method {
  std::string name;
  int step = 0;  // 0: coarse to fine
  size_t share = 1;
  double ms = 0;
  int hits = 0;
};

void Run(int windows) {
  const interior::MarkShape shape = RingWithCross();
  std::vector<Method> methods = {{"coarse to fine"},
                                 {"vectors, every pixel", 1, 1},
                                 {"every second pixel", 2, 1},
                                 {"every second pixel, half the vectors", 2, 2},
                                 {"every second pixel, a quarter of the vectors", 2, 4}};
  std::mt19937 random(7);
  for (int i = 0; i < windows; ++i) {
    const Window window = MakeWindow(shape, &random);
    for (Method& method : methods) {
      const double start = ProcessorMs();
      const Vector2d found = method.step == 0
                                 ? CoarseToFine(shape, window.image)
                                 : SumsUnderVectors(shape, window.image, method.step, method.share);
      method.ms += ProcessorMs() - start;
      constexpr double kNearPx = 8;
      if ((found - window.truth).norm() < kNearPx) ++method.hits;
    }
  }
  for (const Method& method : methods)
    std::printf("%-46s %8.1f ms  %6.1f x  found %d of %d\n", method.name.c_str(),
                method.ms / windows, method.ms / methods.front().ms, method.hits, windows);
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  constexpr int kWindows = 20;
  orient::Run(argc > 1 ? std::max(1, std::atoi(argv[1])) : kWindows);
  return 0;
}

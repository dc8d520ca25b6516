#include "interior/orientation/reseau_result.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "interior/orientation/reseau.h"
#include "tests/support/film_frame.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr int kSide = 5;
constexpr double kPixel_mm = 0.02;

CameraFile Crosses() {
  CameraFile camera = RingCamera();
  camera.fiducials.clear();
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col)
      camera.fiducials.push_back({std::to_string(camera.fiducials.size() + 1),
                                  Vector2d(20.0 * col - 40, 20.0 * row - 40), "corner",
                                  std::nullopt});
  return camera;
}

// Crosses whose errors have no scale of their own: some 10 um, some a tenth of a millimetre.
InteriorResult Scattered(const CameraFile& camera, unsigned seed) {
  std::mt19937 random(seed);
  std::cauchy_distribution<double> error_mm(0, 0.012);
  InteriorResult result;
  for (const Fiducial& fiducial : camera.fiducials) {
    MarkResult mark;
    mark.id = fiducial.id;
    mark.state = MarkState::kUsed;
    const Vector2d seen = fiducial.position_mm + Vector2d(error_mm(random), error_mm(random));
    mark.pixel = Vector2d(3000 + seen.x() / kPixel_mm, 3000 - seen.y() / kPixel_mm);
    result.marks.push_back(mark);
  }
  EXPECT_TRUE(FitUsedMarks(camera, false, &result));
  return result;
}

int Used(const InteriorResult& result) {
  return static_cast<int>(
      std::count_if(result.marks.begin(), result.marks.end(),
                    [](const MarkResult& mark) { return mark.state == MarkState::kUsed; }));
}

TEST(ReseauResult, CrossesThatContradictOneAnotherToTheEndStayAsTheyWere) {
  const CameraFile camera = Crosses();
  int begun = 0;  // where a first round takes crosses out, and a later one explains nothing
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const InteriorResult before = Scattered(camera, seed);
    std::vector<MeasuredMark> marks;
    for (size_t i = 0; i < before.marks.size(); ++i)
      marks.push_back({*before.marks[i].pixel, camera.fiducials[i].position_mm});
    const auto first = FitReseau(marks, *before.photo_from_pixel);
    InteriorResult after = before;
    CorrectFilm(camera, false, &after);
    if (after.reseau) {
      EXPECT_EQ(Used(after), after.reseau->crosses);
      continue;
    }
    if (first) ++begun;
    EXPECT_EQ(Used(after), Used(before));
    EXPECT_EQ(after.photo_from_pixel->A, before.photo_from_pixel->A);
    EXPECT_EQ(after.sigma0_um, before.sigma0_um);
  }
  EXPECT_GT(begun, 0);
}

}  // namespace
}  // namespace orient::interior

// What the marks say of the film between them.
#include "block/inputs/film_positions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "interior/interior.h"
#include "tests/support/film_frame.h"

namespace orient::block {
namespace {

// A photo whose marks lie off their calibrated places: outwards and inwards by turns, as no affine
// transform can follow.
InteriorResult PhotoWithMarksOff(const CameraFile& camera, double off_mm) {
  InteriorResult photo;
  photo.status = Status::kOk;
  photo.photo_from_pixel = Affine2d{Eigen::Vector2d(0.02, -0.02).asDiagonal(), {-100, 100}};
  photo.orientation = ScanOrientation::kR0;
  photo.possible_orientations = {ScanOrientation::kR0};
  double sign = 1;
  for (const Fiducial& fiducial : camera.fiducials) {
    const Eigen::Vector2d at =
        fiducial.position_mm + sign * off_mm * fiducial.position_mm.normalized();
    photo.marks.push_back({fiducial.id, MarkState::kUsed, photo.photo_from_pixel->Inverse() * at,
                           Eigen::Vector2d(0.02, 0.02), std::nullopt, 0.9});
    sign = -sign;
  }
  return photo;
}

class FilmOf : public testing::Test {
 protected:
  double Sigma_mm(double off_mm) const {
    const auto positions =
        FilmPositions(PhotoWithMarksOff(camera_, off_mm), camera_, interior::ShapesOf(camera_));
    EXPECT_EQ(positions.size(), 1u);
    return positions.front().film_sigma_mm;
  }
  CameraFile camera_ = RingCamera(100, 210);
};

TEST_F(FilmOf, AGoodScanBendsAsGoodFilmDoes) {
  EXPECT_EQ(Sigma_mm(0), kFilmSigma_mm);
  EXPECT_EQ(Sigma_mm(0.005), kFilmSigma_mm) << "the marks' own errors";
}

TEST_F(FilmOf, MarksThatFitExactlyAreAsPreciseAsGoodFilm) {
  const auto positions =
      FilmPositions(PhotoWithMarksOff(camera_, 0), camera_, interior::ShapesOf(camera_));
  const double shift_mm = std::sqrt(positions.front().covariance(4, 4));
  EXPECT_GT(shift_mm, 0.0005);
  EXPECT_LT(shift_mm, 0.01);
}

TEST_F(FilmOf, ADesktopScannerBendsAsItsMarksShow) {
  EXPECT_GT(Sigma_mm(0.2), 0.08);
  EXPECT_LT(Sigma_mm(0.2), 0.4);
}

TEST_F(FilmOf, WhatTheMarksShowBeyondTheirOwnErrorsGrowsFromNothing) {
  EXPECT_LT(Sigma_mm(0.012), 2 * kFilmSigma_mm);
  EXPECT_GT(Sigma_mm(0.03), Sigma_mm(0.02));
}

}  // namespace
}  // namespace orient::block

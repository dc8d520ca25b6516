#include "interior/orientation/reseau.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kHalf_mm = 100;
constexpr double kPixel_mm = 0.02;

// A film bent by long waves of random direction and phase (not the estimator's own model), scaled
// so that what is left after the best affine has this root mean square of the vector.
class BentFilm {
 public:
  BentFilm(double rms_um, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 4; ++i)
      waves_.push_back({Vector2d(unit(random), unit(random)),
                        Vector2d(unit(random), unit(random)) * std::numbers::pi / kHalf_mm / 1.2,
                        3 * unit(random)});
    std::vector<PointPair2d> pairs;
    for (double x = -kHalf_mm; x <= kHalf_mm; x += 20)
      for (double y = -kHalf_mm; y <= kHalf_mm; y += 20) pairs.push_back({{x, y}, Raw({x, y})});
    const auto fit = FitAffine(pairs);
    trend_ = fit->transform;
    double squares = 0;
    for (const Vector2d& v : fit->residuals) squares += v.squaredNorm();
    scale_mm_ = 1e-3 * rms_um / std::sqrt(squares / static_cast<double>(pairs.size()));
  }
  // mm, at a place in mm.
  Vector2d At(const Vector2d& mm) const { return scale_mm_ * (Raw(mm) - trend_ * mm); }

 private:
  struct Wave {
    Vector2d amplitude, number;
    double phase;
  };
  Vector2d Raw(const Vector2d& mm) const {
    Vector2d sum = Vector2d::Zero();
    for (const Wave& w : waves_) sum += w.amplitude * std::sin(w.number.dot(mm) + w.phase);
    return sum;
  }
  std::vector<Wave> waves_;
  Affine2d trend_;
  double scale_mm_ = 0;
};

struct Frame {
  std::vector<MeasuredMark> marks;
  std::vector<bool> outlier;
  Affine2d affine;  // fitted to the marks, as the interior orientation does
  BentFilm film;
};

Vector2d PixelOf(const Vector2d& film_mm) {
  return {5200 + film_mm.x() / kPixel_mm, 5100 - film_mm.y() / kPixel_mm};
}

// side x side crosses; a part is missing, a part is wrong by up to a millimetre.
Frame Simulate(int side, double rms_um, double noise_um, unsigned seed, double missing = 0,
               double wrong = 0) {
  Frame frame{{}, {}, {}, BentFilm(rms_um, seed)};
  std::mt19937 random(seed + 1000);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<PointPair2d> pairs;
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col) {
      const Vector2d photo =
          kHalf_mm * Vector2d(2.0 * col / (side - 1) - 1, 2.0 * row / (side - 1) - 1);
      Vector2d seen =
          photo - frame.film.At(photo) + 1e-3 * noise_um * Vector2d(normal(random), normal(random));
      const bool gone = unit(random) < missing, bad = unit(random) < wrong;
      const Vector2d off(unit(random) - 0.5, unit(random) - 0.5);
      if (gone) continue;
      if (bad) seen += off.normalized() * (0.15 + 0.85 * off.norm());
      frame.marks.push_back({PixelOf(seen), photo});
      frame.outlier.push_back(bad);
      pairs.push_back({frame.marks.back().pixel, photo});
    }
  frame.affine = FitAffine(pairs)->transform;
  return frame;
}

struct Errors {
  double before_um = 0, after_um = 0;
};

// At places between the crosses, none of which was used.
Errors ErrorsBetween(const Frame& frame, const ReseauFit& fit) {
  double before = 0, after = 0;
  int count = 0;
  for (double x = -93; x <= 93; x += 6.2)
    for (double y = -91; y <= 91; y += 6.5) {
      const Vector2d photo(x, y);
      const Vector2d pixel = PixelOf(photo - frame.film.At(photo));
      before += (frame.affine * pixel - photo).squaredNorm();
      after += (PhotoFromPixel(frame.affine, &fit.correction, pixel) - photo).squaredNorm();
      ++count;
    }
  return {1e3 * std::sqrt(before / count), 1e3 * std::sqrt(after / count)};
}

// Root mean square of left-out residuals over their sigmas, both coordinates of the crosses used.
double NormalisedLeftOut(const std::vector<ReseauFit>& fits) {
  double sum = 0;
  int count = 0;
  for (const ReseauFit& fit : fits)
    for (size_t i = 0; i < fit.used.size(); ++i) {
      if (!fit.used[i]) continue;
      sum += (fit.left_out_um[i] / fit.left_out_sigma_um[i]).squaredNorm();
      count += 2;
    }
  return std::sqrt(sum / count);
}

TEST(Reseau, ABentFilmIsCorrectedToNearTheCrossesNoise) {
  for (const int side : {5, 7, 9, 11}) {
    std::vector<ReseauFit> fits;
    double before = 0, after = 0;
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const Frame frame = Simulate(side, seed % 2 == 0 ? 30 : 60, 2, seed);
      const auto fit = FitReseau(frame.marks, frame.affine);
      ASSERT_TRUE(fit);
      const Errors errors = ErrorsBetween(frame, *fit);
      before += errors.before_um / 6;
      after += errors.after_um / 6;
      fits.push_back(*fit);
    }
    RecordProperty("before_um_" + std::to_string(side), std::to_string(before));
    RecordProperty("after_um_" + std::to_string(side), std::to_string(after));
    // 25 crosses, 50 mm apart, sample these waves coarsely; more of them leave less than noise.
    EXPECT_LT(after, side == 5 ? 8 : 3.0) << side << " x " << side << ", before " << before;
    EXPECT_GT(before, 35);
    const double normalised = NormalisedLeftOut(fits);
    EXPECT_GT(normalised, 0.8) << side;
    EXPECT_LT(normalised, 1.25) << side;
  }
}

TEST(Reseau, MissingAndWrongCrossesAreTolerated) {
  double after = 0;
  int wrong = 0, kept = 0, lost = 0, good = 0;
  std::vector<ReseauFit> fits;
  constexpr int kFrames = 8;
  for (unsigned seed = 1; seed <= kFrames; ++seed) {
    const Frame frame = Simulate(9, 50, 2, seed, 0.2, 0.2);
    const auto fit = FitReseau(frame.marks, frame.affine);
    ASSERT_TRUE(fit) << seed;
    after += ErrorsBetween(frame, *fit).after_um / kFrames;
    for (size_t i = 0; i < frame.marks.size(); ++i) {
      wrong += frame.outlier[i];
      kept += frame.outlier[i] && fit->used[i];
      good += !frame.outlier[i];
      lost += !frame.outlier[i] && !fit->used[i];
    }
    fits.push_back(*fit);
  }
  EXPECT_EQ(kept, 0) << "of " << wrong << " wrong crosses";
  EXPECT_LE(lost, good / 50) << "of " << good << " good crosses";
  EXPECT_LT(after, 5) << "um";
  const double normalised = NormalisedLeftOut(fits);
  EXPECT_GT(normalised, 0.8);
  EXPECT_LT(normalised, 1.25);
}

TEST(Reseau, AFlatFilmGetsNoCorrectionWorthTheName) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Frame frame = Simulate(7, 1e-6, 3, seed);
    const auto fit = FitReseau(frame.marks, frame.affine);
    ASSERT_TRUE(fit);
    worst = std::max(worst, ErrorsBetween(frame, *fit).after_um);
  }
  EXPECT_LT(worst, 2.5) << "um: less than one cross's noise";
}

TEST(Reseau, TooFewCrossesOrARowOfThemGiveNone) {
  Frame frame = Simulate(5, 40, 2, 1);
  frame.marks.resize(15);
  EXPECT_FALSE(FitReseau(frame.marks, frame.affine));
  std::vector<MeasuredMark> row;
  for (int i = 0; i < 20; ++i) row.push_back({Vector2d(100 * i, 5), Vector2d(2 * i, 0)});
  EXPECT_FALSE(FitReseau(row, frame.affine));
}

TEST(Reseau, WhereMostCrossesAreWrongNothingIsClaimed) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Frame frame = Simulate(7, 40, 2, seed, 0, 0.6);
    EXPECT_FALSE(FitReseau(frame.marks, frame.affine)) << seed;
  }
}

}  // namespace
}  // namespace orient::interior

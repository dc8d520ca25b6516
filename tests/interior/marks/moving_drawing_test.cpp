#include "interior/marks/moving_drawing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace orient::interior {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr int kSide = 41, kFiner = 2;

// The integral of a Gaussian spot over a square, its centre at zero.
double SpotIn(double left, double top, double side, double sigma) {
  const auto along = [&](double from) {
    const double root = std::sqrt(2.0) * sigma;
    return 0.5 * (std::erf((from + side) / root) - std::erf(from / root));
  };
  return along(left) * along(top);
}

// A spot's means over pixels of the size 1 / finer, its centre `off` beyond the middle.
FloatPlane Spot(int finer, double sigma, const Vector2d& off) {
  FloatPlane spot(finer * kSide, finer * kSide);
  const double size = 1.0 / finer;
  for (Index r = 0; r < spot.rows(); ++r)
    for (Index c = 0; c < spot.cols(); ++c)
      spot(r, c) = static_cast<float>(1000 / size / size *
                                      SpotIn(size * static_cast<double>(c) - 0.5 * kSide - off.x(),
                                             size * static_cast<double>(r) - 0.5 * kSide - off.y(),
                                             size, sigma));
  return spot;
}

std::shared_ptr<const DrawingPart> WholeSquare() {
  return std::make_shared<const DrawingPart>(FloatPlane::Ones(kSide, kSide));
}

TEST(MovingDrawing, IsTheDrawingBlurredAndMoved) {
  const MovingDrawing moving =
      SharpDrawing(Spot(kFiner, 1.2, Vector2d::Zero()), kFiner, WholeSquare()).Blurred(0.9);
  for (const Vector2d& off : {Vector2d(0, 0), Vector2d(0.5, -0.5), Vector2d(-0.37, 0.21)}) {
    const FloatPlane expected = Spot(1, std::hypot(1.2, 0.9), off);
    const Image moved = moving.Moved(off);
    EXPECT_TRUE(std::isnan(moved.At(1, 20)));
    for (int r = 2; r < kSide - 2; ++r)
      for (int c = 2; c < kSide - 2; ++c)
        ASSERT_NEAR(moved.At(c, r), expected(r, c), 0.02) << "of 71 at the top";
  }
}

TEST(MovingDrawing, IsFoundWhereItLies) {
  const SharpDrawing sharp(Spot(kFiner, 0.8, Vector2d::Zero()), kFiner, WholeSquare());
  const SharpDrawing coarse(Spot(1, 0.8, Vector2d::Zero()), 1, WholeSquare());
  for (const Vector2d& off : {Vector2d(0.5, 0), Vector2d(-0.24, 0.45)}) {
    const FloatPlane spot = Spot(1, 1, off);
    Image seen(kSide + 10, kSide + 10, 20);
    for (Index r = 0; r < kSide; ++r)
      for (Index c = 0; c < kSide; ++c)
        seen.At(static_cast<int>(c) + 4, static_cast<int>(r) + 6) += 2 * spot(r, c);
    const Vector2d truth = Vector2d(4, 6) + Vector2d::Constant(0.5 * kSide) + off;
    const auto match = sharp.Blurred(0.6).Match(SeenPlane(seen), truth + Vector2d(0.8, -1), 3);
    ASSERT_TRUE(match);
    EXPECT_LT((match->centre - truth).norm(), 5e-4);
    EXPECT_NEAR(match->gain, 2, 0.002);
    EXPECT_GT(match->correlation, 0.99999);
    const auto rough = coarse.Blurred(0.6).Match(SeenPlane(seen), truth + Vector2d(0.8, -1), 3);
    ASSERT_TRUE(rough);
    EXPECT_LT((rough->centre - truth).norm(), 0.02);
    EXPECT_FALSE(sharp.Blurred(0.6).Match(SeenPlane(seen), truth + Vector2d(0.8, -1), 0.5));
  }
}

// A disc's coverage of pixels of the size 1 / finer, its centre `off` beyond the middle.
FloatPlane Disc(int finer, double radius, const Vector2d& off) {
  constexpr int kPoints = 8;  // a side of a pixel
  FloatPlane disc = FloatPlane::Zero(finer * kSide, finer * kSide);
  const auto place = [&](Index pixel, int point) {
    return (static_cast<double>(pixel) + (point + 0.5) / kPoints) / finer - 0.5 * kSide;
  };
  for (Index r = 0; r < disc.rows(); ++r)
    for (Index c = 0; c < disc.cols(); ++c)
      for (int i = 0; i < kPoints * kPoints; ++i)
        if ((Vector2d(place(c, i % kPoints), place(r, i / kPoints)) - off).norm() < radius)
          disc(r, c) += 1.0f / kPoints / kPoints;
  return disc;
}

// As a scanner's software sharpens: what a blur of one pixel takes away is added `strength` times.
FloatPlane Sharpened(const FloatPlane& plane, float strength) {
  Eigen::ArrayXf weights(9);
  for (Index i = 0; i < 9; ++i)
    weights[i] = std::exp(-0.5f * static_cast<float>((i - 4) * (i - 4)));
  const FloatPlane blurred = SeparableSums(plane, weights / weights.sum());
  return plane + strength * (plane - blurred);
}

TEST(MovingDrawing, IsFoundWhereASharpenedDotLies) {
  const SharpDrawing sharp(Disc(kFiner, 5.5, Vector2d::Zero()), kFiner, WholeSquare());
  for (const float strength : {1.0f, 2.0f, 3.0f})
    for (const double blur : {0.3, 0.45, 0.6})
      for (const Vector2d& off : {Vector2d(0.5, 0), Vector2d(-0.24, 0.45), Vector2d(0.1, 0.3)}) {
        const FloatPlane dot = Sharpened(Disc(1, 5.5, off), strength);
        Image seen(kSide + 10, kSide + 10, 20);
        for (Index r = 0; r < kSide; ++r)
          for (Index c = 0; c < kSide; ++c)
            seen.At(static_cast<int>(c) + 4, static_cast<int>(r) + 6) += 100 * dot(r, c);
        const Vector2d truth = Vector2d(4, 6) + Vector2d::Constant(0.5 * kSide) + off;
        const auto match = sharp.Blurred(blur).Match(SeenPlane(seen), truth + Vector2d(0.8, -1), 3,
                                                     1e-3, Steps::kScaled);
        ASSERT_TRUE(match) << strength << " " << blur << " " << off.transpose();
        EXPECT_LT((match->centre - truth).norm(), 0.05);
      }
}

TEST(SharpDrawing, RefusesADrawingThatIsNotAsLargeAsItsPart) {
  EXPECT_THROW(SharpDrawing(Spot(1, 1, Vector2d::Zero()), kFiner, WholeSquare()),
               std::invalid_argument);
}

}  // namespace
}  // namespace orient::interior

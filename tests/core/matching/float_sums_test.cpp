#include "core/matching/float_sums.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(FloatSums, FollowTheDefinitionWhateverRemainsOfARow) {
  const FloatPlane kernel = FloatPlane::Random(3, 5);
  for (const Eigen::Index cols : {5, 6, 20, 21, 36, 37, 60, 80}) {
    const FloatPlane image = FloatPlane::Random(11, cols);
    const FloatPlane sums = FloatSums(kernel, image);
    ASSERT_EQ(sums.rows(), 9);
    ASSERT_EQ(sums.cols(), cols - 4);
    for (Eigen::Index r = 0; r < sums.rows(); ++r)
      for (Eigen::Index c = 0; c < sums.cols(); ++c)
        ASSERT_NEAR(sums(r, c), (kernel * image.block(r, c, 3, 5)).sum(), 1e-5);
  }
}

TEST(FloatSums, AreMadeInTheKernelsOrderInRegistersOfAnyWidth) {
  const FloatPlane kernel = FloatPlane::Random(4, 7), image = FloatPlane::Random(9, 200);
  const FloatPlane sums = FloatSums(kernel, image);
  for (Eigen::Index r = 0; r < sums.rows(); ++r)
    for (Eigen::Index c = 0; c < sums.cols(); ++c) {
      float one_by_one = 0;
      for (Eigen::Index i = 0; i < kernel.rows(); ++i)
        for (Eigen::Index j = 0; j < kernel.cols(); ++j)
          one_by_one += kernel(i, j) * image(r + i, c + j);
      ASSERT_EQ(sums(r, c), one_by_one) << r << " " << c;
    }
}

TEST(SeparableSums, BlurWithZerosBeyondTheBorder) {
  const Eigen::ArrayXf weights = (Eigen::ArrayXf(3) << 0.25f, 0.5f, 0.25f).finished();
  const FloatPlane blurred = SeparableSums(FloatPlane::Ones(4, 40), weights);
  ASSERT_EQ(blurred.rows(), 4);
  ASSERT_EQ(blurred.cols(), 40);
  EXPECT_NEAR(blurred(2, 20), 1, 1e-6);
  EXPECT_NEAR(blurred(0, 20), 0.75, 1e-6);
  EXPECT_NEAR(blurred(0, 39), 0.5625, 1e-6);
}

}  // namespace
}  // namespace orient

#include "core/matching/correlation_sums.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <tuple>

#include "core/matching/float_sums.h"

namespace orient {

using Eigen::Index;

Plane SpatialSums::Sum(const Plane& kernel, const Plane& image) {
  constexpr Index kRowsAtOnce = 16;
  const FloatPlane weights = kernel.cast<float>();
  const double total = kernel.sum();
  const Index rows = image.rows() - kernel.rows() + 1, cols = image.cols() - kernel.cols() + 1;
  FloatPlane part =
      FloatPlane::Zero(kRowsAtOnce + kernel.rows() - 1, kernel.cols() + kFloatSumsAtOnce);
  Plane result(rows, cols);
  for (Index row = 0; row < rows; row += kRowsAtOnce) {
    const Index count = std::min(kRowsAtOnce, rows - row), height = count + kernel.rows() - 1;
    for (Index col = 0; col < cols; col += kFloatSumsAtOnce) {
      // Relative to a value nearby, so that small contrasts keep all digits.
      const double level = image(row + height / 2, col + kernel.cols() / 2);
      const Index width = std::min(part.cols(), image.cols() - col);
      part.topLeftCorner(height, width) =
          (image.block(row, col, height, width) - level).cast<float>();
      const Index n = std::min(kFloatSumsAtOnce, cols - col);
      Eigen::Array<float, 1, kFloatSumsAtOnce> sums;
      for (Index r = 0; r < count; ++r) {
        SumProducts(weights, part, r, 0, n, sums.data());
        result.row(row + r).segment(col, n) = sums.head(n).cast<double>() + level * total;
      }
    }
  }
  return result;
}

namespace {

// Side of a block, not longer than the image: enough larger than the kernel to be efficient.
int BlockSide(int kernel, int image) {
  constexpr int kLeast = 150;
  const int wanted = std::max(kLeast, 5 * kernel / 2);
  // With hardly more than one block, take the whole.
  return cv::getOptimalDFTSize(image < 3 * wanted / 2 ? image : wanted);
}

}  // namespace

struct FftSums::Spectra {
  using Place = std::tuple<const Plane*, Index, Index>;  // plane, row and column of a block

  cv::Size block;
  std::map<Place, cv::Mat> of;

  // Spectrum of the block of the plane that begins there, with zeros beyond the plane's end.
  const cv::Mat& Of(const Plane& plane, Index row, Index col) {
    cv::Mat& spectrum = of[{&plane, row, col}];
    if (!spectrum.empty()) return spectrum;
    const Index rows = std::min<Index>(block.height, plane.rows() - row);
    const Index cols = std::min<Index>(block.width, plane.cols() - col);
    cv::Mat padded = cv::Mat::zeros(block, CV_64F);
    for (Index r = 0; r < rows; ++r)
      std::copy_n(plane.data() + (row + r) * plane.cols() + col, cols,
                  padded.ptr<double>(static_cast<int>(r)));
    cv::dft(padded, spectrum, 0, static_cast<int>(rows));
    return spectrum;
  }
};

FftSums::FftSums(const Eigen::Vector2i& kernel_size, const Eigen::Vector2i& image_size)
    : spectra_(std::make_unique<Spectra>()) {
  spectra_->block = cv::Size(BlockSide(kernel_size.x(), image_size.x()),
                             BlockSide(kernel_size.y(), image_size.y()));
}

FftSums::~FftSums() = default;

Plane FftSums::Sum(const Plane& kernel, const Plane& image) {
  Plane result(image.rows() - kernel.rows() + 1, image.cols() - kernel.cols() + 1);
  // The cyclic sums are right where the kernel does not wrap around the block.
  const Index row_step = spectra_->block.height - kernel.rows() + 1;
  const Index col_step = spectra_->block.width - kernel.cols() + 1;
  const cv::Mat& of_kernel = spectra_->Of(kernel, 0, 0);
  cv::Mat product, sums;
  for (Index row = 0; row < result.rows(); row += row_step) {
    const Index rows = std::min(row_step, result.rows() - row);
    for (Index col = 0; col < result.cols(); col += col_step) {
      const Index cols = std::min(col_step, result.cols() - col);
      cv::mulSpectrums(spectra_->Of(image, row, col), of_kernel, product, 0, true);
      cv::dft(product, sums, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT,
              static_cast<int>(rows));
      for (Index r = 0; r < rows; ++r)
        std::copy_n(sums.ptr<double>(static_cast<int>(r)), cols,
                    result.data() + (row + r) * result.cols() + col);
    }
  }
  return result;
}

Plane BoxSums(const Plane& image, Index kernel_rows, Index kernel_cols) {
  const Index rows = image.rows() - kernel_rows + 1, cols = image.cols() - kernel_cols + 1;
  Plane across(image.rows(), cols);
  for (Index r = 0; r < image.rows(); ++r) {
    double sum = image.row(r).head(kernel_cols).sum();
    across(r, 0) = sum;
    for (Index c = 1; c < cols; ++c)
      across(r, c) = sum += image(r, c + kernel_cols - 1) - image(r, c - 1);
  }
  Plane result(rows, cols);
  result.row(0) = across.topRows(kernel_rows).colwise().sum();
  for (Index r = 1; r < rows; ++r)
    result.row(r) = result.row(r - 1) + across.row(r + kernel_rows - 1) - across.row(r - 1);
  return result;
}

Plane SumsBefore(const Plane& plane) {
  Plane before(plane.rows(), plane.cols() + 1);
  for (Index r = 0; r < plane.rows(); ++r) {
    double sum = before(r, 0) = 0;
    for (Index c = 0; c < plane.cols(); ++c) before(r, c + 1) = sum += plane(r, c);
  }
  return before;
}

Plane RunSums(const Plane& image, Index kernel_rows, Index kernel_cols,
              const std::vector<MaskRun>& runs) {
  const Index rows = image.rows() - kernel_rows + 1, cols = image.cols() - kernel_cols + 1;
  const Plane before = SumsBefore(image);
  Plane result = Plane::Zero(rows, cols);
  for (Index r = 0; r < rows; ++r)
    for (const MaskRun& run : runs)
      result.row(r) += before.row(r + run.row).segment(run.stop, cols) -
                       before.row(r + run.row).segment(run.first, cols);
  return result;
}

double SpatialCost(const Eigen::Vector2i& templ_size, const Eigen::Vector2i& image_size) {
  const Eigen::Vector2d places = (image_size - templ_size).cast<double>().array() + 1;
  return templ_size.cast<double>().prod() * places.prod();
}

double FftCost(const Eigen::Vector2i& templ_size, const Eigen::Vector2i& image_size) {
  // Measured cost relative to multiplying pixel by pixel; one sum needs about two transforms.
  constexpr double kPerButterfly = 28;
  double pixels = 1, blocks = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const int block = BlockSide(templ_size[axis], image_size[axis]);
    blocks *= std::ceil(double(image_size[axis] - templ_size[axis] + 1) /
                        double(block - templ_size[axis] + 1));
    pixels *= block;
  }
  return kPerButterfly * blocks * pixels * std::log2(pixels + 1);
}

}  // namespace orient

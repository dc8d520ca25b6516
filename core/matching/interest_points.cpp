#include "core/matching/interest_points.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/median.h"

namespace orient {
namespace {

constexpr double kDerivativeSigma_px = 0.7;
constexpr double kWindowSigma_px = 2.0;
constexpr double kMinRoundness = 0.5;

// A point located farther than this from its maximum belongs to another feature.
constexpr int kMaxMovePx = 2;

// Gradients and their products, weighted with the window around every pixel.
struct Tensors {
  cv::Mat gx, gy;      // CV_32F, zero where not valid
  cv::Mat xx, xy, yy;  // normal matrices N, CV_64F
  cv::Mat valid;       // CV_8U: the whole window is data
  int window_radius = 0;
};

int Radius(double sigma) { return std::max(1, static_cast<int>(std::ceil(3 * sigma))); }

cv::Mat Gaussian(double sigma, int radius) {
  return cv::getGaussianKernel(2 * radius + 1, sigma, CV_64F);
}

// Responds with exactly 1 to a ramp of slope 1.
cv::Mat GaussianDerivative(double sigma, int radius) {
  cv::Mat kernel = Gaussian(sigma, radius);
  double moment = 0;
  for (int i = -radius; i <= radius; ++i) {
    kernel.at<double>(i + radius) *= i;
    moment += kernel.at<double>(i + radius) * i;
  }
  return kernel / moment;
}

// Zero-filled values; `valid` is 1 where the pixel and all within `reach` of it are data.
cv::Mat Split(const Image& image, int reach, cv::Mat* valid) {
  cv::Mat values(image.height, image.width, CV_32F);
  cv::Mat data(image.height, image.width, CV_8U);
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      const float v = image.At(c, r);
      data.at<uchar>(r, c) = std::isfinite(v) ? 1 : 0;
      values.at<float>(r, c) = std::isfinite(v) ? v : 0.0f;
    }
  }
  const cv::Mat square = cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U);
  cv::erode(data, *valid, square, cv::Point(-1, -1), 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return values;
}

Tensors ComputeTensors(const Image& image) {
  Tensors t;
  const int inner = Radius(kDerivativeSigma_px);
  t.window_radius = Radius(kWindowSigma_px);
  const cv::Mat values = Split(image, inner + t.window_radius + kMaxMovePx, &t.valid);
  const cv::Mat smooth = Gaussian(kDerivativeSigma_px, inner);
  const cv::Mat slope = GaussianDerivative(kDerivativeSigma_px, inner);
  cv::sepFilter2D(values, t.gx, CV_32F, slope, smooth);
  cv::sepFilter2D(values, t.gy, CV_32F, smooth, slope);
  // Weight 1 in the middle: N is a sum over pixels, its inverse a covariance.
  cv::Mat window = Gaussian(kWindowSigma_px, t.window_radius);
  window /= window.at<double>(t.window_radius);
  const auto weighted = [&window](const cv::Mat& a, const cv::Mat& b, cv::Mat* sum) {
    cv::sepFilter2D(a.mul(b), *sum, CV_64F, window, window);
  };
  weighted(t.gx, t.gx, &t.xx);
  weighted(t.gx, t.gy, &t.xy);
  weighted(t.gy, t.gy, &t.yy);
  return t;
}

struct Measure {
  double weight = 0, roundness = 0;
};

Measure MeasureAt(const Tensors& t, int col, int row) {
  const double xx = t.xx.at<double>(row, col), xy = t.xy.at<double>(row, col),
               yy = t.yy.at<double>(row, col);
  const double trace = xx + yy, det = std::max(0.0, xx * yy - xy * xy);
  if (!(trace > 0)) return {};
  return {det / trace, 4 * det / (trace * trace)};
}

// Weighted sums of one model's lines: N p = right; `squares` is the residual at p.
struct Lines {
  Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double constant = 0;

  // The line through q (relative to the start) with the normal n.
  void Add(double weight, const Eigen::Vector2d& n, const Eigen::Vector2d& q) {
    const double along = n.dot(q);
    N += weight * n * n.transpose();
    right += weight * along * n;
    constant += weight * along * along;
  }
  bool Regular() const { return N.determinant() > 1e-12 * N.trace() * N.trace(); }
  Eigen::Vector2d Solve() const { return N.inverse() * right; }
  double Squares() const { return constant - right.dot(Solve()); }
};

// Foerstner's two models: the edges' tangents meet in a corner or crossing, their normals in the
// middle of a round spot.
struct Models {
  Lines corner, spot;
};

Models SumLines(const Tensors& t, int col, int row, const Eigen::Vector2d& centre, double sigma) {
  const int reach = t.window_radius + kMaxMovePx, count = 2 * reach + 1;
  const Eigen::Vector2d off = centre - Eigen::Vector2d(col + 0.5, row + 0.5);
  std::vector<double> across(static_cast<size_t>(count)), down(across.size());
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d d = Eigen::Vector2d::Constant(i - reach) - off;
    across[static_cast<size_t>(i)] = std::exp(-d.x() * d.x() / (2 * sigma * sigma));
    down[static_cast<size_t>(i)] = std::exp(-d.y() * d.y() / (2 * sigma * sigma));
  }
  Models models;
  for (int j = 0; j < count; ++j) {
    const float* gx = t.gx.ptr<float>(row - reach + j) + col - reach;
    const float* gy = t.gy.ptr<float>(row - reach + j) + col - reach;
    for (int i = 0; i < count; ++i) {
      const double weight = across[static_cast<size_t>(i)] * down[static_cast<size_t>(j)];
      const Eigen::Vector2d q(i - reach, j - reach);
      models.corner.Add(weight, {double(gx[i]), double(gy[i])}, q);
      models.spot.Add(weight, {-double(gy[i]), double(gx[i])}, q);
    }
  }
  return models;
}

// The window follows the point, so that the start has no influence. Empty if it moves too far.
std::optional<InterestPoint> Locate(const Tensors& t, int col, int row, double sigma) {
  const Eigen::Vector2d start(col + 0.5, row + 0.5);
  constexpr int kRounds = 10;
  constexpr double kStillPx = 1e-3;
  InterestPoint point;
  point.pixel = start;
  for (int round = 0; round < kRounds; ++round) {
    const Models models = SumLines(t, col, row, point.pixel, sigma);
    if (!models.corner.Regular() || !models.spot.Regular()) return std::nullopt;
    const bool is_corner = models.corner.Squares() <= models.spot.Squares();
    const Lines& lines = is_corner ? models.corner : models.spot;
    const Eigen::Vector2d before = point.pixel;
    point.pixel = start + lines.Solve();
    point.covariance = lines.N.inverse();
    if ((point.pixel - start).cwiseAbs().maxCoeff() > kMaxMovePx) return std::nullopt;
    if ((point.pixel - before).norm() < kStillPx) break;
  }
  return point;
}

struct Maximum {
  int col = 0, row = 0;
  Measure measure;
};

std::vector<Maximum> Maxima(const Tensors& t, const InterestOptions& options) {
  cv::Mat weights = cv::Mat::zeros(t.valid.size(), CV_64F);
  std::vector<double> all;
  for (int r = 0; r < weights.rows; ++r) {
    for (int c = 0; c < weights.cols; ++c) {
      if (t.valid.at<uchar>(r, c) == 0) continue;
      all.push_back(weights.at<double>(r, c) = MeasureAt(t, c, r).weight);
    }
  }
  // A maximum needs all its neighbours, or the border of the data would create false ones.
  cv::Mat inside, highest;
  cv::erode(t.valid, inside, cv::Mat::ones(3, 3, CV_8U), cv::Point(-1, -1), 1, cv::BORDER_CONSTANT,
            cv::Scalar(0));
  cv::dilate(weights, highest, cv::Mat::ones(3, 3, CV_8U));
  const double least = options.min_weight_ratio * (all.empty() ? 0 : UpperMedian(std::move(all)));
  std::vector<Maximum> maxima;
  for (int r = 0; r < weights.rows; ++r) {
    for (int c = 0; c < weights.cols; ++c) {
      const double weight = weights.at<double>(r, c);
      if (inside.at<uchar>(r, c) == 0 || weight <= 0 || weight < least ||
          weight < highest.at<double>(r, c))
        continue;
      const Measure measure = MeasureAt(t, c, r);
      if (measure.roundness >= kMinRoundness) maxima.push_back({c, r, measure});
    }
  }
  std::stable_sort(maxima.begin(), maxima.end(), [](const Maximum& a, const Maximum& b) {
    return a.measure.weight > b.measure.weight;
  });
  return maxima;
}

// Points in square cells as wide as the least distance: only the nine around a place matter.
class Neighbours {
 public:
  Neighbours(const Image& image, double distance)
      : distance_(distance), cell_(std::max(1.0, distance)) {
    cols_ = static_cast<int>(image.width / cell_) + 1;
    cells_.resize(static_cast<size_t>(cols_) *
                  static_cast<size_t>(static_cast<int>(image.height / cell_) + 1));
  }

  // False if a point is nearer than the distance; otherwise the place is recorded.
  bool Take(const Eigen::Vector2d& place) {
    const int col = static_cast<int>(place.x() / cell_), row = static_cast<int>(place.y() / cell_);
    const int rows = static_cast<int>(cells_.size()) / cols_;
    for (int r = std::max(0, row - 1); r <= std::min(rows - 1, row + 1); ++r)
      for (int c = std::max(0, col - 1); c <= std::min(cols_ - 1, col + 1); ++c)
        for (const Eigen::Vector2d& other : cells_[static_cast<size_t>(r * cols_ + c)])
          if ((other - place).norm() < distance_) return false;
    cells_[static_cast<size_t>(row * cols_ + col)].push_back(place);
    return true;
  }

 private:
  double distance_, cell_;
  int cols_ = 0;
  std::vector<std::vector<Eigen::Vector2d>> cells_;
};

}  // namespace

std::vector<InterestPoint> FindInterestPoints(const Image& image, const InterestOptions& options) {
  if (image.Empty()) return {};
  const Tensors tensors = ComputeTensors(image);
  Neighbours neighbours(image, options.min_distance_px);
  std::vector<InterestPoint> points;
  for (const Maximum& maximum : Maxima(tensors, options)) {
    auto point = Locate(tensors, maximum.col, maximum.row, kWindowSigma_px);
    if (!point) continue;
    if (!neighbours.Take(point->pixel)) continue;
    point->weight = maximum.measure.weight;
    point->roundness = maximum.measure.roundness;
    points.push_back(*point);
  }
  return points;
}

}  // namespace orient

#include "core/matching/lsm_template.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/raster/resample.h"
#include "core/raster/spline_image.h"

namespace orient {
namespace {

// Below this standard deviation relative to the mean a template is flat.
constexpr double kFlat = 1e-6;

}  // namespace

PrincipalAxes GradientAxes(const Image& templ) {
  constexpr double kSigma = 1;
  // The blur is one-sided at the border; for a small template this is accepted.
  const int margin = std::min(templ.width, templ.height) > 12 ? 3 : 1;
  const Image smooth = GaussianBlur(templ, kSigma);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int r = margin; r + margin < templ.height; ++r) {
    for (int c = margin; c + margin < templ.width; ++c) {
      const Eigen::Vector2d gradient(double(smooth.At(c + 1, r)) - double(smooth.At(c - 1, r)),
                                     double(smooth.At(c, r + 1)) - double(smooth.At(c, r - 1)));
      if (gradient.allFinite()) sum += gradient * gradient.transpose();
    }
  }
  return AxesOf(sum);
}

std::optional<LsmTemplate> PrepareTemplate(const Image& image, const Eigen::Vector2d& reference) {
  LsmTemplate t;
  double sum = 0, squares = 0;
  for (const float value : image.values)
    if (std::isfinite(value)) sum += double(value), t.mean += 1;
  if (t.mean < 2) return std::nullopt;
  const double count = t.mean;
  t.mean = sum / count;
  for (const float value : image.values)
    if (std::isfinite(value)) squares += (double(value) - t.mean) * (double(value) - t.mean);
  t.deviation = std::sqrt(squares / count);
  if (!(t.deviation > kFlat * std::abs(t.mean))) return std::nullopt;
  t.half_size = std::max(image.width, image.height) / 2.0;
  t.cols = std::max(image.width - 2, 0);
  t.rows = std::max(image.height - 2, 0);
  t.first = Eigen::Vector2d(1.5, 1.5) - reference;
  const SplineImage spline(image, {0, 0, image.width, image.height});
  SplineSamples samples = spline.SampleGrid({1.5, 1.5}, t.cols, t.rows);
  t.u.resize(samples.known.size());
  t.v.resize(samples.known.size());
  for (Eigen::Index i = 0; i < t.u.size(); ++i) {
    const Eigen::Index col = i % t.cols, row = i / t.cols;
    t.u[i] = (t.first.x() + static_cast<double>(col)) / t.half_size;
    t.v[i] = (t.first.y() + static_cast<double>(row)) / t.half_size;
  }
  t.value = samples.known * (samples.value - t.mean) / t.deviation;
  t.by_col = samples.by_col / t.deviation;
  t.by_row = samples.by_row / t.deviation;
  t.known = std::move(samples.known);
  for (const double x : {0.0, double(image.width)})
    for (const double y : {0.0, double(image.height)})
      t.corners.push_back(Eigen::Vector2d(x, y) - reference);
  return t;
}

}  // namespace orient

// Least-squares matching of gradient channels.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/principal_axes.h"
#include "core/matching/gradient_channels.h"
#include "core/raster/spline_image.h"

namespace orient {
namespace {

constexpr int kMaxIterations = 20;
constexpr double kConverged_px = 2e-3;
constexpr double kMaxStep_px = 1;
// Side of the blocks over which the covariance is summed: several times the correlation length of
// the channels' residuals.
constexpr int kBlock_px = 6;
constexpr double kMinDirectionRatio = 0.01;  // of information along to across an edge

// One channel of the template, at the centres of its pixels.
struct TemplateChannel {
  SplineSamples samples;
  const SplineImage image;  // the same channel of the image
};

// Sums over the pixels with data in both, for one position of the template's corner.
struct ChannelSums {
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double tt = 0, ti = 0, ii = 0;
  double count = 0;
  double Gain() const { return ti / tt; }
  double Correlation() const { return ti / std::sqrt(tt * ii); }
};

class ChannelMatcher {
 public:
  ChannelMatcher(const GradientChannels& templ, const GradientChannels& image,
                 const Eigen::Vector2d& start, double max_shift_px)
      : cols_(templ.Width()), rows_(templ.Height()) {
    const double margin = max_shift_px + 8;
    const PixelWindow part{static_cast<int>(std::floor(start.x() - margin)),
                           static_cast<int>(std::floor(start.y() - margin)),
                           static_cast<int>(std::ceil(cols_ + 2 * margin)),
                           static_cast<int>(std::ceil(rows_ + 2 * margin))};
    for (std::size_t k = 0; k < kGradientChannels; ++k) {
      const SplineImage spline(templ.channels[k], {0, 0, cols_, rows_});
      channels_.push_back({spline.SampleGrid({0.5, 0.5}, cols_, rows_), {image.channels[k], part}});
      count_ += channels_.back().samples.known.sum();
    }
  }

  std::optional<ChannelSums> SumUp(const Eigen::Vector2d& corner) const {
    ChannelSums s;
    Eigen::Vector2d with_value = Eigen::Vector2d::Zero(), with_templ = Eigen::Vector2d::Zero();
    for (const TemplateChannel& channel : channels_) {
      const SplineSamples image = ImageAt(channel, corner);
      const Eigen::ArrayXd known = image.known * channel.samples.known;
      const Eigen::ArrayXd value = known * image.value, templ = known * channel.samples.value;
      Eigen::MatrixX2d gradient(known.size(), 2);
      gradient << (known * channel.samples.by_col).matrix(),
          (known * channel.samples.by_row).matrix();
      s.normals += gradient.transpose() * gradient;
      with_value += gradient.transpose() * value.matrix();
      with_templ += gradient.transpose() * templ.matrix();
      s.tt += templ.square().sum();
      s.ti += (templ * value).sum();
      s.ii += value.square().sum();
      s.count += known.sum();
    }
    if (2 * s.count < count_ || !(s.ti > 0)) return std::nullopt;
    // Residuals: the image minus the template times its best-fitting gain.
    s.right = with_value - s.Gain() * with_templ;
    return s;
  }

  std::optional<Eigen::Matrix2d> Covariance(const Eigen::Vector2d& corner,
                                            const ChannelSums& s) const {
    const PrincipalAxes axes = AxesOf(s.normals);
    if (!(axes.values[0] > kMinDirectionRatio * axes.values[1])) return std::nullopt;
    const int blocks_a_row = (cols_ + kBlock_px - 1) / kBlock_px;
    const int block_rows = (rows_ + kBlock_px - 1) / kBlock_px;
    std::vector<Eigen::Vector2d> sums(static_cast<std::size_t>(blocks_a_row * block_rows),
                                      Eigen::Vector2d::Zero());
    for (const TemplateChannel& channel : channels_) {
      const SplineSamples image = ImageAt(channel, corner);
      const SplineSamples& templ = channel.samples;
      for (Eigen::Index i = 0; i < image.known.size(); ++i) {
        const auto row = static_cast<int>(i) / cols_, col = static_cast<int>(i) % cols_;
        const double residual =
            image.known[i] * templ.known[i] * (image.value[i] - s.Gain() * templ.value[i]);
        sums[static_cast<std::size_t>((row / kBlock_px) * blocks_a_row + col / kBlock_px)] +=
            residual * Eigen::Vector2d(templ.by_col[i], templ.by_row[i]);
      }
    }
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& sum : sums) spread += sum * sum.transpose();
    // The two coordinates and the gain are estimated from these blocks.
    const double blocks = static_cast<double>(sums.size());
    const Eigen::Matrix2d inverse = s.normals.inverse() / s.Gain();
    return Eigen::Matrix2d(blocks / std::max(blocks - 3, 1.0) * inverse * spread * inverse);
  }

 private:
  SplineSamples ImageAt(const TemplateChannel& channel, const Eigen::Vector2d& corner) const {
    return channel.image.SampleGrid(corner + Eigen::Vector2d(0.5, 0.5), cols_, rows_);
  }

  int cols_ = 0, rows_ = 0;
  std::vector<TemplateChannel> channels_;
  double count_ = 0;  // of the template's pixels that are known
};

}  // namespace

std::optional<ChannelMatch> MatchChannels(const GradientChannels& templ,
                                          const GradientChannels& image,
                                          const Eigen::Vector2d& start, double max_shift_px) {
  const ChannelMatcher matcher(templ, image, start, max_shift_px);
  Eigen::Vector2d corner = start;
  for (int i = 0; i < kMaxIterations; ++i) {
    const auto sums = matcher.SumUp(corner);
    if (!sums) return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix2d> solver(sums->normals);
    Eigen::Vector2d step = -solver.solve(sums->right) / sums->Gain();
    if (!step.allFinite()) return std::nullopt;
    if (step.norm() > kMaxStep_px) step *= kMaxStep_px / step.norm();
    corner += step;
    if ((corner - start).norm() > max_shift_px) return std::nullopt;
    if (step.norm() > kConverged_px) continue;
    const auto last = matcher.SumUp(corner);
    const auto covariance = last ? matcher.Covariance(corner, *last) : std::nullopt;
    if (!covariance || !covariance->allFinite()) return std::nullopt;
    return ChannelMatch{corner, *covariance, last->Correlation()};
  }
  return std::nullopt;
}

}  // namespace orient

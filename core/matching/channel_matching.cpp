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
// Side of the blocks over which the covariance is summed: several times as far as the channels'
// residuals are related.
constexpr int kBlock_px = 6;
constexpr double kMinDirectionRatio = 0.01;  // of information along to across an edge

// One pixel of one channel of the template.
struct ChannelPixel {
  Eigen::Vector2d place;     // in the template
  Eigen::Vector2d gradient;  // of the template
  double value = 0;
  std::size_t channel = 0, block = 0;
};

std::vector<ChannelPixel> PixelsOf(const GradientChannels& templ) {
  const int blocks_a_row = (templ.Width() + kBlock_px - 1) / kBlock_px;
  std::vector<ChannelPixel> pixels;
  for (std::size_t k = 0; k < kGradientChannels; ++k) {
    const Image& channel = templ.channels[k];
    const SplineImage spline(channel, {0, 0, channel.width, channel.height});
    for (int row = 0; row < channel.height; ++row)
      for (int col = 0; col < channel.width; ++col) {
        ChannelPixel pixel;
        pixel.place = Eigen::Vector2d(col + 0.5, row + 0.5);
        if (!spline.Sample(pixel.place, &pixel.value, &pixel.gradient)) continue;
        pixel.channel = k;
        pixel.block = static_cast<std::size_t>((row / kBlock_px) * blocks_a_row + col / kBlock_px);
        pixels.push_back(pixel);
      }
  }
  return pixels;
}

// Sums over the pixels that meet data with the template's corner at one place.
struct ChannelSums {
  Eigen::Matrix2d normals = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  double tt = 0, ti = 0, ii = 0;
  std::size_t count = 0;
  double Gain() const { return ti / tt; }
  double Correlation() const { return ti / std::sqrt(tt * ii); }
};

class ChannelMatcher {
 public:
  ChannelMatcher(const GradientChannels& templ, const GradientChannels& image,
                 const Eigen::Vector2d& start, double max_shift_px)
      : pixels_(PixelsOf(templ)) {
    const double margin = max_shift_px + 8;
    const PixelWindow part{static_cast<int>(std::floor(start.x() - margin)),
                           static_cast<int>(std::floor(start.y() - margin)),
                           static_cast<int>(std::ceil(templ.Width() + 2 * margin)),
                           static_cast<int>(std::ceil(templ.Height() + 2 * margin))};
    for (const Image& channel : image.channels) splines_.emplace_back(channel, part);
    for (const ChannelPixel& pixel : pixels_) blocks_ = std::max(blocks_, pixel.block + 1);
  }

  std::optional<ChannelSums> SumUp(const Eigen::Vector2d& corner) const {
    ChannelSums s;
    Eigen::Vector2d with_value = Eigen::Vector2d::Zero(), with_templ = Eigen::Vector2d::Zero();
    ForEach(corner, [&](const ChannelPixel& pixel, double value) {
      s.normals += pixel.gradient * pixel.gradient.transpose();
      with_value += pixel.gradient * value;
      with_templ += pixel.gradient * pixel.value;
      s.tt += pixel.value * pixel.value;
      s.ti += pixel.value * value;
      s.ii += value * value;
      ++s.count;
    });
    if (2 * s.count < pixels_.size() || !(s.ti > 0)) return std::nullopt;
    // With the gain that fits best the template is subtracted from the image.
    s.right = with_value - s.Gain() * with_templ;
    return s;
  }

  std::optional<Eigen::Matrix2d> Covariance(const Eigen::Vector2d& corner,
                                            const ChannelSums& s) const {
    const PrincipalAxes axes = AxesOf(s.normals);
    if (!(axes.values[0] > kMinDirectionRatio * axes.values[1])) return std::nullopt;
    std::vector<Eigen::Vector2d> sums(blocks_, Eigen::Vector2d::Zero());
    ForEach(corner, [&](const ChannelPixel& pixel, double value) {
      sums[pixel.block] += pixel.gradient * (value - s.Gain() * pixel.value);
    });
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const Eigen::Vector2d& sum : sums) spread += sum * sum.transpose();
    // The two coordinates and the gain are estimated from these blocks.
    const double blocks = static_cast<double>(blocks_);
    const Eigen::Matrix2d inverse = s.normals.inverse() / s.Gain();
    return Eigen::Matrix2d(blocks / std::max(blocks - 3, 1.0) * inverse * spread * inverse);
  }

 private:
  template <typename Work>
  void ForEach(const Eigen::Vector2d& corner, const Work& work) const {
    Eigen::Vector2d unused;
    for (const ChannelPixel& pixel : pixels_) {
      double value = 0;
      if (splines_[pixel.channel].Sample(corner + pixel.place, &value, &unused)) work(pixel, value);
    }
  }

  std::vector<ChannelPixel> pixels_;
  std::vector<SplineImage> splines_;
  std::size_t blocks_ = 0;
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

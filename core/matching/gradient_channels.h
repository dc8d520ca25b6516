// Oriented-gradient channels of an image and their correlation: where the same thing lies in two
// images whose grey values no longer resemble each other.
//
// A season, another film or decades change how bright a field is, even which of two is the brighter
// one, but not where their border runs and in which direction. Each pixel is described by how
// strong its gradient is in which orientation, not knowing dark from bright: a dense form of
// histograms of oriented gradients (Ye et al. 2019, CFOG). Instead of nine bins of orientation the
// first harmonic of the doubled angle is kept (the second one finds nothing more, measured on
// photos of different years). It is slightly smoothed and divided by the gradients' strength
// around, so that a weak border counts nearly as much as a strong one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "core/raster/image.h"

namespace orient {

inline constexpr std::size_t kGradientChannels = 2;

// Gradient strength times cosine and sine of twice its direction. Of the image's size; NaN where
// the image or one of a pixel's four neighbours is, so also along the border.
struct GradientChannels {
  std::array<Image, kGradientChannels> channels;
  int Width() const { return channels[0].width; }
  int Height() const { return channels[0].height; }
};

GradientChannels ChannelsOf(const Image& image);

// Cosine of the template's channels and the image's at every position where the template lies
// inside, in [-1, 1]; the conventions are Correlate's (correlation.h). Right places have about 0.4
// where half of what is seen has changed, wrong ones seldom more than 0.3.
Image CorrelateChannels(const GradientChannels& templ, const GradientChannels& image,
                        double min_valid = 0.75);

struct ChannelMatch {
  Eigen::Vector2d corner;      // of the template in the image
  Eigen::Matrix2d covariance;  // px^2
  double correlation = 0;      // at that place
};

// Least-squares matching of the channels (Gruen 1985: shift and a common gain), from a place near
// the template's corner in the image. Neighbouring residuals are related (the channels are smooth,
// and what has changed is not noise), hence the covariance is that of the sums over blocks of
// pixels, not of single ones (White's sandwich). Empty: it moves more than `max_shift_px`, does not
// converge, or has no texture in one direction.
std::optional<ChannelMatch> MatchChannels(const GradientChannels& templ,
                                          const GradientChannels& image,
                                          const Eigen::Vector2d& start, double max_shift_px);

}  // namespace orient

// Keypoints with rotation- and scale-invariant descriptors (SIFT, Lowe 2004), for matching images
// of one scene whose relative position and rotation are unknown.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/raster/image.h"

namespace orient {

inline constexpr int kDescriptorSize = 128;

struct Keypoints {
  std::vector<Eigen::Vector2d> pixels;  // of the image
  std::vector<double> sizes_px;         // diameter of what is described
  std::vector<double> angles_rad;       // in which it is directed, from columns towards rows
  // A row a keypoint.
  Eigen::Matrix<std::uint8_t, Eigen::Dynamic, kDescriptorSize, Eigen::RowMajor> descriptors;

  std::size_t Size() const { return pixels.size(); }
  // Those of these indices.
  Keypoints Of(const std::vector<std::size_t>& which) const;
  void Append(const Keypoints& others);
};

// The strongest ones, at most about `most`. What is no data is no feature, nor is its border. The
// same ones every time. An image without contrast has none.
Keypoints FindKeypoints(const Image& image, int most);

struct KeypointMatch {
  std::size_t first = 0, second = 0;  // indices
};

// Pairs that are one another's nearest descriptors (Hellinger distance, Arandjelovic & Zisserman
// 2012), the second nearest one being farther by 1 / `ratio` at least, from either side, and by
// more than noise.
std::vector<KeypointMatch> MatchKeypoints(const Keypoints& first, const Keypoints& second,
                                          double ratio = 0.8);

// Indices of the second keypoints with which one of the first is compared, ascending.
using Comparable = std::function<std::vector<std::size_t>(std::size_t first)>;

// What one comparison of descriptors tells.
struct AlikeKeypoints {
  std::vector<KeypointMatch> distinct;  // as MatchKeypoints, of those compared
  // Of each first keypoint the second ones nearest to it (the same distance), the nearest first,
  // those of one keypoint together.
  std::vector<KeypointMatch> nearest;
};
// `count`: of the nearest, at least one.
AlikeKeypoints CompareKeypoints(const Keypoints& first, const Keypoints& second,
                                const Comparable& comparable, double ratio, std::size_t count);

}  // namespace orient

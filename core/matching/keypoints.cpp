#include "core/matching/keypoints.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/geometry/rotation.h"

namespace orient {
namespace {

// Keypoints closer to missing data than this show only its border.
constexpr int kBorder_px = 8;
// OpenCV's origin is the centre of the first pixel; and it searches the image at twice the size, in
// which its coordinates are too large by a quarter of an original pixel.
constexpr double kOffset_px = 0.5 - 0.25;
// Squared distance between descriptors of one object due to noise: smaller differences are ignored.
constexpr double kAlike = 0.02;
// Quantiles of the grey values that are stretched to black and to white.
constexpr double kDark = 0.005, kBright = 0.995;

using Unit = Eigen::Matrix<float, Eigen::Dynamic, kDescriptorSize, Eigen::RowMajor>;

// The photo in 8 bits, no data in the middle grey; false where it has no contrast.
bool Stretch(const Image& image, cv::Mat* grey) {
  std::vector<float> values;
  values.reserve(image.values.size());
  for (const float value : image.values)
    if (std::isfinite(value)) values.push_back(value);
  if (values.empty()) return false;
  const auto at = [&](double share) {
    const auto place = values.begin() +
                       static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  const float dark = at(kDark), bright = at(kBright);
  if (!(bright > dark)) return false;
  grey->create(image.height, image.width, CV_8U);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const float value = image.At(col, row);
      grey->at<std::uint8_t>(row, col) =
          std::isfinite(value)
              ? cv::saturate_cast<std::uint8_t>(255 * (value - dark) / (bright - dark))
              : std::uint8_t{128};
    }
  return true;
}

// 255 where keypoints may lie.
cv::Mat Valid(const Image& image) {
  cv::Mat valid(image.height, image.width, CV_8U, cv::Scalar(255));
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      if (!std::isfinite(image.At(col, row))) valid.at<std::uint8_t>(row, col) = 0;
  constexpr int kSide = 2 * kBorder_px + 1;
  cv::erode(valid, valid, cv::Mat::ones(kSide, kSide, CV_8U));
  return valid;
}

// Roots of descriptors of unit sum: their products are cosines of Hellinger's distance.
Unit Rooted(const Keypoints& keypoints) {
  Unit rooted = keypoints.descriptors.cast<float>();
  for (Eigen::Index i = 0; i < rooted.rows(); ++i) {
    const float sum = rooted.row(i).sum();
    if (sum > 0) rooted.row(i) = (rooted.row(i) / sum).cwiseSqrt();
  }
  return rooted;
}

struct Nearest {
  Eigen::Index index = -1;
  float best = -1, second = -1;  // cosines
  void Take(Eigen::Index candidate, float cosine) {
    if (cosine > best) {
      second = best;
      best = cosine;
      index = candidate;
    } else if (cosine > second) {
      second = cosine;
    }
  }
  bool Stands(double ratio) const {
    if (index < 0) return false;
    const double d1 = 2 - 2 * static_cast<double>(best), d2 = 2 - 2 * static_cast<double>(second);
    return d1 <= ratio * ratio * d2 && d2 - d1 >= kAlike;
  }
};

// Pairs that are mutually nearest, and clearly nearer than to all others.
class Distinct {
 public:
  Distinct(std::size_t first, std::size_t second) : of_first_(first), of_second_(second) {}

  void Take(std::size_t i, std::size_t j, float cosine) {
    of_first_[i].Take(static_cast<Eigen::Index>(j), cosine);
    of_second_[j].Take(static_cast<Eigen::Index>(i), cosine);
  }

  std::vector<KeypointMatch> Matches(double ratio) const {
    std::vector<KeypointMatch> matches;
    for (std::size_t i = 0; i < of_first_.size(); ++i) {
      if (!of_first_[i].Stands(ratio)) continue;
      const auto j = static_cast<std::size_t>(of_first_[i].index);
      if (of_second_[j].index == static_cast<Eigen::Index>(i) && of_second_[j].Stands(ratio))
        matches.push_back({i, j});
    }
    return matches;
  }

 private:
  std::vector<Nearest> of_first_, of_second_;
};

// The `most` best ones, descending.
class NearestFew {
 public:
  explicit NearestFew(std::size_t most) : most_(most) {}
  void Take(std::size_t j, float cosine) {
    if (best_.size() == most_ && cosine <= best_.back().first) return;
    if (best_.size() == most_) best_.pop_back();
    const std::pair here(cosine, j);
    best_.insert(std::upper_bound(best_.begin(), best_.end(), here, std::greater<>()), here);
  }
  const std::vector<std::pair<float, std::size_t>>& Best() const { return best_; }

 private:
  std::size_t most_;
  std::vector<std::pair<float, std::size_t>> best_;
};

}  // namespace

Keypoints Keypoints::Of(const std::vector<std::size_t>& which) const {
  Keypoints chosen;
  chosen.descriptors.resize(std::ssize(which), kDescriptorSize);
  for (const std::size_t i : which) {
    chosen.descriptors.row(std::ssize(chosen.pixels)) =
        descriptors.row(static_cast<Eigen::Index>(i));
    chosen.pixels.push_back(pixels[i]);
    chosen.sizes_px.push_back(sizes_px[i]);
    chosen.angles_rad.push_back(angles_rad[i]);
  }
  return chosen;
}

void Keypoints::Append(const Keypoints& others) {
  descriptors.conservativeResize(descriptors.rows() + others.descriptors.rows(), kDescriptorSize);
  descriptors.bottomRows(others.descriptors.rows()) = others.descriptors;
  pixels.insert(pixels.end(), others.pixels.begin(), others.pixels.end());
  sizes_px.insert(sizes_px.end(), others.sizes_px.begin(), others.sizes_px.end());
  angles_rad.insert(angles_rad.end(), others.angles_rad.begin(), others.angles_rad.end());
}

Keypoints FindKeypoints(const Image& image, int most) {
  Keypoints found;
  found.descriptors.resize(0, kDescriptorSize);
  cv::Mat grey;
  if (image.width < 2 * kBorder_px || image.height < 2 * kBorder_px || !Stretch(image, &grey))
    return found;
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  cv::SIFT::create(most)->detectAndCompute(grey, Valid(image), points, descriptors);
  found.descriptors.resize(std::ssize(points), kDescriptorSize);
  for (std::size_t i = 0; i < points.size(); ++i) {
    found.pixels.emplace_back(points[i].pt.x + kOffset_px, points[i].pt.y + kOffset_px);
    found.sizes_px.push_back(points[i].size);
    found.angles_rad.push_back(RadFromDeg(points[i].angle));
    for (int k = 0; k < kDescriptorSize; ++k)
      found.descriptors(static_cast<Eigen::Index>(i), k) =
          cv::saturate_cast<std::uint8_t>(descriptors.at<float>(static_cast<int>(i), k));
  }
  return found;
}

std::vector<KeypointMatch> MatchKeypoints(const Keypoints& first, const Keypoints& second,
                                          double ratio) {
  if (first.Size() == 0 || second.Size() == 0) return {};
  const Unit a = Rooted(first), b = Rooted(second);
  Distinct distinct(first.Size(), second.Size());
  constexpr Eigen::Index kRows = 256;  // of products at a time
  for (Eigen::Index begin = 0; begin < a.rows(); begin += kRows) {
    const Eigen::Index rows = std::min(kRows, a.rows() - begin);
    const Eigen::MatrixXf cosines = b * a.middleRows(begin, rows).transpose();
    for (Eigen::Index i = 0; i < rows; ++i)
      for (Eigen::Index j = 0; j < b.rows(); ++j)
        distinct.Take(static_cast<std::size_t>(begin + i), static_cast<std::size_t>(j),
                      cosines(j, i));
  }
  return distinct.Matches(ratio);
}

AlikeKeypoints CompareKeypoints(const Keypoints& first, const Keypoints& second,
                                const Comparable& comparable, double ratio, std::size_t count) {
  // This many descriptors of the second set stay in the processor's cache while a block of the
  // first is compared with them.
  constexpr std::size_t kBlock = 256, kTile = 512;
  AlikeKeypoints alike;
  const Unit a = Rooted(first), b = Rooted(second);
  Distinct distinct(first.Size(), second.Size());
  for (std::size_t begin = 0; begin < first.Size(); begin += kBlock) {
    const std::size_t size = std::min(kBlock, first.Size() - begin);
    std::vector<std::vector<std::size_t>> candidates;
    for (std::size_t i = 0; i < size; ++i) candidates.push_back(comparable(begin + i));
    std::vector<NearestFew> nearest(size, NearestFew(count));
    std::vector<std::size_t> next(size, 0);
    for (std::size_t end = kTile; end < second.Size() + kTile; end += kTile)
      for (std::size_t i = 0; i < size; ++i)
        for (; next[i] < candidates[i].size() && candidates[i][next[i]] < end; ++next[i]) {
          const std::size_t j = candidates[i][next[i]];
          const float cosine =
              a.row(static_cast<Eigen::Index>(begin + i)).dot(b.row(static_cast<Eigen::Index>(j)));
          distinct.Take(begin + i, j, cosine);
          nearest[i].Take(j, cosine);
        }
    for (std::size_t i = 0; i < size; ++i)
      for (const auto& [cosine, j] : nearest[i].Best()) alike.nearest.push_back({begin + i, j});
  }
  alike.distinct = distinct.Matches(ratio);
  return alike;
}

}  // namespace orient

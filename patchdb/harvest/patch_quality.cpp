#include "patchdb/harvest/patch_quality.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/geometry/principal_axes.h"
#include "core/matching/correlation.h"
#include "core/raster/resample.h"

namespace orient::patchdb {
namespace {

constexpr double kMainPeakRadius = 4;  // px, of the autocorrelation
constexpr int kPersistenceMargin = 4;  // px of search around the template on every level
constexpr int kMinTemplate = 7;        // px per side; below, any two textures correlate
constexpr double kMinScore = 0.7;
constexpr double kMaxError = 0.5;  // px
constexpr double kNoiseShare = 0.1;

// Values at which the measures score 1 (or 0, for those that are better small).
constexpr double kDistinctnessScale = 0.5;
constexpr double kPersistenceScale = 3;
constexpr double kDirectionScale = 0.5;  // weakest direction's gradient over the strongest's
constexpr double kReliefScale = 120;     // px: a slope of 45 degrees over 61 px scores 0.5
constexpr double kLeanScale = 8;         // px
constexpr double kResidualScale = 2;     // px

// Ratio of the weakest direction's gradient to the strongest's.
double DirectionRatio(const Eigen::Vector3d& energy) {
  Eigen::Matrix2d matrix;
  matrix << energy[0], energy[1], energy[1], energy[2];
  const PrincipalAxes axes = AxesOf(matrix);
  return axes.values[1] > 0 ? std::sqrt(std::max(axes.values[0], 0.0) / axes.values[1]) : 0;
}

// Score of a texture with this noise against itself with independent noise; since fine texture
// passes for noise, at most half of the variance is taken for noise.
double SelfScore(const Image& image) {
  const double contrast = Contrast(image), noise = NoiseOf(image);
  return contrast > 0 ? std::max(0.5, 1 - noise * noise / (contrast * contrast)) : 1;
}

// copy(p) = level(p + (0.5, 0.5)) + noise.
Image ShiftedNoisyCopy(const Image& level, double noise) {
  std::mt19937 random(1);
  std::normal_distribution<float> deviate(0, static_cast<float>(noise));
  Image copy(level.width, level.height);
  for (int row = 0; row < level.height; ++row)
    for (int col = 0; col < level.width; ++col)
      copy.At(col, row) = SampleBicubic(level, {col + 1.0, row + 1.0}) + deviate(random);
  return copy;
}

bool SurvivesAt(const Image& level, double noise) {
  const int width = level.width - 2 * kPersistenceMargin;
  const int height = level.height - 2 * kPersistenceMargin;
  const Image copy = ShiftedNoisyCopy(level, noise);
  const auto peaks = FindPeaks(Correlate(MiddleOf(level, width, height), copy), 1, 1, kMinScore);
  if (peaks.empty()) return false;
  const double expected = kPersistenceMargin - 0.5;
  return (peaks[0].position - Eigen::Vector2d::Constant(expected)).norm() <= kMaxError;
}

}  // namespace

double Contrast(const Image& image) {
  double sum = 0, squares = 0;
  int count = 0;
  for (const float value : image.values) {
    if (std::isnan(value)) continue;
    sum += value;
    squares += static_cast<double>(value) * value;
    ++count;
  }
  if (count < 2) return 0;
  const double mean = sum / count;
  return std::sqrt(std::max(0.0, squares / count - mean * mean));
}

double NoiseOf(const Image& image) {
  double sum = 0;
  int count = 0;
  for (int row = 1; row + 1 < image.height; ++row)
    for (int col = 1; col + 1 < image.width; ++col) {
      const auto across = [&](int r) {
        return double(image.At(col - 1, r)) - 2 * double(image.At(col, r)) +
               double(image.At(col + 1, r));
      };
      const double left = std::abs(across(row - 1) - 2 * across(row) + across(row + 1));
      if (std::isnan(left)) continue;
      sum += left;
      ++count;
    }
  constexpr double kGain = 6;  // root of the sum of the mask's squares
  return count > 0 ? std::sqrt(M_PI / 2) / kGain * sum / count : 0;
}

std::optional<SecondPeak> FindSecondPeak(const Image& surroundings, int template_px) {
  if (surroundings.width < template_px + 2 || surroundings.height < template_px + 2)
    return std::nullopt;
  const Image middle = MiddleOf(surroundings, template_px, template_px);
  const Image scores = Correlate(middle, surroundings);
  const Eigen::Vector2d itself((surroundings.width - template_px) / 2,
                               (surroundings.height - template_px) / 2);
  const float at_itself = scores.At(static_cast<int>(itself.x()), static_cast<int>(itself.y()));
  if (std::isnan(at_itself)) return std::nullopt;
  const double self = SelfScore(middle);
  SecondPeak second;
  for (const Peak& peak : FindPeaks(scores, 3, kMainPeakRadius, 0)) {
    const double distance = (peak.position - itself).norm();
    const double score = std::min(1.0, peak.score / self);
    if (distance > kMainPeakRadius && score > second.score) second = {score, distance};
  }
  return second;
}

int Persistence(const Image& chip) {
  const double noise = std::max(1.0, kNoiseShare * Contrast(chip));
  Image level = chip;
  int survived = 0;
  while (std::min(level.width, level.height) - 2 * kPersistenceMargin >= kMinTemplate &&
         SurvivesAt(level, noise)) {
    ++survived;
    level = ReduceByTwo(level);
  }
  return survived;
}

Eigen::Vector3d TextureEnergy(const Image& chip) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (int row = 1; row + 1 < chip.height; ++row)
    for (int col = 1; col + 1 < chip.width; ++col) {
      const double east = 0.5 * double(chip.At(col + 1, row) - chip.At(col - 1, row));
      const double north = 0.5 * double(chip.At(col, row - 1) - chip.At(col, row + 1));
      if (std::isnan(east) || std::isnan(north)) continue;
      sum += Eigen::Vector3d(east * east, east * north, north * north);
      ++count;
    }
  return count > 0 ? Eigen::Vector3d(sum / count) : sum;
}

std::optional<double> QualityOf(const Patch& patch) {
  std::vector<double> marks;
  if (patch.distinctness) marks.push_back(*patch.distinctness / kDistinctnessScale);
  if (patch.persistence) marks.push_back(*patch.persistence / kPersistenceScale);
  if (patch.energy) marks.push_back(DirectionRatio(*patch.energy) / kDirectionScale);
  if (patch.relief_px) marks.push_back(1 - *patch.relief_px / kReliefScale);
  if (patch.lean_px) marks.push_back(1 - *patch.lean_px / kLeanScale);
  for (const PatchEvidence& evidence : patch.evidence)
    if (evidence.residual_px) marks.push_back(1 - evidence.residual_px->norm() / kResidualScale);
  if (marks.empty()) return std::nullopt;
  return std::clamp(*std::min_element(marks.begin(), marks.end()), 0.0, 1.0);
}

}  // namespace orient::patchdb

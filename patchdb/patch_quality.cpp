#include "patchdb/patch_quality.h"

#include <random>

#include "core/imaging/correlation.h"
#include "core/imaging/resample.h"

namespace orient {
namespace {

constexpr double kMainPeakRadius = 4;  // px, of the autocorrelation
constexpr int kPersistenceMargin = 4;  // px of search around the template on every level
constexpr int kMinTemplate = 7;        // px a side; below, any two textures correlate
constexpr double kMinScore = 0.7;
constexpr double kMaxError = 0.5;  // px
constexpr double kNoiseShare = 0.1;

Image Middle(const Image& image, int width, int height) {
  Image part(width, height);
  const int col0 = (image.width - width) / 2, row0 = (image.height - height) / 2;
  for (int row = 0; row < height; ++row)
    std::copy_n(image.Row(row0 + row) + col0, width, part.Row(row));
  return part;
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
  const auto peaks = FindPeaks(Correlate(Middle(level, width, height), copy), 1, 1, kMinScore);
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

std::optional<double> Distinctness(const Image& surroundings, int template_px) {
  if (surroundings.width < template_px + 2 || surroundings.height < template_px + 2)
    return std::nullopt;
  const Image scores = Correlate(Middle(surroundings, template_px, template_px), surroundings);
  const Eigen::Vector2d itself((surroundings.width - template_px) / 2,
                               (surroundings.height - template_px) / 2);
  const float at_itself = scores.At(static_cast<int>(itself.x()), static_cast<int>(itself.y()));
  if (std::isnan(at_itself)) return std::nullopt;
  double second = 0;
  for (const Peak& peak : FindPeaks(scores, 3, kMainPeakRadius, 0))
    if ((peak.position - itself).norm() > kMainPeakRadius) second = std::max(second, peak.score);
  return 1 - std::min(second, 1.0);
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

}  // namespace orient

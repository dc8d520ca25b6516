#include "interior/candidates.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/imaging/correlation.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Pixels over the mark's diameter at which its drawing is still clear; more cost time only.
constexpr double kPixelsOverMark = 32;
constexpr double kMinValid = 0.7;

double Reduction(const MarkShape& shape, double pixel_mm) {
  const double wanted = std::clamp(2 * MarkRadius(shape) / kPixelsOverMark, 0.03, 0.12);
  return std::max(1.0, wanted / pixel_mm);
}

// Highest and lowest coefficient over all turns of the template.
struct Scores {
  Image bright, dark;
};

void KeepBest(const Image& scores, Image* best, float sign) {
  if (best->Empty()) *best = Image(scores.width, scores.height, kNoData);
  for (size_t i = 0; i < scores.values.size(); ++i) {
    const float value = sign * scores.values[i];
    if (!(best->values[i] >= value)) best->values[i] = value;
  }
}

Scores CorrelateTurns(const Image& image, const std::vector<MarkTemplate>& templates) {
  Scores scores;
  for (const MarkTemplate& t : templates) {
    const Image ncc = Correlate(t.values, image, kMinValid);
    if (ncc.Empty()) continue;
    KeepBest(ncc, &scores.bright, 1.0f);
    KeepBest(ncc, &scores.dark, -1.0f);
  }
  return scores;
}

std::vector<MarkTemplate> RenderTurns(const MarkShape& shape, const Matrix2d& coarse_from_mm,
                                      const std::vector<double>& turns_rad) {
  RenderOptions render;
  render.background_sigma_px =
      kBackgroundSigmaMm * std::sqrt(std::abs(coarse_from_mm.determinant()));
  std::vector<MarkTemplate> templates;
  for (const double turn : turns_rad)
    templates.push_back(
        RenderMark(shape, Eigen::Rotation2Dd(turn).toRotationMatrix() * coarse_from_mm, render));
  return templates;
}

PixelWindow Grow(const PixelWindow& window, int by) {
  return {window.col - by, window.row - by, window.width + 2 * by, window.height + 2 * by};
}

std::vector<MarkCandidate> Places(const Image& scores, const ImageWindow& window,
                                  const Vector2d& centre, double min_distance,
                                  const MarkSearchOptions& options) {
  std::vector<MarkCandidate> places;
  if (scores.Empty()) return places;
  for (const Peak& peak : FindPeaks(scores, options.max_count, min_distance, options.min_ncc))
    places.push_back({window.RasterFromImage(peak.position + centre), peak.score});
  return places;
}

}  // namespace

MarkCandidates FindMarkCandidates(const Raster& scan, const PixelWindow& window,
                                  const MarkShape& shape, const Matrix2d& pixel_from_mm,
                                  const MarkSearchOptions& options) {
  const double pixel_mm = 1 / std::sqrt(std::abs(pixel_from_mm.determinant()));
  const double reduction = Reduction(shape, pixel_mm);
  const auto templates = RenderTurns(shape, pixel_from_mm / reduction, options.turns_rad);
  MarkCandidates result;
  result.coarse_pixel_mm = reduction * pixel_mm;
  result.searched_mm2 = window.width * pixel_mm * window.height * pixel_mm;
  if (templates.empty() || window.width <= 0 || window.height <= 0) return result;

  // The mark's centre may lie anywhere in the window, its arms outside.
  const int reach = static_cast<int>(std::ceil(templates[0].centre.x() * reduction)) + 1;
  const ImageWindow seen = scan.ReadGrey(Grow(window, reach), reduction);
  const Image flat = RemoveBackground(seen.image, kBackgroundSigmaMm / result.coarse_pixel_mm);
  const Scores scores = CorrelateTurns(flat, templates);
  // A clear mark answers again where ring and arms overlap themselves: no place of its own.
  const double distance = 1.2 * MarkRadius(shape) / result.coarse_pixel_mm;
  result.bright = Places(scores.bright, seen, templates[0].centre, distance, options);
  result.dark = Places(scores.dark, seen, templates[0].centre, distance, options);
  return result;
}

std::vector<double> ScoreNats(const std::vector<MarkCandidate>& candidates) {
  // Clutter's best peaks lie below 0.6 for a drawing with some structure, clear marks above 0.7
  // (measured on scanned film frames).
  constexpr double kEven = 0.6, kAboveClutter = 0.15, kSlope = 10.0, kLimit = 1.5;
  constexpr size_t kEnough = 5;
  double even = kEven;
  if (candidates.size() >= kEnough)  // best first: the middle one is clutter
    even = std::max(even, candidates[candidates.size() / 2].ncc + kAboveClutter);
  std::vector<double> nats;
  for (const MarkCandidate& c : candidates)
    nats.push_back(std::clamp(kSlope * (c.ncc - even), -kLimit, kLimit));
  return nats;
}

}  // namespace orient

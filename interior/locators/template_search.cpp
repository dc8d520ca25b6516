#include "interior/locators/template_search.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/base/median.h"
#include "core/matching/correlation.h"
#include "core/raster/resample.h"
#include "interior/marks/match_precision.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Pixels over the mark's diameter at which its drawing is still clear; more cost time only.
constexpr double kPixelsOverMark = 32;
// With fewer than this at half resolution, strokes merge: such marks are searched at full at once.
constexpr double kFewestPixelsOverMark = 13;
constexpr double kMinValid = 0.7;
constexpr double kHardlyReduced = 1.5;  // the scan's grain is not averaged away

double FineReduction(const MarkShape& shape, double pixel_mm) {
  const double wanted = std::clamp(2 * MarkRadius(shape) / kPixelsOverMark, 0.03, 0.12);
  return std::max(1.0, wanted / pixel_mm);
}

double MmOfPixel(const Matrix2d& pixel_from_mm) {
  return 1 / std::sqrt(std::abs(pixel_from_mm.determinant()));
}

// Strokes all thinner than a pixel of the scan vanish at half its resolution where the scanner
// sharpened them: the dark edges that it gave them are as wide. A search that reduces the scan
// averages them anyway.
bool VanishesAtHalf(const MarkShape& shape, const Matrix2d& pixel_from_mm, double reduction) {
  return !shape.picture && reduction < kHardlyReduced &&
         WidestStroke(shape) < MmOfPixel(pixel_from_mm);
}

std::vector<MarkTemplate> MakeTurns(const TemplateMaker& make, const Matrix2d& pixel_from_mm,
                                    const std::vector<double>& turns_rad) {
  std::vector<MarkTemplate> templates;
  templates.reserve(turns_rad.size());
  for (const double turn : turns_rad)
    templates.push_back(make(Eigen::Rotation2Dd(turn).toRotationMatrix() * pixel_from_mm));
  return templates;
}

// Highest and lowest coefficient over all rotations of the template.
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

// Maximum of the parabola through three values, from the middle one; at most half a step.
double ParabolaTop(double before, double middle, double after) {
  const double curvature = before - 2 * middle + after;
  if (!(curvature < 0)) return 0;
  return std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
}

// Refines places at the finer resolution.
class Refiner {
 public:
  // `spots` are the templates of `turns`.
  Refiner(const Image& image, const std::vector<MarkTemplate>& turns,
          const std::vector<SpotTemplate>& spots)
      : image_(image), turns_(turns), spots_(spots) {}

  // `centre`: of the mark, image pixels; `sign`: +1 for bright marks, -1 for dark ones. Zero score
  // where it leaves the image.
  Peak Refine(const Vector2d& centre, double sign) {
    const size_t upright = turns_.size() / 2;
    const Vector2d corner = (centre - turns_[upright].centre).array().round();
    size_t best = upright;
    Place place =
        Climb(upright, {static_cast<int>(corner.x()), static_cast<int>(corner.y()), -2}, sign);
    for (size_t turned = 0; turned < turns_.size(); ++turned) {
      if (turned == upright || turns_[turned].values.width != turns_[upright].values.width)
        continue;
      const double score = At(turned, place.col, place.row, sign);
      if (!(score > place.score)) continue;
      place.score = score;
      best = turned;
    }
    if (best != upright) place = Climb(best, place, sign);
    return Top(best, place, sign);
  }

 private:
  struct Place {
    int col = 0, row = 0;
    double score = 0;
  };

  // Remembered, as neighbours need the same places.
  double At(size_t turn, int col, int row, double sign) {
    const auto [known, fresh] = known_.try_emplace({turn, col, row}, 0);
    if (fresh) known->second = image_.Correlate(spots_[turn], col, row, kMinValid);
    return std::isfinite(known->second) ? sign * known->second : -2;
  }

  // Moves to the highest coefficient nearby.
  Place Climb(size_t turn, Place place, double sign) {
    constexpr int kMostSteps = 4;
    place.score = At(turn, place.col, place.row, sign);
    for (int step = 0; step < kMostSteps; ++step) {
      Place best = place;
      for (int dr = -1; dr <= 1; ++dr)
        for (int dc = -1; dc <= 1; ++dc) {
          const double score = At(turn, place.col + dc, place.row + dr, sign);
          if (score > best.score) best = {place.col + dc, place.row + dr, score};
        }
      if (best.col == place.col && best.row == place.row) break;
      place = best;
    }
    return place;
  }

  Peak Top(size_t turn, const Place& p, double sign) {
    const auto at = [&](int dc, int dr) { return At(turn, p.col + dc, p.row + dr, sign); };
    const Vector2d offset(ParabolaTop(at(-1, 0), p.score, at(1, 0)),
                          ParabolaTop(at(0, -1), p.score, at(0, 1)));
    return {Vector2d(p.col, p.row) + offset + turns_[turn].centre, std::max(p.score, 0.0)};
  }

  SpotImage image_;
  const std::vector<MarkTemplate>& turns_;
  const std::vector<SpotTemplate>& spots_;
  std::map<std::tuple<size_t, int, int>, double> known_;
};

// Sigma of the grain, from pixels three apart, where it is hardly correlated; picture content that
// covers less than three quarters of the image hardly counts, and clipped grey values not at all.
double GrainOf(const Image& image) {
  constexpr int kApart = 3, kEvery = 3;
  constexpr double kQuartile = 0.3186;  // of the absolute value of a normal variable of sigma 1
  std::vector<double> bends;
  for (int row = 0; row < image.height; row += kEvery)
    for (int col = kApart; col < image.width - kApart; col += kEvery) {
      const float bend =
          image.At(col - kApart, row) - 2 * image.At(col, row) + image.At(col + kApart, row);
      if (std::isfinite(bend) && bend != 0) bends.push_back(std::abs(bend));
    }
  return bends.empty() ? 0 : LowerQuartile(std::move(bends)) / (kQuartile * std::sqrt(6.0));
}

// The coefficient that a faint mark would have without the scan's grain, in place of the one that
// the grain leaves it. `grain`: its sigma; `places`: centres of marks in the image; `sign`: +1 for
// bright ones.
void ScoreWithoutGrain(const Image& image, double grain, const MarkTemplate& drawn, double sign,
                       std::vector<Peak>* places) {
  // Grain in a window of 15 mm reaches it once in ten.
  constexpr double kLeastGain = kHighestGainOfGrain + 0.5;
  // Of the grain's sigma. What is larger is another mark, or the picture.
  constexpr double kMostResidual = 3;
  const double most_residual = kMostResidual * grain;
  Image model = drawn.values;
  for (float& value : model.values)
    if (!std::isfinite(value)) value = 0;
  for (Peak& place : *places) {
    const Vector2d corner = (place.position - drawn.centre).array().round();
    const int col = static_cast<int>(corner.x()), row = static_cast<int>(corner.y());
    Image seen(model.width, model.height, kNoData);
    for (int r = std::max(0, -row); r < std::min(seen.height, image.height - row); ++r)
      for (int c = std::max(0, -col); c < std::min(seen.width, image.width - col); ++c)
        if (std::isfinite(drawn.values.At(c, r))) seen.At(c, r) = image.At(c + col, r + row);
    const auto without = CorrelationWithoutGrain(seen, model, Vector2d::Zero(), most_residual);
    if (!without || *without < std::max(kLeastWithoutGrain, place.score)) continue;
    const auto match = PrecisionOfMatch(seen, model, Vector2d::Zero());
    if (match && sign * match->gain_over_sigma > kLeastGain) place.score = *without;
  }
}

// Best first, none within `min_distance` of a better one.
std::vector<Peak> WithoutDoubles(std::vector<Peak> peaks, double min_distance, size_t max_count) {
  std::sort(peaks.begin(), peaks.end(),
            [](const Peak& a, const Peak& b) { return a.score > b.score; });
  std::vector<Peak> kept;
  for (const Peak& peak : peaks) {
    const bool near = std::any_of(kept.begin(), kept.end(), [&](const Peak& better) {
      return (better.position - peak.position).norm() < min_distance;
    });
    if (!near && kept.size() < max_count) kept.push_back(peak);
  }
  return kept;
}

std::vector<Peak> CentrePeaks(const Image& scores, const Vector2d& centre, int max_count,
                              double distance, double min_score) {
  if (scores.Empty()) return {};
  std::vector<Peak> peaks = FindPeaks(scores, max_count, distance, min_score);
  for (Peak& peak : peaks) peak.position += centre;
  return peaks;
}

std::vector<MarkCandidate> AsCandidates(const std::vector<Peak>& peaks, const ImageWindow& window) {
  std::vector<MarkCandidate> candidates;
  candidates.reserve(peaks.size());
  for (const Peak& peak : peaks)
    candidates.push_back({window.RasterFromImage(peak.position), peak.score});
  return candidates;
}

}  // namespace

PixelWindow Grow(const PixelWindow& window, int by) {
  return {window.col - by, window.row - by, window.width + 2 * by, window.height + 2 * by};
}

const TemplateSearch::Templates& TemplateSearch::TemplatesFor(const MarkShape& shape,
                                                              const MarkSearch& search,
                                                              const TemplateMaker& make) const {
  const Matrix2d& m = search.pixel_from_mm;
  Key key{&shape, {m(0, 0), m(0, 1), m(1, 0), m(1, 1)}};
  key.second.insert(key.second.end(), search.turns_rad.begin(), search.turns_rad.end());
  const std::lock_guard lock(mutex_);
  const auto known = made_.find(key);
  if (known != made_.end()) return known->second;
  Templates templates;  // stored only if complete: rendering may throw
  templates.reduction = FineReduction(shape, MmOfPixel(m));
  templates.turns = MakeTurns(make, m / templates.reduction, search.turns_rad);
  for (const MarkTemplate& turned : templates.turns) templates.spots.emplace_back(turned.values);
  const double half_over_mark = MarkRadius(shape) / (templates.reduction * MmOfPixel(m));
  if (half_over_mark >= kFewestPixelsOverMark && !VanishesAtHalf(shape, m, templates.reduction))
    templates.half = {make(m / (2 * templates.reduction))};
  return made_.emplace(std::move(key), std::move(templates)).first->second;
}

MarkCandidates TemplateSearch::Find(ScanWindows& scan, const MarkShape& shape,
                                    const MarkSearch& search, const TemplateMaker& make) const {
  const double pixel_mm = MmOfPixel(search.pixel_from_mm);
  MarkCandidates result;
  result.searched_mm2 = search.window.width * pixel_mm * search.window.height * pixel_mm;
  result.coarse_pixel_mm = pixel_mm;
  if (search.turns_rad.empty() || search.window.width <= 0 || search.window.height <= 0)
    return result;
  const Templates& templates = TemplatesFor(shape, search, make);
  const std::vector<MarkTemplate>& turns = templates.turns;
  result.coarse_pixel_mm = templates.reduction * pixel_mm;
  const int reach = static_cast<int>(std::ceil(turns[0].centre.x() * templates.reduction)) + 1;
  const ImageWindow& seen = scan.Read(Grow(search.window, reach), templates.reduction);
  const Image flat = RemoveBackground(seen.image, kBackgroundSigmaMm / result.coarse_pixel_mm);

  // A clear mark has side maxima where ring and arms overlap themselves: no separate marks.
  const double distance = 1.2 * MarkRadius(shape) / result.coarse_pixel_mm;
  const bool grainy = drawn_ && !shape.picture && templates.reduction < kHardlyReduced;
  const double grain = grainy ? GrainOf(seen.image) : 0;
  // More places than asked for, as their order may change, and those that grain keeps below.
  const int looked_at = search.max_count + search.max_count / 2;
  const double least = (grainy ? 0.6 : 1) * search.min_ncc;
  const auto best_of = [&](std::vector<Peak> places, double sign) {
    std::erase_if(places, [&](const Peak& place) { return place.score < least; });
    if (grainy) ScoreWithoutGrain(flat, grain, turns[turns.size() / 2], sign, &places);
    std::erase_if(places, [&](const Peak& place) { return place.score < search.min_ncc; });
    return AsCandidates(
        WithoutDoubles(std::move(places), distance, static_cast<size_t>(search.max_count)), seen);
  };
  if (templates.half.empty()) {
    const Scores scores = CorrelateTurns(flat, turns);
    const auto places = [&](const Image& image) {
      return CentrePeaks(image, turns[0].centre, looked_at, distance, least);
    };
    result.bright = best_of(places(scores.bright), 1);
    result.dark = best_of(places(scores.dark), -1);
    return result;
  }
  const Scores scores = CorrelateTurns(ReduceBy(flat, 2), templates.half);
  Refiner refiner(flat, turns, templates.spots);
  const auto refined = [&](const Image& coarse, double sign) {
    std::vector<Peak> peaks = CentrePeaks(coarse, templates.half[0].centre, looked_at,
                                          0.4 * distance, 0.5 * search.min_ncc);
    for (Peak& peak : peaks) peak = refiner.Refine(2 * peak.position, sign);
    return best_of(std::move(peaks), sign);
  };
  result.bright = refined(scores.bright, 1);
  result.dark = refined(scores.dark, -1);
  return result;
}

}  // namespace orient::interior

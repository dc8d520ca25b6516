#include "interior/template_search.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "core/imaging/correlation.h"
#include "core/imaging/resample.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Pixels over the mark's diameter at which its drawing is still clear; more cost time only.
constexpr double kPixelsOverMark = 32;
// At half of them strokes run together for small marks only: those are searched at once.
constexpr double kFewestPixelsOverMark = 13;
constexpr double kMinValid = 0.7;

double FineReduction(const MarkShape& shape, double pixel_mm) {
  const double wanted = std::clamp(2 * MarkRadius(shape) / kPixelsOverMark, 0.03, 0.12);
  return std::max(1.0, wanted / pixel_mm);
}

double MmOfPixel(const Matrix2d& pixel_from_mm) {
  return 1 / std::sqrt(std::abs(pixel_from_mm.determinant()));
}

std::vector<MarkTemplate> MakeTurns(const TemplateMaker& make, const Matrix2d& pixel_from_mm,
                                    const std::vector<double>& turns_rad) {
  std::vector<MarkTemplate> templates;
  templates.reserve(turns_rad.size());
  for (const double turn : turns_rad)
    templates.push_back(make(Eigen::Rotation2Dd(turn).toRotationMatrix() * pixel_from_mm));
  return templates;
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

// Top of the parabola through three values, from the middle one; at most half a step.
double ParabolaTop(double before, double middle, double after) {
  const double curvature = before - 2 * middle + after;
  if (!(curvature < 0)) return 0;
  return std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
}

// A place looked at again at the finer resolution.
class Refiner {
 public:
  Refiner(const Image& image, const std::vector<MarkTemplate>& turns, float sign)
      : image_(image), turns_(turns), sign_(sign) {}

  // `centre`: of the mark, image pixels. Zero score where it leaves the image.
  Peak Refine(const Vector2d& centre) const {
    const MarkTemplate& upright = turns_[turns_.size() / 2];
    const Vector2d corner = (centre - upright.centre).array().round();
    Place place = Climb(upright, {static_cast<int>(corner.x()), static_cast<int>(corner.y()), -2});
    const MarkTemplate* best = &upright;
    for (const MarkTemplate& turned : turns_) {
      if (&turned == &upright || turned.values.width != upright.values.width) continue;
      const double score = At(turned, place.col, place.row);
      if (!(score > place.score)) continue;
      place.score = score;
      best = &turned;
    }
    if (best != &upright) place = Climb(*best, place);
    return Top(*best, place);
  }

 private:
  struct Place {
    int col = 0, row = 0;
    double score = 0;
  };

  double At(const MarkTemplate& t, int col, int row) const {
    const double score =
        static_cast<double>(sign_) * CorrelateAt(t.values, image_, col, row, kMinValid);
    return std::isfinite(score) ? score : -2;
  }

  // To the highest coefficient nearby.
  Place Climb(const MarkTemplate& t, Place place) const {
    constexpr int kMostSteps = 4;
    place.score = At(t, place.col, place.row);
    for (int step = 0; step < kMostSteps; ++step) {
      Place best = place;
      for (int dr = -1; dr <= 1; ++dr)
        for (int dc = -1; dc <= 1; ++dc) {
          if (dc == 0 && dr == 0) continue;
          const double score = At(t, place.col + dc, place.row + dr);
          if (score > best.score) best = {place.col + dc, place.row + dr, score};
        }
      if (best.col == place.col && best.row == place.row) break;
      place = best;
    }
    return place;
  }

  Peak Top(const MarkTemplate& t, const Place& p) const {
    const Vector2d offset(ParabolaTop(At(t, p.col - 1, p.row), p.score, At(t, p.col + 1, p.row)),
                          ParabolaTop(At(t, p.col, p.row - 1), p.score, At(t, p.col, p.row + 1)));
    return {Vector2d(p.col, p.row) + offset + t.centre, std::max(p.score, 0.0)};
  }

  const Image& image_;
  const std::vector<MarkTemplate>& turns_;
  float sign_;
};

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

double CorrelateAt(const Image& templ, const Image& image, int col, int row, double min_valid) {
  if (col < 0 || row < 0 || col + templ.width > image.width || row + templ.height > image.height)
    return std::nan("");
  double n = 0, drawn = 0, t = 0, i = 0, tt = 0, ii = 0, ti = 0;
  for (int r = 0; r < templ.height; ++r) {
    const float* a = templ.Row(r);
    const float* b = image.Row(row + r) + col;
    float sn = 0, sd = 0, st = 0, si = 0, stt = 0, sii = 0, sti = 0;
    for (int c = 0; c < templ.width; ++c) {
      const bool part = a[c] == a[c], both = part && b[c] == b[c];
      const float x = both ? a[c] : 0.0f, y = both ? b[c] : 0.0f;
      sd += part ? 1.0f : 0.0f;
      sn += both ? 1.0f : 0.0f;
      st += x;
      si += y;
      stt += x * x;
      sii += y * y;
      sti += x * y;
    }
    n += static_cast<double>(sn);
    drawn += static_cast<double>(sd);
    t += static_cast<double>(st);
    i += static_cast<double>(si);
    tt += static_cast<double>(stt);
    ii += static_cast<double>(sii);
    ti += static_cast<double>(sti);
  }
  if (n < std::max(2.0, min_valid * drawn)) return std::nan("");
  const double var_t = tt - t * t / n, var_i = ii - i * i / n;
  if (!(var_t > 1e-10 * tt) || !(var_i > 1e-6 * ii)) return std::nan("");
  return (ti - t * i / n) / std::sqrt(var_t * var_i);
}

const TemplateSearch::Templates& TemplateSearch::TemplatesFor(const MarkShape& shape,
                                                              const MarkSearch& search,
                                                              const TemplateMaker& make) const {
  const Matrix2d& m = search.pixel_from_mm;
  Key key{&shape, {m(0, 0), m(0, 1), m(1, 0), m(1, 1)}};
  key.second.insert(key.second.end(), search.turns_rad.begin(), search.turns_rad.end());
  const std::lock_guard lock(mutex_);
  const auto [entry, fresh] = made_.try_emplace(key);
  Templates& templates = entry->second;
  if (!fresh) return templates;
  templates.reduction = FineReduction(shape, MmOfPixel(m));
  templates.turns = MakeTurns(make, m / templates.reduction, search.turns_rad);
  const double half_over_mark = MarkRadius(shape) / (templates.reduction * MmOfPixel(m));
  if (half_over_mark >= kFewestPixelsOverMark)
    templates.half = {make(m / (2 * templates.reduction))};
  return templates;
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

  // A clear mark answers again where ring and arms overlap themselves: no place of its own.
  const double distance = 1.2 * MarkRadius(shape) / result.coarse_pixel_mm;
  if (templates.half.empty()) {
    const Scores scores = CorrelateTurns(flat, turns);
    const auto peaks = [&](const Image& image) {
      return AsCandidates(
          CentrePeaks(image, turns[0].centre, search.max_count, distance, search.min_ncc), seen);
    };
    result.bright = peaks(scores.bright);
    result.dark = peaks(scores.dark);
    return result;
  }
  const Scores scores = CorrelateTurns(ReduceBy(flat, 2), templates.half);
  const auto refined = [&](const Image& coarse, float sign) {
    // More places than asked for, as their order may change.
    const int looked_at = search.max_count + search.max_count / 2;
    std::vector<Peak> peaks = CentrePeaks(coarse, templates.half[0].centre, looked_at,
                                          0.4 * distance, 0.5 * search.min_ncc);
    const Refiner refiner(flat, turns, sign);
    for (Peak& peak : peaks) peak = refiner.Refine(2 * peak.position);
    std::erase_if(peaks, [&](const Peak& peak) { return peak.score < search.min_ncc; });
    return AsCandidates(
        WithoutDoubles(std::move(peaks), distance, static_cast<size_t>(search.max_count)), seen);
  };
  result.bright = refined(scores.bright, 1.0f);
  result.dark = refined(scores.dark, -1.0f);
  return result;
}

}  // namespace orient

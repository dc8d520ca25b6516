#include "block/roll/mark_looks.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "core/matching/correlation.h"
#include "core/raster/resample.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Elements = std::vector<MarkElement>;
using Fit = std::optional<interior::FittedDrawing>;

constexpr size_t kMostFitted = 3;    // sightings of a mark, or marks of a look, used in a fit
constexpr double kAsWell = 0.06;     // loss of correlation accepted with another mark's drawing
constexpr double kLeastDrawn = 0.7;  // mean correlation of a drawing; marks below it get a picture
constexpr double kLeastShared = 0.65;  // the same for a drawing shared by this many marks:
constexpr size_t kSharedBy = 3;

std::string LookName(const MarkSeen& mark) { return "mark_" + mark.id; }

// A mark's first sightings, to which drawings are fitted and compared.
using Seen = std::vector<interior::SeenMark>;

Seen FirstSeen(const MarkSeen& mark) {
  Seen seen;
  for (const Sighting& sighting : mark.sightings)
    if (seen.size() < kMostFitted) seen.push_back(sighting.seen);
  return seen;
}

// The drawing's mean correlation with a mark, over the surroundings that both drawings need.
double ScoreBeside(const Elements& drawing, const Elements& other, const Seen& mark) {
  const double radius = std::max(interior::RadiusOf(drawing), interior::RadiusOf(other));
  return interior::LocateDrawing(drawing, mark, radius).MeanCorrelation();
}

// Candidate drawings of the camera's marks: each mark's own and, if none of these explains all
// marks, one fitted to all of them together.
class Candidates {
 public:
  Candidates(const std::vector<Fit>& fits, const std::vector<Seen>& marks) : marks_(marks) {
    for (const Fit& fit : fits) drawings_.push_back(fit ? fit->elements : Elements());
    explained_.assign(drawings_.size(), std::vector<bool>(marks.size(), false));
    SideBySide(drawings_.size(), [&](size_t k) { Explain(k); });
    const auto everything = [](const std::vector<bool>& marks_explained) {
      return std::find(marks_explained.begin(), marks_explained.end(), false) ==
             marks_explained.end();
    };
    if (std::any_of(explained_.begin(), explained_.end(), everything)) return;
    Seen all;
    for (const Seen& mark : marks)
      if (all.size() <= kMostFitted) all.push_back(mark.front());
    const Fit together = interior::FitDrawing(all);
    if (!together) return;
    drawings_.push_back(together->elements);
    explained_.emplace_back(marks.size(), false);
    Explain(drawings_.size() - 1);
  }

  const Elements& Drawing(size_t k) const { return drawings_[k]; }

  // The drawing that explains most of the remaining marks, and these marks: marks of one camera
  // mostly look alike. Among several, the one that explains them best. No marks if nothing is
  // explained.
  std::pair<size_t, std::vector<size_t>> Best(const std::vector<bool>& left) const {
    std::pair<size_t, std::vector<size_t>> best;
    for (size_t k = 0; k < drawings_.size(); ++k) {
      std::vector<size_t> marks;
      for (size_t i = 0; i < marks_.size(); ++i)
        if (left[i] && explained_[k][i]) marks.push_back(i);
      if (marks.empty() || marks.size() < best.second.size()) continue;
      if (marks.size() > best.second.size() || IsBetter(k, best.first, marks)) best = {k, marks};
    }
    return best;
  }

 private:
  void Explain(size_t k) {
    for (size_t i = 0; i < marks_.size(); ++i) explained_[k][i] = Explains(k, i);
  }

  bool Explains(size_t k, size_t i) const {
    const Elements &drawing = drawings_[k], &own = drawings_[i];
    if (k == i || drawing.empty()) return !drawing.empty();
    const double score = ScoreBeside(drawing, own, marks_[i]);
    return score >= (own.empty() ? kLeastShared : ScoreBeside(own, drawing, marks_[i]) - kAsWell);
  }

  bool IsBetter(size_t k, size_t than, const std::vector<size_t>& marks) const {
    double gain = 0;
    for (const size_t i : marks)
      gain += ScoreBeside(drawings_[k], drawings_[than], marks_[i]) -
              ScoreBeside(drawings_[than], drawings_[k], marks_[i]);
    return gain > 0;
  }

  const std::vector<Seen>& marks_;
  std::vector<Elements> drawings_;
  std::vector<std::vector<bool>> explained_;  // per drawing and mark
};

// The drawing, refitted to up to kMostFitted marks of a group if that explains them better.
Elements Refined(const Elements& drawing, const std::vector<const MarkSeen*>& group) {
  std::vector<interior::SeenMark> seen;
  for (const MarkSeen* mark : group)
    if (seen.size() < kMostFitted) seen.push_back(mark->sightings.front().seen);
  const auto fitted = seen.size() > 1 ? interior::FitDrawing(seen) : std::nullopt;
  if (!fitted) return drawing;
  const double radius = std::max(interior::RadiusOf(fitted->elements), interior::RadiusOf(drawing));
  const auto score = [&](const Elements& elements) {
    return interior::LocateDrawing(elements, seen, radius).MeanCorrelation();
  };
  return score(fitted->elements) > score(drawing) ? fitted->elements : drawing;
}

// Measures the mark on all scans.
void Measure(const Elements& drawing, MarkSeen* mark) {
  std::vector<interior::SeenMark> seen;
  for (const Sighting& sighting : mark->sightings) seen.push_back(sighting.seen);
  const auto located = interior::LocateDrawing(drawing, seen);
  for (size_t k = 0; k < seen.size(); ++k) {
    Sighting& sighting = mark->sightings[k];
    const bool measured = located.correlation[k] > 0 && sighting.seen.reach_px > 0;
    if (measured) sighting.place = sighting.window.RasterFromImage(located.centre[k]);
  }
  mark->correlation = located.MeanCorrelation();
}

// Finds looks drawn by elements and measures the marks that have them; the others stay in `left`.
std::vector<Look> DrawnLooks(const Candidates& candidates, std::vector<MarkSeen>* marks,
                             std::vector<bool>* left) {
  std::vector<Look> looks;
  std::vector<bool> open(marks->size(), true);
  for (;;) {
    const auto [k, explained] = candidates.Best(open);
    if (explained.empty()) return looks;
    std::vector<const MarkSeen*> group;
    for (const size_t i : explained) group.push_back(&(*marks)[i]);
    const Elements drawing = Refined(candidates.Drawing(k), group);
    double mean = 0;
    for (const size_t i : explained) {
      open[i] = false;
      Measure(drawing, &(*marks)[i]);
      mean += (*marks)[i].correlation / static_cast<double>(explained.size());
    }
    if (mean < (explained.size() >= kSharedBy ? kLeastShared : kLeastDrawn)) continue;
    for (const size_t i : explained) {
      (*marks)[i].look = looks.size();
      (*left)[i] = false;
    }
    looks.emplace_back();
    looks.back().name = LookName((*marks)[explained.front()]);
    looks.back().elements = drawing;
  }
}

// The part of the scan around `centre` (pixels of the image) as the positive shows it upright.
Image Upright(const interior::SeenMark& seen, const Vector2d& centre, double pixel_mm,
              int half_px) {
  Image picture(2 * half_px + 1, 2 * half_px + 1);
  for (int row = 0; row < picture.height; ++row)
    for (int col = 0; col < picture.width; ++col) {
      const Vector2d mm = pixel_mm * Vector2d(col - half_px, half_px - row);
      picture.At(col, row) = SampleBicubic(seen.image, centre + seen.pixel_from_mm * mm);
    }
  return picture;
}

// Where a further scan shows the picture, pixels of its image: the best within the click's reach.
Vector2d PlaceOfPicture(const Image& picture, const interior::SeenMark& seen, double pixel_mm) {
  const int reach = static_cast<int>(std::ceil(seen.reach_px));
  if (reach == 0) return seen.near;
  const Image around = Upright(seen, seen.near, pixel_mm, picture.width / 2 + reach);
  const auto peaks = FindPeaks(Correlate(picture, around), 1, 1, -1.0);
  if (peaks.empty()) return seen.near;
  const Vector2d shift = peaks[0].position - Vector2d::Constant(reach);
  return seen.near + seen.pixel_from_mm * (pixel_mm * Vector2d(shift.x(), -shift.y()));
}

bool IsWhole(const Image& picture) {
  return std::all_of(picture.values.begin(), picture.values.end(),
                     [](float value) { return std::isfinite(value); });
}

// Normalises to mean 0 and variance 1, as scans differ in contrast.
Image Standardised(Image picture) {
  const auto count = static_cast<Eigen::Index>(picture.values.size());
  Eigen::Map<Eigen::ArrayXf> values(picture.values.data(), count);
  values -= values.mean();
  values /= std::max(std::sqrt(values.square().mean()), 1e-6f);
  return picture;
}

// Stretches the grey values to 0 .. 255.
Image Stretched(Image picture) {
  const auto [low, high] = std::minmax_element(picture.values.begin(), picture.values.end());
  const float from = *low, step = 255.0f / std::max(*high - *low, 1e-6f);
  for (float& value : picture.values) value = (value - from) * step;
  return picture;
}

// A mark's picture, cut out at the first scan's click and averaged with scans that show it whole.
Look PictureOf(MarkSeen* mark, double radius_mm) {
  const Sighting& at_first = mark->sightings.front();
  const interior::SeenMark& first = at_first.seen;
  const double pixel_mm = 1 / std::sqrt(std::abs(first.pixel_from_mm.determinant()));
  const int half_px = std::max(3, static_cast<int>(std::ceil(radius_mm / pixel_mm)));
  const Image upright = Upright(first, first.near, pixel_mm, half_px);
  if (!IsWhole(upright))
    throw InputError(
        fmt::format("no drawing explains mark {}, and a picture of it, {:g} mm to each side, would "
                    "reach beyond the scan of photo {}: leave the mark out, or make "
                    "--template-radius-mm smaller",
                    mark->id, radius_mm, at_first.photo));
  Image sum = Standardised(upright);
  for (size_t k = 1; k < mark->sightings.size(); ++k) {
    Sighting& sighting = mark->sightings[k];
    const Vector2d centre = PlaceOfPicture(upright, sighting.seen, pixel_mm);
    sighting.place = sighting.window.RasterFromImage(centre);
    Image further = Upright(sighting.seen, centre, pixel_mm, half_px);
    if (!IsWhole(further)) continue;
    further = Standardised(std::move(further));
    for (size_t i = 0; i < sum.values.size(); ++i) sum.values[i] += further.values[i];
  }
  Look look;
  look.name = LookName(*mark);
  look.picture = Stretched(std::move(sum));
  look.pixel_mm = pixel_mm;
  look.centre_px = Vector2d::Constant(half_px + 0.5);
  return look;
}

// Whether a drawn mark lies in the picture itself: its surroundings vary by more than a fifth of
// the mark's contrast.
bool LiesInPicture(const std::vector<MarkElement>& elements, const Sighting& sighting) {
  constexpr double kNearest_mm = 0.15, kFarthest_mm = 0.7, kPicture = 0.2;
  const MarkDrawing drawing{elements, MarkBackground::kDark, std::nullopt};
  const Matrix2d mm_from_pixel = sighting.seen.pixel_from_mm.inverse();
  const Vector2d centre = sighting.window.ImageFromRaster(sighting.place);
  std::vector<double> strokes, surroundings;
  const Image& image = sighting.seen.image;
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const Vector2d mm = mm_from_pixel * (Vector2d(col + 0.5, row + 0.5) - centre);
      const double distance = interior::StrokeDistance(drawing, mm);
      const auto value = static_cast<double>(image.At(col, row));
      if (!std::isfinite(value)) continue;
      if (distance < 0) strokes.push_back(value);
      if (distance > kNearest_mm && distance < kFarthest_mm) surroundings.push_back(value);
    }
  if (strokes.empty() || surroundings.size() < 10) return false;
  const double contrast = std::abs(Median(strokes) - Median(surroundings));
  return Robust(surroundings).sigma > kPicture * contrast;
}

// The background of a look's marks, by the majority of their sightings.
MarkBackground BackgroundOf(const Look& look, size_t index, const std::vector<MarkSeen>& marks) {
  int in_picture = 0, seen = 0;
  for (const MarkSeen& mark : marks)
    for (const Sighting& sighting : mark.sightings) {
      if (mark.look != index) continue;
      ++seen;
      if (LiesInPicture(look.elements, sighting)) ++in_picture;
    }
  return 2 * in_picture > seen ? MarkBackground::kImage : MarkBackground::kDark;
}

// Gives a mark that no drawing explains well a drawing that several other marks share, if the mark
// is recognised with it. Measures the mark there.
bool JoinsALook(const std::vector<Look>& looks, const std::vector<MarkSeen>& marks,
                const std::vector<bool>& left, MarkSeen* mark) {
  constexpr double kRecognised = 0.5;
  for (size_t k = 0; k < looks.size(); ++k) {
    size_t members = 0;
    for (size_t i = 0; i < marks.size(); ++i)
      if (!left[i] && marks[i].look == k) ++members;
    if (members < kSharedBy || looks[k].elements.empty()) continue;
    Measure(looks[k].elements, mark);
    if (mark->correlation < kRecognised) continue;
    mark->look = k;
    return true;
  }
  return false;
}

}  // namespace

std::vector<Look> FindLooks(double picture_radius_mm, std::vector<MarkSeen>* marks) {
  std::vector<Seen> seen;
  for (const MarkSeen& mark : *marks) seen.push_back(FirstSeen(mark));
  std::vector<Fit> fits(seen.size());
  SideBySide(seen.size(), [&](size_t i) { fits[i] = interior::FitDrawing(seen[i]); });
  std::vector<bool> left(marks->size(), true);
  std::vector<Look> looks = DrawnLooks(Candidates(fits, seen), marks, &left);
  for (size_t i = 0; i < marks->size(); ++i) {
    if (!left[i]) continue;
    MarkSeen& mark = (*marks)[i];
    if (JoinsALook(looks, *marks, left, &mark)) continue;
    mark.correlation = 0;
    mark.look = looks.size();
    for (Sighting& sighting : mark.sightings)
      sighting.place = sighting.window.RasterFromImage(sighting.seen.near);
    looks.push_back(PictureOf(&mark, picture_radius_mm));
  }
  for (size_t k = 0; k < looks.size(); ++k)
    if (!looks[k].elements.empty()) looks[k].background = BackgroundOf(looks[k], k, *marks);
  return looks;
}

}  // namespace orient::block

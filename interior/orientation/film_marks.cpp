#include "interior/orientation/film_marks.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "interior/constellation/clicked_film.h"
#include "interior/constellation/set_evidence.h"
#include "interior/locators/lines_locator.h"
#include "interior/locators/locator.h"
#include "interior/marks/match_precision.h"
#include "interior/orientation/reseau.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kMinCorrelation = 0.45;
constexpr double kMinOfMedianCorrelation = 0.6;

// Linear part of scan pixel from photo mm, as the assigned candidates show it.
Matrix2d PixelFromMm(const CameraFile& camera, const FilmReading& reading) {
  const ScanOrientation orientation = reading.orientations.front();
  std::vector<PointPair2d> pairs;
  for (size_t i = 0; i < reading.candidates.size(); ++i)
    if (reading.best.choice[i] >= 0)
      pairs.push_back(
          {camera.fiducials[i].position_mm, reading.candidates[i][reading.best.choice[i]].pixel});
  const Matrix2d nominal =
      PhotoFromPixelAxes(orientation).transpose() / reading.pixel_size.pixel_mm;
  if (pairs.size() < 3) return nominal;
  const auto fit =
      pairs.size() >= 4 ? FitAffine(pairs) : FitSimilarity(pairs, !IsMirrored(orientation));
  return fit ? fit->transform.A : nominal;
}

// A plain cross within the picture: there the two sides of a stroke mostly
// differ, and least-squares matching, which does not model this, is pulled to the brighter one: on
// simulated P31 scans its errors are half as large again as those of the lines
// (docs/evidence/interior.md has the figures). On a dark corner it sees more of the mark than its
// lines do.
bool MeasuredByLines(const MarkShape& shape, std::optional<LocatorKind> wanted) {
  return UsualLocator(shape) == LocatorKind::kLines &&
         LocatorFor(shape, wanted) == LocatorKind::kLines;
}

// The strokes of real crosses on picture texture, dust and scratches on them included, against
// those of the texture between them: of 968 clean crosses of simulated films 99 % are clear, of 968
// places in the middle of the meshes one. Crossings of the picture's roads are as clear as crosses.
bool IsClear(const MeasuredCross& cross) {
  constexpr double kLeastShare = 0.75, kLeastNats = 2;
  return cross.share >= kLeastShare && cross.nats >= kLeastNats;
}

// Replaces the matched position, which stays where the lines are not seen.
void MeasureByLines(const Raster& scan, const CrossElement& cross, const Matrix2d& pixel_from_mm,
                    Polarity polarity, double max_shift_px, FilmMark* mark) {
  const auto crossing =
      MeasureCross(scan, cross, pixel_from_mm, mark->position->pixel, polarity, max_shift_px);
  if (!crossing) return;
  mark->clear = IsClear(*crossing);
  mark->position = PositionByLines(mark->position.value(), *crossing);
}

// Where the reading has the marks; those without a candidate have no place.
std::vector<MeasuringPlace> PlacesToMeasure(const CameraFile& camera, const MarkShapes& shapes,
                                            const FilmReading& reading) {
  const Matrix2d pixel_from_mm = PixelFromMm(camera, reading);
  std::vector<MeasuringPlace> places(camera.fiducials.size());
  for (size_t i = 0; i < places.size(); ++i)
    if (const int choice = reading.best.choice[i]; choice >= 0)
      places[i] = {&shapes.at(camera.fiducials[i].mark), pixel_from_mm,
                   reading.candidates[i][choice].pixel, reading.polarity};
  return places;
}

FilmMark MeasureAt(const Raster& scan, const MeasuringPlace& place, const MarkMeasurer& measurer,
                   std::optional<LocatorKind> wanted) {
  const double max_shift_px = 0.25 * std::sqrt(std::abs(place.pixel_from_mm.determinant())) + 1;
  FilmMark mark;
  mark.position = measurer.Measure(scan, place.start, place.polarity, max_shift_px);
  if (!mark.position) return mark;
  mark.state = MarkState::kUsed;
  if (MeasuredByLines(*place.shape, wanted))
    MeasureByLines(scan, *CrossOf(*place.shape), place.pixel_from_mm, place.polarity, max_shift_px,
                   &mark);
  return mark;
}

// A faint mark: what keeps it from correlating is mostly grain, and its gain is far above grain's.
// Right ones have sigmas up to 0.25 px, clutter that resembles them mostly above 0.4 px.
bool IsFaint(const MarkPosition& mark) {
  constexpr double kMostSigma_px = 0.3, kFarAbove = 2.5;
  return mark.correlation_without_grain >= kLeastWithoutGrain &&
         mark.gain_over_sigma >= kHighestGainOfGrain + kFarAbove &&
         std::sqrt(mark.covariance.diagonal().maxCoeff()) <= kMostSigma_px;
}

// Whether the places of the candidates alone leave no doubt that they are the marks.
bool IsBeyondDoubt(const FilmReading& reading) {
  constexpr double kFurtherNats = 3;
  return reading.best.nats >= MinSetNats(static_cast<int>(reading.marks.size())) + kFurtherNats &&
         std::min(reading.margin, reading.scanner_margin) >= kMinMarginNats + kFurtherNats;
}

// Whether all of the camera's marks are used, at least four: clutter that resembles a faint mark is
// too rare for that.
bool AreAllUsed(const FilmMarks& marks) {
  constexpr int kLeastMarks = 4;
  const int used = Count(marks, MarkState::kUsed);
  return used >= kLeastMarks && used == static_cast<int>(marks.size());
}

// `by_strokes`: marks with clear strokes are taken whatever their correlation. `faint`: for marks
// that only grain keeps from correlating, only the others' correlation sets the limit.
void RejectUnlike(bool by_strokes, bool faint, FilmMarks* marks) {
  std::vector<double> correlations;
  for (const FilmMark& mark : *marks)
    if (mark.state == MarkState::kUsed) correlations.push_back(mark.position->correlation);
  if (correlations.empty()) return;
  const double median = UpperMedian(std::move(correlations));
  for (FilmMark& mark : *marks) {
    if (mark.state != MarkState::kUsed || (by_strokes && mark.clear)) continue;
    const double least = faint && IsFaint(*mark.position) ? 0 : kMinCorrelation;
    if (mark.position->correlation < std::max(least, kMinOfMedianCorrelation * median))
      mark.state = MarkState::kRejected;
  }
}

// The measured positions in place of the candidates: one per mark, with the density of clutter
// unchanged.
struct Measured {
  std::vector<AssignmentMark> marks;
  std::vector<int> choice;
};

Measured AsAssignment(const FilmReading& reading, const FilmMarks& marks) {
  Measured result{reading.marks, std::vector<int>(marks.size(), -1)};
  for (size_t i = 0; i < marks.size(); ++i) {
    // An exact click may be where the reading has no candidate.
    if (marks[i].state != MarkState::kUsed || reading.best.choice[i] < 0) continue;
    result.choice[i] = reading.best.choice[i];
    result.marks[i].candidates[result.choice[i]].position_mm =
        (marks[i].position->pixel - reading.middle_px) * reading.pixel_size.pixel_mm;
  }
  return result;
}

void RejectContradicted(const FilmReading& reading, FilmMarks* marks) {
  const Measured measured = AsAssignment(reading, *marks);
  const std::vector<int> kept = WithoutContradicted(measured.marks, reading.prior, measured.choice);
  for (size_t i = 0; i < marks->size(); ++i)
    if (measured.choice[i] >= 0 && kept[i] < 0) (*marks)[i].state = MarkState::kRejected;
}

// The marks that RejectUnlike rejected and that the others confirm. A cross in the picture's
// texture, or with a stroke of about a pixel, correlates little with its drawing wherever it is; a
// wrong place this close to where at least three others predict it is rare by chance, and not a
// gross error.
void TakeBackConfirmed(const FilmReading& reading, const FilmMarks& measured, FilmMarks* marks) {
  constexpr int kLeastOthers = 3;
  constexpr double kLeastCorrelation = 0.25, kMostSigma_px = 0.4;
  static const double kConfirmed = ChiSquareLimit(2, 0.1);
  if (Count(*marks, MarkState::kUsed) < kLeastOthers) return;
  const Measured kept = AsAssignment(reading, *marks), all = AsAssignment(reading, measured);
  std::vector<int> choice = kept.choice;
  for (size_t i = 0; i < marks->size(); ++i) {
    const FilmMark& mark = measured[i];
    if (kept.choice[i] >= 0 || all.choice[i] < 0) continue;
    const double sigma_mm =
        reading.pixel_size.pixel_mm * std::sqrt(mark.position->covariance.diagonal().maxCoeff());
    if (mark.position->correlation < kLeastCorrelation || sigma_mm > reading.prior.point_mm ||
        sigma_mm > kMostSigma_px * reading.pixel_size.pixel_mm)
      continue;
    std::vector<int> with = choice;
    with[i] = all.choice[i];
    if (LeaveOneOutChiSquare(all.marks, reading.prior, with, static_cast<int>(i)) > kConfirmed ||
        WithoutContradicted(all.marks, reading.prior, with) != with)
      continue;
    choice = with;
    (*marks)[i].state = MarkState::kUsed;
  }
}

}  // namespace

int Count(const FilmMarks& marks, MarkState state) {
  return static_cast<int>(std::count_if(marks.begin(), marks.end(),
                                        [&](const FilmMark& m) { return m.state == state; }));
}

FilmMarks MeasureMarks(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                       const FilmReading& reading, std::optional<LocatorKind> wanted,
                       MeasuredPlaces* known) {
  FilmMarks marks(camera.fiducials.size());
  const std::vector<MeasuringPlace> places = PlacesToMeasure(camera, shapes, reading);
  std::vector<size_t> fresh;
  std::map<const MarkShape*, MarkMeasurer> measurers;  // a drawing is rendered once for its marks
  for (size_t i = 0; i < marks.size(); ++i) {
    if (reading.best.choice[i] < 0) continue;
    if (const FilmMark* measured = known->Find(places[i])) {
      marks[i] = *measured;
      continue;
    }
    fresh.push_back(i);
    measurers.try_emplace(places[i].shape, *places[i].shape, places[i].pixel_from_mm);
  }
  SideBySide(fresh.size(), [&](size_t k) {
    const MeasuringPlace& place = places[fresh[k]];
    marks[fresh[k]] = MeasureAt(scan, place, measurers.at(place.shape), wanted);
  });
  for (const size_t i : fresh) known->Add(places[i], marks[i]);
  return WithoutWrongMarks(reading, marks);
}

MarkPosition PositionByLines(const MarkPosition& matched, const MeasuredCross& crossing) {
  const Vector2d difference = crossing.pixel - matched.pixel;
  const Matrix2d both = crossing.covariance + matched.covariance;
  MarkPosition position = matched;
  position.pixel = crossing.pixel;
  position.covariance = crossing.covariance;
  position.correlation_without_grain = 0;  // of another place: clear strokes count instead
  if (difference.dot(both.inverse() * difference) > kLeaveOneOutChiSquare)
    position.covariance += difference * difference.transpose();
  return position;
}

FilmMarks WithoutWrongMarks(const FilmReading& reading, const FilmMarks& measured) {
  const auto judged = [&](bool by_strokes) {
    const auto left = [&](bool faint) {
      FilmMarks marks = measured;
      RejectUnlike(by_strokes, faint, &marks);
      RejectContradicted(reading, &marks);
      return marks;
    };
    FilmMarks marks = left(true);
    if (AreAllUsed(marks) || IsBeyondDoubt(reading)) return marks;
    return left(false);
  };
  // Without enough neighbours there is no reseau, and no check as sharp; marks that clear
  // strokes in the picture contradicted are then judged again.
  if (Count(measured, MarkState::kUsed) >= kLeastReseauMarks) {
    FilmMarks marks = judged(true);
    if (Count(marks, MarkState::kUsed) >= kLeastReseauMarks) return marks;
  }
  FilmMarks marks = judged(false);
  TakeBackConfirmed(reading, measured, &marks);
  return marks;
}

void TakeExactClicks(const CameraFile& camera, const FilmReading& reading,
                     const std::vector<MarkClick>& clicks, FilmMarks* marks) {
  for (size_t i = 0; i < marks->size(); ++i) {
    const MarkClick* click = ClickOn(clicks, camera.fiducials[i].id);
    if (!click || !click->exact) continue;
    const int choice = reading.best.choice[i];
    const bool chosen = choice >= 0 && reading.candidates[i][choice].pixel == click->pixel;
    FilmMark& mark = (*marks)[i];
    mark.state = chosen ? MarkState::kUsed : MarkState::kRejected;
    mark.position =
        MarkPosition{.pixel = click->pixel,
                     .covariance = click->sigma_px * click->sigma_px * Matrix2d::Identity()};
  }
  RejectContradicted(reading, marks);
}

std::vector<size_t> SuspectMarks(const FilmReading& reading, const FilmMarks& marks) {
  if (Count(marks, MarkState::kUsed) >= kLeastReseauMarks) return {};
  FilmMarks with_rejected = marks;
  for (FilmMark& mark : with_rejected)
    if (mark.state == MarkState::kRejected && mark.position) mark.state = MarkState::kUsed;
  const Measured all = AsAssignment(reading, with_rejected);
  const std::vector<int> used = AsAssignment(reading, marks).choice;
  std::set<size_t> perhaps;
  for (size_t rejected = 0; rejected < marks.size(); ++rejected) {
    if (used[rejected] >= 0 || all.choice[rejected] < 0) continue;
    for (size_t i = 0; i < marks.size(); ++i) {
      if (used[i] < 0) continue;
      std::vector<int> instead = used;
      instead[rejected] = all.choice[rejected];
      instead[i] = -1;
      if (WithoutContradicted(all.marks, reading.prior, instead) == instead) perhaps.insert(i);
    }
  }
  return {perhaps.begin(), perhaps.end()};
}

std::vector<MeasuredMark> UsedMarks(const CameraFile& camera, const FilmMarks& marks) {
  std::vector<MeasuredMark> used;
  for (size_t i = 0; i < marks.size(); ++i)
    if (marks[i].state == MarkState::kUsed)
      used.push_back({marks[i].position->pixel, camera.fiducials[i].position_mm});
  return used;
}

}  // namespace orient::interior

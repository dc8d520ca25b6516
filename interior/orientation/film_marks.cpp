#include "interior/acceptance.h"

#include <Eigen/LU>

#include "core/format_text.h"
#include "core/imaging/side_by_side.h"
#include "core/median.h"
#include "interior/film_orientation.h"
#include "interior/lines_locator.h"
#include "interior/measured_places.h"
#include "interior/reseau.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kMinMarginNats = 3.0;
// That the camera's marks are there at all must be far likelier than a set of clutter that happens
// to fit: photos without marks reach 6 nats (tests, random texture).
constexpr double kMinSetNats = 9.0;
// A set's nats are odds against clutter that the assignment's model holds for unlikely, as each
// mark is found with a probability of 0.85: -log 0.15 = 1.9 for every mark, found or not. A camera
// without its marks on the scan is no such coincidence, and against it a set's odds are less by 1.9
// nats a mark: nine nats of four marks are 1.4 above it, and so much is asked of any number.
constexpr double kNatsPerFurtherMark = 1.9;
constexpr double kMinCorrelation = 0.45;
constexpr double kMinOfMedianCorrelation = 0.6;
constexpr double kMaxScaleDifference = 0.03;
constexpr double kMaxShear = 0.015;
// Resolution tags and users are right within a percent, film and prints keep their size as well;
// like marks of another camera lie 2 % farther out or in.
constexpr double kMaxOffStatedSize = 0.015;
constexpr double kStatedSigma = 0.01;             // a larger one: the pixel size was not stated
constexpr double kMaxSigma0Photogrammetric = 60;  // um
constexpr double kMaxSigma0Desktop = 350;         // um
constexpr double kNotableSigma0 = 30;             // um: said, though accepted

int Count(const FilmMarks& marks, MarkState state) {
  return static_cast<int>(std::count_if(marks.begin(), marks.end(),
                                        [&](const FilmMark& m) { return m.state == state; }));
}

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

// A cross and nothing else, in the picture itself: there the two sides of a stroke are mostly
// unlike, and least-squares matching, which knows of no sides, is pulled to the brighter one: on
// simulated P31 scans its errors are half as large again as those of the lines (docs/interior.md
// has the figures). On a dark corner it sees more of the mark than its lines do.
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

// `by_strokes`: marks with clear strokes are taken whatever their correlation.
void RejectUnlike(bool by_strokes, FilmMarks* marks) {
  std::vector<double> correlations;
  for (const FilmMark& mark : *marks)
    if (mark.state == MarkState::kUsed) correlations.push_back(mark.position->correlation);
  if (correlations.empty()) return;
  const double median = UpperMedian(std::move(correlations));
  for (FilmMark& mark : *marks)
    if (mark.state == MarkState::kUsed && !(by_strokes && mark.clear) &&
        mark.position->correlation < std::max(kMinCorrelation, kMinOfMedianCorrelation * median))
      mark.state = MarkState::kRejected;
}

// The measured positions in place of the candidates: one candidate a mark, the clutter's density
// as it was.
struct Measured {
  std::vector<AssignmentMark> marks;
  std::vector<int> choice;
};

Measured AsAssignment(const Vector2d& scan_middle, const FilmReading& reading,
                      const FilmMarks& marks) {
  Measured result{reading.marks, std::vector<int>(marks.size(), -1)};
  for (size_t i = 0; i < marks.size(); ++i) {
    if (marks[i].state != MarkState::kUsed) continue;
    result.choice[i] = reading.best.choice[i];
    result.marks[i].candidates[result.choice[i]].position_mm =
        (marks[i].position->pixel - scan_middle) * reading.pixel_size.pixel_mm;
  }
  return result;
}

void RejectContradicted(const Vector2d& scan_middle, const FilmReading& reading, FilmMarks* marks) {
  const Measured measured = AsAssignment(scan_middle, reading, *marks);
  const std::vector<int> kept = WithoutContradicted(measured.marks, reading.prior, measured.choice);
  for (size_t i = 0; i < marks->size(); ++i)
    if (measured.choice[i] >= 0 && kept[i] < 0) (*marks)[i].state = MarkState::kRejected;
}

void JudgeFilm(const FilmReading& reading, const FilmTransform& film, Verdict* verdict) {
  const auto weak = [&](std::string why) {
    if (verdict->status == Status::kOk) verdict->status = Status::kWeak;
    verdict->messages.push_back(std::move(why));
  };
  if (std::abs(film.shape.scale_difference) > kMaxScaleDifference)
    weak(
        FormatText("The scales of the two axes differ by %.1f %%: not a plausible film or scanner.",
                   100 * film.shape.scale_difference));
  if (std::abs(film.shape.shear_rad) > kMaxShear)
    weak(FormatText("The axes are sheared by %.1f mrad: not a plausible film or scanner.",
                    1e3 * film.shape.shear_rad));
  const double off = film.pixel_um / (1e3 * reading.pixel_size.pixel_mm) - 1;
  if (reading.pixel_size.sigma < kStatedSigma && std::abs(off) > kMaxOffStatedSize)
    weak(FormatText(
        "The marks say that a pixel has %.2f um, the resolution tag or the stated size says "
        "%.2f um: another camera's marks, or a wrong resolution.",
        film.pixel_um, 1e3 * reading.pixel_size.pixel_mm));
  if (reading.scanner_margin <= kMinMarginNats)
    weak(FormatText(
        "A desktop scan of all these marks, and a photogrammetric one with a mark misplaced, "
        "are nearly as probable (%.1f nats apart): say which it is with --scanner.",
        reading.scanner_margin));
  if (reading.orientation_margin < kSureNats)
    weak(FormatText(
        "The film lying otherwise is nearly as probable (%.1f nats apart, %.0f are needed): "
        "give --orientation.",
        reading.orientation_margin, kSureNats));
  const double limit =
      reading.scanner == Scanner::kPhotogrammetric ? kMaxSigma0Photogrammetric : kMaxSigma0Desktop;
  if (film.sigma0_um > limit)
    weak(FormatText("sigma0 of %.0f um is more than film deformation explains.", film.sigma0_um));
  else if (film.affine && film.sigma0_um > kNotableSigma0)
    verdict->messages.push_back(
        FormatText("The scanner or print distorts the film: an affine leaves sigma0 = %.0f um.",
                   film.sigma0_um));
}

// What the used marks alone earn: marks that were rejected bear no witness.
double NatsOfUsed(const FilmReading& reading, const FilmMarks& marks) {
  std::vector<int> used(marks.size(), -1);
  for (size_t i = 0; i < marks.size(); ++i)
    if (marks[i].state == MarkState::kUsed) used[i] = reading.best.choice[i];
  return std::min(reading.best.nats, NatsOfSet(reading.marks, reading.prior, used));
}

// Empty where nothing speaks against the set of marks. `nats`: NatsOfUsed.
std::string WhyNotThere(const FilmReading& reading, int used, double nats) {
  if (reading.best.Matched() < 3 || used < 3)
    return "The camera's marks were not found: wrong camera file, marks outside the scan, or a "
           "wrong pixel size (--pixel-size-um; in a block file pixel_size_um under [scan]).";
  const int all = static_cast<int>(reading.marks.size());
  if (nats < MinSetNats(all))
    return FormatText(
        "What was found may be chance (%.1f nats for the marks, %.1f are needed): wrong "
        "camera file or marks too faint.",
        nats, MinSetNats(all));
  if (!reading.proven)
    return "Too many marks and places for them to be sure that no other reading is as good: give "
           "orientation, polarity or pixel size, whichever is known (options; in a block file "
           "[scan]).";
  if (reading.margin <= kMinMarginNats)
    return FormatText(
        "Another reading of the marks is nearly as probable (margin %.1f nats, 3 are "
        "needed).",
        reading.margin);
  return "";
}

}  // namespace

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
  if (difference.dot(both.inverse() * difference) > kLeaveOneOutChiSquare)
    position.covariance += difference * difference.transpose();
  return position;
}

FilmMarks WithoutWrongMarks(const FilmReading& reading, const FilmMarks& measured) {
  const auto judged = [&](bool by_strokes) {
    FilmMarks marks = measured;
    RejectUnlike(by_strokes, &marks);
    RejectContradicted(reading.middle_px, reading, &marks);
    return marks;
  };
  // Without neighbours enough there is no reseau, and nothing that tells so sharply; whom clear
  // strokes in the picture contradicted is judged anew then.
  if (Count(measured, MarkState::kUsed) >= kLeastReseauMarks) {
    FilmMarks marks = judged(true);
    if (Count(marks, MarkState::kUsed) >= kLeastReseauMarks) return marks;
  }
  return judged(false);
}

std::vector<MeasuredMark> UsedMarks(const CameraFile& camera, const FilmMarks& marks) {
  std::vector<MeasuredMark> used;
  for (size_t i = 0; i < marks.size(); ++i)
    if (marks[i].state == MarkState::kUsed)
      used.push_back({marks[i].position->pixel, camera.fiducials[i].position_mm});
  return used;
}

void SayPixelSizeIsUnsure(InteriorResult* result) {
  if (result->status == Status::kOk) result->status = Status::kWeak;
  result->messages.push_back(FormatText(
      "The pixel size (%.2f um) follows from the camera alone: a smaller or larger camera with "
      "like marks would fit as well; give it (--pixel-size-um; in a block file pixel_size_um under "
      "[scan]).",
      result->pixel_size_um.value_or(0)));
}

void JudgePixelSize(const FilmReading& reading, InteriorResult* result) {
  if (result->pixel_size_um && reading.pixel_size.sigma >= kStatedSigma)
    SayPixelSizeIsUnsure(result);
}

double MinSetNats(int all) { return kMinSetNats + kNatsPerFurtherMark * std::max(all - 4, 0); }

int NeededMarks(int all) { return std::max(4, static_cast<int>(std::ceil(0.6 * all))); }

Status JudgeSet(int all, int used, double set_nats, double margin) {
  if (used < 3 || set_nats < MinSetNats(all) || margin <= kMinMarginNats) return Status::kFailed;
  return used < NeededMarks(all) ? Status::kWeak : Status::kOk;
}

Verdict Judge(const FilmReading& reading, const FilmMarks& marks,
              const std::optional<FilmTransform>& film) {
  const int all = static_cast<int>(marks.size());
  const int used = Count(marks, MarkState::kUsed);
  Verdict verdict;
  const double nats = NatsOfUsed(reading, marks);
  const std::string why = WhyNotThere(reading, used, nats);
  if (!why.empty() || !film) {
    verdict.messages.push_back(!why.empty() ? why : "The marks found lie on one line.");
    return verdict;
  }
  verdict.status = JudgeSet(all, used, nats, reading.margin);
  if (verdict.status == Status::kWeak)
    verdict.messages.push_back(
        FormatText("Only %d marks were found, %d are needed to be sure.", used, NeededMarks(all)));
  JudgeFilm(reading, *film, &verdict);
  return verdict;
}

}  // namespace orient

#include "interior/constellation/clicked_film.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "core/base/error.h"
#include "core/base/side_by_side.h"
#include "interior/constellation/film_search.h"
#include "interior/constellation/rival_readings.h"
#include "interior/locators/locator.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

// Score, nats, of a click where no locator finds a mark; exact clicks are not penalised.
constexpr double kUnlikeNats = -1.5;
// Windows around predicted places, and their growth with the distance from a click: for film and
// scanner alone, and with an unknown rotation of the film.
constexpr double kWindowHalf_mm = 1.5;
constexpr double kBySeveral = 0.025, kByOne = 0.06;
// Clicks closer together hardly determine scale and rotation.
constexpr double kLeastBase_mm = 20;
// Tolerances of the pixel size against a stated one, and against a ladder of guesses.
constexpr double kOffStated = 0.05, kOffLadder = 0.2;

struct Clicked {
  Vector2d place_mm, pixel;
};

// The film lying in one scan orientation, as some of the clicks show it.
struct Hypothesis {
  ScanOrientation orientation;
  Affine2d pixel_from_photo;  // a similarity
  std::vector<Clicked> by;    // the clicks that it explains
  double misfit = 0;          // of these, pixels squared
};

std::vector<Clicked> PlacesOf(const CameraFile& camera, const std::vector<MarkClick>& clicks) {
  std::vector<Clicked> clicked;
  for (const MarkClick& click : clicks) {
    const auto mark = std::find_if(camera.fiducials.begin(), camera.fiducials.end(),
                                   [&](const Fiducial& f) { return f.id == click.mark; });
    if (mark == camera.fiducials.end())
      throw InputError("mark " + click.mark + " was clicked, but camera \"" + camera.camera.name +
                       "\" has no mark of this name; take the ids of its [[fiducials]]");
    clicked.push_back({mark->position_mm, click.pixel});
  }
  return clicked;
}

double NearestBy(const Hypothesis& hypothesis, const Vector2d& place_mm) {
  double least = std::numeric_limits<double>::infinity();
  for (const Clicked& one : hypothesis.by)
    least = std::min(least, (one.place_mm - place_mm).norm());
  return least;
}

double PixelsPerMm(const Hypothesis& hypothesis) {
  return std::sqrt(std::abs(hypothesis.pixel_from_photo.A.determinant()));
}

double HalfWindow_mm(const Hypothesis& hypothesis, const Vector2d& place_mm) {
  const double grow = hypothesis.by.size() > 1 ? kBySeveral : kByOne;
  return kWindowHalf_mm + grow * NearestBy(hypothesis, place_mm);
}

// All hypotheses that one click, or two, allow.
class Hypotheses {
 public:
  Hypotheses(std::vector<Clicked> clicked, std::vector<PixelSizeGuess> guesses)
      : clicked_(std::move(clicked)), guesses_(std::move(guesses)) {}

  // The hypothesis that explains the most clicks, and these best; empty if none is plausible.
  std::optional<Hypothesis> BestIn(ScanOrientation orientation) const {
    std::optional<Hypothesis> best;
    const auto keep = [&](const Affine2d& pixel_from_photo, const Clicked& a, const Clicked& b) {
      Hypothesis one{orientation, pixel_from_photo, {a, b}};
      Explain(&one);
      if (!best || one.by.size() > best->by.size() ||
          (one.by.size() == best->by.size() && one.misfit < best->misfit))
        best = std::move(one);
    };
    for (std::size_t i = 0; i < clicked_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (const auto found = Through(clicked_[i], clicked_[j], orientation))
          keep(*found, clicked_[i], clicked_[j]);
    if (!best && clicked_.size() == 1 && guesses_.size() == 1)
      keep(At(clicked_[0], orientation), clicked_[0], clicked_[0]);
    return best;
  }

 private:
  std::optional<Affine2d> Through(const Clicked& a, const Clicked& b,
                                  ScanOrientation orientation) const {
    if ((a.place_mm - b.place_mm).norm() < kLeastBase_mm || (a.pixel - b.pixel).norm() < 1)
      return std::nullopt;
    const auto fit =
        FitSimilarity({{a.place_mm, a.pixel}, {b.place_mm, b.pixel}}, !IsMirrored(orientation));
    if (!fit || !fit->transform.IsInvertible()) return std::nullopt;
    if (NearestScanOrientation(fit->transform.Inverse()) != orientation) return std::nullopt;
    const double pixel_mm = 1 / std::sqrt(std::abs(fit->transform.A.determinant()));
    const double off = guesses_.size() == 1 ? kOffStated : kOffLadder;
    const bool plausible = std::any_of(
        guesses_.begin(), guesses_.end(),
        [&](const PixelSizeGuess& guess) { return std::abs(pixel_mm / guess.pixel_mm - 1) < off; });
    return plausible ? std::optional(fit->transform) : std::nullopt;
  }

  Affine2d At(const Clicked& click, ScanOrientation orientation) const {
    const Eigen::Matrix2d A =
        PhotoFromPixelAxes(orientation).transpose() / guesses_.front().pixel_mm;
    return {A, click.pixel - A * click.place_mm};
  }

  // Sets the clicks that agree, and the similarity through all of these.
  void Explain(Hypothesis* one) const {
    Hypothesis seen = *one;
    seen.by.clear();
    for (const Clicked& click : clicked_) {
      const double off_px = (one->pixel_from_photo * click.place_mm - click.pixel).norm();
      const double reach_px = HalfWindow_mm(*one, click.place_mm) * PixelsPerMm(*one);
      if (off_px > reach_px) continue;
      seen.by.push_back(click);
      seen.misfit += off_px * off_px;
    }
    if (seen.by.size() > 2) {
      std::vector<PointPair2d> pairs;
      for (const Clicked& click : seen.by) pairs.push_back({click.place_mm, click.pixel});
      if (const auto fit = FitSimilarity(pairs, !IsMirrored(one->orientation)))
        seen.pixel_from_photo = fit->transform;
    }
    *one = std::move(seen);
  }

  std::vector<Clicked> clicked_;
  std::vector<PixelSizeGuess> guesses_;
};

// Looks for all marks where a hypothesis predicts them.
class ClickedFilm {
 public:
  ClickedFilm(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
              const InteriorOptions& options, const std::vector<PixelSizeGuess>& guesses)
      : windows_(scan), camera_(camera), shapes_(shapes), options_(options), guesses_(guesses) {
    for (const LocatorKind kind : {LocatorKind::kHough, LocatorKind::kNcc, LocatorKind::kLines})
      locators_[kind] = MakeLocator(kind);
  }

  // `excluded`: those in the polarity that the user excluded.
  void AddReadings(const Hypothesis& hypothesis, std::vector<FilmReading>* readings,
                   std::vector<FilmReading>* excluded) {
    std::vector<MarkCandidates> found(camera_.fiducials.size());
    SideBySide(found.size(),
               [&](std::size_t i) { found[i] = Find(hypothesis, camera_.fiducials[i]); });
    for (const Polarity polarity : {Polarity::kPositive, Polarity::kNegative}) {
      const bool wanted = options_.polarity.value_or(polarity) == polarity;
      for (const Scanner scanner : {Scanner::kPhotogrammetric, Scanner::kDesktop})
        if (options_.scanner.value_or(scanner) == scanner)
          (wanted ? readings : excluded)->push_back(ReadAs(hypothesis, found, polarity, scanner));
    }
  }

 private:
  MarkCandidates Find(const Hypothesis& hypothesis, const Fiducial& mark) {
    const Vector2d at = hypothesis.pixel_from_photo * mark.position_mm;
    const MarkShape& shape = shapes_.at(mark.mark);
    const int half = static_cast<int>(
        std::ceil(HalfWindow_mm(hypothesis, mark.position_mm) * PixelsPerMm(hypothesis)));
    MarkSearch search;
    search.window = {static_cast<int>(std::floor(at.x())) - half,
                     static_cast<int>(std::floor(at.y())) - half, 2 * half + 1, 2 * half + 1};
    search.pixel_from_mm = hypothesis.pixel_from_photo.A;
    if (hypothesis.by.size() > 1) search.turns_rad = {0};
    return locators_.at(LocatorFor(shape, options_.locator))->Find(windows_, shape, search);
  }

  // Adds the click to the locator's candidates: it makes a candidate close to it more probable,
  // otherwise it is a further candidate. Candidates are weighed against clutter, whose density is
  // that of the window; a wrong click could lie anywhere on the scan.
  void AddClick(const MarkClick& click, const FilmReading& reading, double scan_mm2,
                std::vector<MarkCandidate>* candidates, AssignmentMark* mark) const {
    std::size_t nearest = candidates->size();
    double least_px = ClickReach_px(click);
    for (std::size_t j = 0; j < candidates->size() && !click.exact; ++j) {
      const double off_px = ((*candidates)[j].pixel - click.pixel).norm();
      if (off_px > least_px) continue;
      least_px = off_px;
      nearest = j;
    }
    if (nearest == candidates->size()) {
      candidates->push_back({click.pixel, 0});
      mark->candidates.push_back(
          {Position_mm(reading, click.pixel), click.exact ? 0 : kUnlikeNats});
    }
    mark->candidates[nearest].click_nats =
        std::log(static_cast<double>(candidates->size()) * scan_mm2 / mark->window_mm2);
  }

  static Vector2d Position_mm(const FilmReading& reading, const Vector2d& pixel) {
    return (pixel - reading.middle_px) * reading.pixel_size.pixel_mm;
  }

  FilmReading ReadAs(const Hypothesis& hypothesis, const std::vector<MarkCandidates>& found,
                     Polarity polarity, Scanner scanner) const {
    FilmReading reading;
    const double seen_mm = 1 / PixelsPerMm(hypothesis);
    constexpr double kUnstatedSigma = 0.025;
    reading.pixel_size =
        guesses_.size() == 1 ? guesses_.front() : PixelSizeGuess{seen_mm, kUnstatedSigma};
    reading.orientations = {hypothesis.orientation};
    reading.polarity = polarity;
    reading.scanner = scanner;
    const MarkRectangle rectangle = RectangleOfMarks(camera_.fiducials);
    const Vector2d scan_px(windows_.Scan().Width(), windows_.Scan().Height());
    const Vector2d scan_mm = scan_px * reading.pixel_size.pixel_mm;
    reading.middle_px = 0.5 * scan_px;
    const Eigen::Matrix2d axes = PhotoFromPixelAxes(hypothesis.orientation).transpose();
    reading.free_mm = 0.5 * (scan_mm - (axes * rectangle.size_mm).cwiseAbs()).cwiseAbs();
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Fiducial& fiducial = camera_.fiducials[i];
      auto candidates = polarity == Polarity::kPositive ? found[i].bright : found[i].dark;
      const std::vector<double> nats = ScoreNats(candidates);
      AssignmentMark mark;
      mark.place_mm = PlaceOnScan(fiducial.position_mm, rectangle, hypothesis.orientation);
      mark.window_mm2 = std::max(found[i].searched_mm2, 1.0);
      for (std::size_t j = 0; j < candidates.size(); ++j)
        mark.candidates.push_back({Position_mm(reading, candidates[j].pixel), nats[j]});
      if (const MarkClick* click = ClickOn(options_.clicks, fiducial.id))
        AddClick(*click, reading, scan_mm.prod(), &candidates, &mark);
      reading.coarse_pixel_mm = std::max(reading.coarse_pixel_mm, found[i].coarse_pixel_mm);
      reading.marks.push_back(std::move(mark));
      reading.candidates.push_back(std::move(candidates));
    }
    reading.prior = PriorIn(reading, scanner, {});
    AssignAll(&reading);
    return reading;
  }

  // The exact search is for fiducial marks; the many crosses of a reseau are chosen around the
  // clicks.
  void AssignAll(FilmReading* reading) const {
    if (std::ssize(reading->marks) < kLeastReseauMarks) {
      Assign(reading);
      return;
    }
    std::vector<int> trusted(reading->marks.size(), -1);
    for (std::size_t i = 0; i < trusted.size(); ++i)
      if (const MarkClick* click = ClickOn(options_.clicks, camera_.fiducials[i].id))
        for (std::size_t j = 0; j < reading->candidates[i].size(); ++j)
          if ((reading->candidates[i][j].pixel - click->pixel).norm() <= ClickReach_px(*click))
            trusted[i] = static_cast<int>(j);
    reading->best.choice = ChooseAround(reading->marks, reading->prior, trusted);
    reading->best.nats = NatsOfSet(reading->marks, reading->prior, reading->best.choice);
    reading->margin = reading->best.nats;
  }

  ScanWindows windows_;
  const CameraFile& camera_;
  const MarkShapes& shapes_;
  const InteriorOptions& options_;
  const std::vector<PixelSizeGuess>& guesses_;
  std::map<LocatorKind, std::unique_ptr<Locator>> locators_;
};

}  // namespace

double ClickReach_px(const MarkClick& click) {
  constexpr double kLeast_px = 4, kSigmas = 4;
  return std::max(kLeast_px, kSigmas * click.sigma_px);
}

const MarkClick* ClickOn(const std::vector<MarkClick>& clicks, const std::string& mark) {
  const auto found = std::find_if(clicks.begin(), clicks.end(),
                                  [&](const MarkClick& click) { return click.mark == mark; });
  return found == clicks.end() ? nullptr : &*found;
}

std::optional<FilmReading> ReadFilmByClicks(const Raster& scan, const CameraFile& camera,
                                            const MarkShapes& shapes,
                                            const InteriorOptions& options) {
  const std::vector<PixelSizeGuess> guesses =
      GuessPixelSize({scan.Width(), scan.Height()}, scan.DpiTag(),
                     RectangleOfMarks(camera.fiducials), options.pixel_size_um);
  const Hypotheses hypotheses(PlacesOf(camera, options.clicks), guesses);
  ClickedFilm film(scan, camera, shapes, options, guesses);
  std::vector<FilmReading> readings, excluded;
  for (const ScanOrientation orientation : kAllScanOrientations) {
    const bool stated = options.orientation == orientation;
    if (!stated && (options.orientation || IsMirrored(orientation))) continue;
    if (const auto hypothesis = hypotheses.BestIn(orientation))
      film.AddReadings(*hypothesis, &readings, &excluded);
  }
  if (readings.empty()) return std::nullopt;
  return BestOf(readings, excluded);
}

}  // namespace orient::interior

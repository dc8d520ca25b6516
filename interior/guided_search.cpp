#include "interior/guided_search.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kWindowHalf_mm = 1.5;
constexpr int kLeastAnchors = 4;
// Film between the anchors bends by some hundredths of a millimetre.
constexpr double kBend_mm = 0.05;
// A candidate 1 mm from its prediction must look this much better than one on it.
constexpr double kNccPerSquareMm = 0.2;

class GuidedSearch {
 public:
  GuidedSearch(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
               std::vector<size_t> anchors, FilmReading reading, std::optional<LocatorKind> locator)
      : windows_(scan),
        camera_(camera),
        shapes_(shapes),
        locator_(locator),
        anchors_(std::move(anchors)),
        reading_(std::move(reading)) {
    for (const LocatorKind kind : {LocatorKind::kHough, LocatorKind::kNcc, LocatorKind::kLines})
      locators_[kind] = MakeLocator(kind);
  }

  // All marks, were the film lying in the first of these orientations.
  FilmReading Expand(const OrientationClass& orientations) {
    FilmReading full = reading_;
    full.orientations = orientations;
    full.bend_mm = kBend_mm;
    full.prior = PriorIn(full, full.scanner, DepartureOf(camera_.fiducials, orientations));
    const size_t count = camera_.fiducials.size();
    const MarkRectangle rectangle = RectangleOfMarks(camera_.fiducials);
    full.marks.assign(count, {});
    full.candidates.assign(count, {});
    full.best.choice.assign(count, -1);
    const auto pixel_from_photo = PixelFromPhoto(orientations.front());
    for (size_t i = 0; i < count; ++i) {
      full.marks[i].place_mm =
          PlaceOnScan(camera_.fiducials[i].position_mm, rectangle, orientations.front());
      if (pixel_from_photo) Search(i, *pixel_from_photo, &full);
    }
    full.best.choice = WithoutStrays(full.marks, full.prior, full.best.choice, anchors_);
    full.best.nats = NatsOfSet(full.marks, full.prior, full.best.choice);
    return full;
  }

 private:
  std::optional<Affine2d> PixelFromPhoto(ScanOrientation orientation) const {
    std::vector<Fiducial> anchors;
    for (const size_t i : anchors_) anchors.push_back(camera_.fiducials[i]);
    const auto relabel = Relabel(anchors, shapes_, reading_.orientations.front(), orientation);
    if (!relabel || reading_.best.Matched() < kLeastAnchors) return std::nullopt;
    std::vector<PointPair2d> pairs;
    for (size_t a = 0; a < anchors.size(); ++a) {
      const int choice = reading_.best.choice[a];
      if (choice >= 0)
        pairs.push_back({anchors[(*relabel)[a]].position_mm, reading_.candidates[a][choice].pixel});
    }
    const auto fit = FitAffine(pairs);
    if (!fit) return std::nullopt;
    return fit->transform;
  }

  void Search(size_t i, const Affine2d& pixel_from_photo, FilmReading* full) {
    const MarkShape& shape = shapes_.at(camera_.fiducials[i].mark);
    const Vector2d predicted = pixel_from_photo * camera_.fiducials[i].position_mm;
    const double p = full->pixel_size.pixel_mm;
    const int half = static_cast<int>(std::ceil(kWindowHalf_mm / p));
    MarkSearch search;
    search.window = {static_cast<int>(std::floor(predicted.x())) - half,
                     static_cast<int>(std::floor(predicted.y())) - half, 2 * half + 1,
                     2 * half + 1};
    search.pixel_from_mm = pixel_from_photo.A;
    search.turns_rad = {0};  // the anchors have told the turn
    const Locator& locator = *locators_.at(LocatorFor(shape, locator_));
    const MarkCandidates found = locator.Find(windows_, shape, search);
    const std::vector<MarkCandidate>& candidates =
        full->polarity == Polarity::kPositive ? found.bright : found.dark;
    const std::vector<double> nats = ScoreNats(candidates);
    AssignmentMark& mark = full->marks[i];
    mark.window_mm2 = std::max(found.searched_mm2, 1.0);
    double best = -std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < candidates.size(); ++j) {
      mark.candidates.push_back({(candidates[j].pixel - full->middle_px) * p, nats[j]});
      const double off_mm = (candidates[j].pixel - predicted).norm() * p;
      const double score = candidates[j].ncc - kNccPerSquareMm * off_mm * off_mm;
      if (off_mm > kWindowHalf_mm || score <= best) continue;
      best = score;
      full->best.choice[i] = static_cast<int>(j);
    }
    full->candidates[i] = candidates;
  }

  ScanWindows windows_;
  const CameraFile& camera_;
  const MarkShapes& shapes_;
  std::optional<LocatorKind> locator_;
  std::map<LocatorKind, std::unique_ptr<Locator>> locators_;
  std::vector<size_t> anchors_;
  FilmReading reading_;  // of the anchors alone
};

// The anchors allow several ways of lying, and the crosses between them decide. A class that
// another one comes near is no answer: the margin is that to the nearest one.
FilmReading MostProbable(std::vector<FilmReading> classes) {
  std::stable_sort(classes.begin(), classes.end(), [](const FilmReading& a, const FilmReading& b) {
    return a.best.nats > b.best.nats;
  });
  FilmReading best = classes.front();
  if (classes.size() < 2) return best;
  best.orientation_margin = best.best.nats - classes[1].best.nats;
  best.margin = std::min(best.margin, best.orientation_margin);
  return best;
}

// The whole camera's classes, as far as the anchors allow them; one that they allow comes first in
// each.
std::vector<OrientationClass> Classes(const CameraFile& camera, const MarkShapes& shapes,
                                      const FilmReading& anchors, const InteriorOptions& options) {
  if (options.orientation) return {{*options.orientation}};
  std::vector<OrientationClass> classes;
  for (OrientationClass orientations : OrientationClasses(camera.fiducials, shapes)) {
    const auto allowed =
        std::find_first_of(orientations.begin(), orientations.end(), anchors.orientations.begin(),
                           anchors.orientations.end());
    if (allowed == orientations.end()) continue;
    std::rotate(orientations.begin(), allowed, allowed + 1);
    classes.push_back(std::move(orientations));
  }
  return classes;
}

}  // namespace

std::vector<size_t> AnchorMarks(const std::vector<Fiducial>& fiducials) {
  constexpr int kDirections = 8;
  const Vector2d centre = RectangleOfMarks(fiducials).centre_mm;
  std::vector<size_t> anchors;
  for (int d = 0; d < kDirections; ++d) {
    const double angle = d * 2 * std::numbers::pi / kDirections;
    const Vector2d along(std::cos(angle), std::sin(angle)), across(-along.y(), along.x());
    size_t farthest = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (size_t i = 0; i < fiducials.size(); ++i) {
      const Vector2d at = fiducials[i].position_mm - centre;
      // Of a side's marks the one in its middle.
      const double reach = at.dot(along) - 0.01 * std::abs(at.dot(across));
      if (reach <= most) continue;
      most = reach;
      farthest = i;
    }
    if (std::find(anchors.begin(), anchors.end(), farthest) == anchors.end())
      anchors.push_back(farthest);
  }
  std::sort(anchors.begin(), anchors.end());
  return anchors;
}

FilmReading ReadFilmByAnchors(const Raster& scan, const CameraFile& camera,
                              const MarkShapes& shapes, const InteriorOptions& options) {
  const std::vector<size_t> anchors = AnchorMarks(camera.fiducials);
  CameraFile outer = camera;
  outer.fiducials.clear();
  for (const size_t i : anchors) outer.fiducials.push_back(camera.fiducials[i]);
  const FilmReading reading = ReadFilm(scan, outer, shapes, options);
  GuidedSearch search(scan, camera, shapes, anchors, reading, options.locator);
  std::vector<FilmReading> classes;
  for (const OrientationClass& orientations : Classes(camera, shapes, reading, options))
    classes.push_back(search.Expand(orientations));
  return classes.empty() ? search.Expand(reading.orientations) : MostProbable(std::move(classes));
}

}  // namespace orient

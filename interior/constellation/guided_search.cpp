#include "interior/constellation/guided_search.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>

#include "core/base/side_by_side.h"
#include "interior/constellation/film_search.h"
#include "interior/constellation/rival_readings.h"
#include "interior/locators/locator.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kWindowHalf_mm = 1.5;
constexpr int kLeastAnchors = 4;
// Film between the anchors bends by some hundredths of a millimetre.
constexpr double kBend_mm = 0.05;
// Positions of an anchor found in its small and in its large window agree within this.
constexpr double kSameCross_mm = 0.3;
// Positions in the layout that agree within this are the same.
constexpr double kSamePlace_mm = 0.5;

// Searches for all marks of the camera where one reading of the anchors predicts them.
class GuidedSearch {
 public:
  GuidedSearch(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
               const std::vector<size_t>& anchors, const FilmReading& reading,
               std::optional<LocatorKind> locator)
      : windows_(scan),
        camera_(camera),
        shapes_(shapes),
        locator_(locator),
        anchors_(anchors),
        reading_(reading) {
    for (const LocatorKind kind : {LocatorKind::kHough, LocatorKind::kNcc, LocatorKind::kLines})
      locators_[kind] = MakeLocator(kind);
  }

  // The reading if the film lay in the first of these orientations, and if the crosses that were
  // taken for the anchors were those `shift_mm` farther on in the layout.
  FilmReading Expand(const OrientationClass& orientations, const Vector2d& shift_mm) {
    FilmReading full = reading_;
    full.orientations = orientations;
    full.margin = kMostMargin;
    full.second = {};
    full.bend_mm = kBend_mm;
    // The film's position on the scan must not decide between one mesh and the next: in a cut scan
    // the film does not lie in the middle.
    full.free_mm = 0.5 * reading_.pixel_size.pixel_mm *
                   Vector2d(windows_.Scan().Width(), windows_.Scan().Height());
    full.prior = PriorIn(full, full.scanner, DepartureOf(camera_.fiducials, orientations));
    const size_t count = camera_.fiducials.size();
    const MarkRectangle rectangle = RectangleOfMarks(camera_.fiducials);
    full.marks.assign(count, {});
    full.candidates.assign(count, {});
    full.windows.assign(count, {});
    std::vector<int> trusted(count, -1);
    const std::vector<PointPair2d> anchors = AnchorsIn(orientations.front());
    const auto pixel_from_photo = FitAffine(anchors);
    if (pixel_from_photo) SearchAround(shift_mm, pixel_from_photo->transform, orientations.front());
    for (size_t i = 0; i < count; ++i) {
      const Fiducial& mark = camera_.fiducials[i];
      full.marks[i].place_mm = PlaceOnScan(mark.position_mm, rectangle, orientations.front());
      if (!pixel_from_photo) continue;
      const Vector2d place = mark.position_mm - shift_mm;
      full.windows[i] = WindowAround(pixel_from_photo->transform * place);
      full.candidates[i] =
          Candidates(found_.at(KeyOf(mark.mark, place, orientations.front())), &full.marks[i]);
      trusted[i] = AnchorAmong(full.candidates[i], place, anchors);
    }
    full.best.choice = ChooseAround(full.marks, full.prior, trusted);
    full.best.nats = NatsOfSet(full.marks, full.prior, full.best.choice);
    // One misplaced mark of four can mislead about the scanner; in a reseau the neighbours reveal a
    // misplaced cross.
    if (full.best.Matched() >= kLeastReseauMarks)
      full.scanner_margin = std::numeric_limits<double>::infinity();
    return full;
  }

 private:
  static constexpr double kMostMargin = 30;
  // Drawing, place in the layout (0.01 mm) and scan orientation.
  using Key = std::tuple<std::string, std::int64_t, std::int64_t, ScanOrientation>;

  // Positions in the layout and in the scan of the anchors that were found. None if too
  // few were found, or if the anchors contradict this scan orientation.
  std::vector<PointPair2d> AnchorsIn(ScanOrientation orientation) const {
    std::vector<Fiducial> anchors;
    for (const size_t i : anchors_) anchors.push_back(camera_.fiducials[i]);
    const auto relabel = Relabel(anchors, shapes_, reading_.orientations.front(), orientation);
    if (!relabel || reading_.best.Matched() < kLeastAnchors) return {};
    std::vector<PointPair2d> pairs;
    for (size_t a = 0; a < anchors.size(); ++a) {
      const int choice = reading_.best.choice[a];
      if (choice >= 0)
        pairs.push_back({anchors[(*relabel)[a]].position_mm, reading_.candidates[a][choice].pixel});
    }
    return pairs;
  }

  static Key KeyOf(const std::string& name, const Vector2d& place, ScanOrientation orientation) {
    return {name, std::llround(100 * place.x()), std::llround(100 * place.y()), orientation};
  }

  // Searches around positions of the layout that were not searched before; with the film shifted
  // by a mesh, most positions are the same.
  void SearchAround(const Vector2d& shift_mm, const Affine2d& pixel_from_photo,
                    ScanOrientation orientation) {
    struct Place {
      const std::string* name;
      Vector2d place;
      MarkCandidates* found;
    };
    std::vector<Place> fresh;
    for (const Fiducial& mark : camera_.fiducials) {
      const Vector2d place = mark.position_mm - shift_mm;
      const auto [at, is_fresh] = found_.try_emplace(KeyOf(mark.mark, place, orientation));
      if (is_fresh) fresh.push_back({&mark.mark, place, &at->second});
    }
    SideBySide(fresh.size(), [&](size_t i) {
      *fresh[i].found = Find(shapes_.at(*fresh[i].name), fresh[i].place, pixel_from_photo);
    });
  }

  PixelWindow WindowAround(const Vector2d& predicted_px) const {
    const int half = static_cast<int>(std::ceil(kWindowHalf_mm / reading_.pixel_size.pixel_mm));
    return {static_cast<int>(std::floor(predicted_px.x())) - half,
            static_cast<int>(std::floor(predicted_px.y())) - half, 2 * half + 1, 2 * half + 1};
  }

  MarkCandidates Find(const MarkShape& shape, const Vector2d& place,
                      const Affine2d& pixel_from_photo) {
    MarkSearch search;
    search.window = WindowAround(pixel_from_photo * place);
    search.pixel_from_mm = pixel_from_photo.A;
    search.turns_rad = {0};  // the rotation is known from the anchors
    return locators_.at(LocatorFor(shape, locator_))->Find(windows_, shape, search);
  }

  // Candidates of the reading's polarity; they are added to the mark, too.
  std::vector<MarkCandidate> Candidates(const MarkCandidates& found, AssignmentMark* mark) const {
    const auto& candidates = reading_.polarity == Polarity::kPositive ? found.bright : found.dark;
    const std::vector<double> nats = ScoreNats(candidates);
    mark->window_mm2 = std::max(found.searched_mm2, 1.0);
    for (size_t j = 0; j < candidates.size(); ++j)
      mark->candidates.push_back(
          {(candidates[j].pixel - reading_.middle_px) * reading_.pixel_size.pixel_mm, nats[j]});
    return candidates;
  }

  // Index of the candidate that was taken for an anchor at this place; -1 where there is none.
  int AnchorAmong(const std::vector<MarkCandidate>& candidates, const Vector2d& place,
                  const std::vector<PointPair2d>& anchors) const {
    for (const PointPair2d& anchor : anchors) {
      if ((anchor.source - place).norm() > kSamePlace_mm) continue;
      int nearest = -1;
      double least_px = kSameCross_mm / reading_.pixel_size.pixel_mm;
      for (size_t j = 0; j < candidates.size(); ++j) {
        const double off_px = (candidates[j].pixel - anchor.target).norm();
        if (off_px >= least_px) continue;
        least_px = off_px;
        nearest = static_cast<int>(j);
      }
      return nearest;
    }
    return -1;
  }

  ScanWindows windows_;
  const CameraFile& camera_;
  const MarkShapes& shapes_;
  std::optional<LocatorKind> locator_;
  std::map<LocatorKind, std::unique_ptr<Locator>> locators_;
  const std::vector<size_t>& anchors_;
  const FilmReading& reading_;  // of the anchors alone
  std::map<Key, MarkCandidates> found_;
};

// How many marks the layout moved by `shift_mm` has in common with itself.
int InCommon(const std::vector<Vector2d>& places, const Vector2d& shift_mm) {
  int common = 0;
  for (const Vector2d& a : places)
    if (std::any_of(places.begin(), places.end(),
                    [&](const Vector2d& b) { return (a + shift_mm - b).norm() < kSamePlace_mm; }))
      ++common;
  return common;
}

// Adds the shifts of these marks that move at least half of them to positions of others.
void AddShifts(const std::vector<Vector2d>& places, std::vector<Vector2d>* shifts) {
  constexpr size_t kLeast = 9;  // fewer are fiducial marks
  if (places.size() < kLeast) return;
  Eigen::AlignedBox2d box;
  for (const Vector2d& place : places) box.extend(place);
  const Vector2d centre = box.center();
  const Vector2d middle =
      *std::min_element(places.begin(), places.end(), [&](const Vector2d& a, const Vector2d& b) {
        return (a - centre).norm() < (b - centre).norm();
      });
  for (const Vector2d& place : places) {
    const Vector2d shift = place - middle;
    const bool known = std::any_of(shifts->begin(), shifts->end(), [&](const Vector2d& other) {
      return (shift - other).norm() < kSamePlace_mm;
    });
    if (!known && shift.norm() > kSamePlace_mm && 2 * InCommon(places, shift) >= std::ssize(places))
      shifts->push_back(shift);
  }
}

// The reading of one scan orientation, and those with the film moved by about a mesh,
// as long as one of them is more probable. Anchors on a border that hides some crosses may
// be found a mesh off; all crosses together show it, as a whole row then has none.
void AddWithShifts(const OrientationClass& orientations, const std::vector<Vector2d>& shifts,
                   GuidedSearch* search, std::vector<FilmReading>* readings) {
  constexpr int kMostMoves = 4;
  std::vector<Vector2d> tried;
  Vector2d centre = Vector2d::Zero(), best_shift = centre;
  double best_nats = -std::numeric_limits<double>::infinity();
  const auto look = [&](const Vector2d& shift) {
    if (std::any_of(tried.begin(), tried.end(),
                    [&](const Vector2d& other) { return (shift - other).norm() < kSamePlace_mm; }))
      return;
    tried.push_back(shift);
    readings->push_back(search->Expand(orientations, shift));
    if (readings->back().best.nats <= best_nats) return;
    best_nats = readings->back().best.nats;
    best_shift = shift;
  };
  look(centre);
  for (int move = 0; move < kMostMoves; ++move) {
    for (const Vector2d& shift : shifts) look(centre + shift);
    if (best_shift == centre) return;
    centre = best_shift;
  }
}

// The most probable reading. Scan orientations that the anchors allow but the crosses between them
// contradict are its rivals.
FilmReading MostProbable(const std::vector<FilmReading>& readings,
                         const std::vector<FilmReading>& excluded) {
  FilmReading best = BestOf(readings, excluded);
  std::map<ScanOrientation, double> most;
  for (const FilmReading& reading : readings)
    for (const ScanOrientation orientation : reading.orientations) {
      const auto at = most.try_emplace(orientation, reading.best.nats).first;
      at->second = std::max(at->second, reading.best.nats);
    }
  for (const auto& [orientation, nats] : most)
    if (std::find(best.orientations.begin(), best.orientations.end(), orientation) ==
        best.orientations.end())
      best.rival_orientations.push_back({orientation, best.best.nats - nats});
  return best;
}

// The orientation classes of all marks that the anchors allow; an allowed one comes first in
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
      // Of the marks along a side, prefers the one in its middle.
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

std::vector<Vector2d> MeshShifts(const std::vector<Fiducial>& fiducials) {
  constexpr size_t kMost = 8;
  std::map<std::string, std::vector<Vector2d>> of_drawing;
  std::vector<Vector2d> all, shifts;
  for (const Fiducial& fiducial : fiducials) {
    of_drawing[fiducial.mark].push_back(fiducial.position_mm);
    all.push_back(fiducial.position_mm);
  }
  AddShifts(all, &shifts);
  for (const auto& [drawing, places] : of_drawing) AddShifts(places, &shifts);
  const auto hundredths = [](const Vector2d& shift) { return std::llround(100 * shift.norm()); };
  std::stable_sort(shifts.begin(), shifts.end(),
                   [&](const auto& a, const auto& b) { return hundredths(a) < hundredths(b); });
  if (shifts.size() > kMost) shifts.resize(kMost);
  return shifts;
}

namespace {

// Readings of the scan in the polarity of the options, or in both polarities.
std::vector<FilmReading> ReadingsByAnchors(const Raster& scan, const CameraFile& camera,
                                           const MarkShapes& shapes,
                                           const InteriorOptions& options) {
  // Readings of the anchors this much less probable than the best one are dropped, except for a
  // second film on the scan.
  constexpr double kNearlyAsProbable = 10;
  const std::vector<size_t> anchors = AnchorMarks(camera.fiducials);
  const std::vector<Vector2d> shifts = MeshShifts(camera.fiducials);
  CameraFile outer = camera;
  outer.fiducials.clear();
  for (const size_t i : anchors) outer.fiducials.push_back(camera.fiducials[i]);
  const std::vector<FilmReading> ways = ReadFilmAllWays(scan, outer, shapes, options);
  std::vector<FilmReading> readings;
  for (const FilmReading& way : ways) {
    const bool first = readings.empty();
    if (!first && (way.best.Matched() < kLeastAnchors ||
                   (way.best.nats < ways.front().best.nats - kNearlyAsProbable &&
                    !ShowsAnotherFilm(ways.front(), way, way.best))))
      continue;
    GuidedSearch search(scan, camera, shapes, anchors, way, options.locator);
    for (const OrientationClass& orientations : Classes(camera, shapes, way, options))
      AddWithShifts(orientations, shifts, &search, &readings);
    if (readings.empty()) readings.push_back(search.Expand(way.orientations, Vector2d::Zero()));
  }
  return readings;
}

}  // namespace

FilmReading ReadFilmByAnchors(const Raster& scan, const CameraFile& camera,
                              const MarkShapes& shapes, const InteriorOptions& options) {
  std::vector<FilmReading> readings = ReadingsByAnchors(scan, camera, shapes, options);
  const double by_anchors = readings.front().polarity_margin;
  // All crosses decide on the polarity, once the anchors make it doubtful.
  for (FilmReading& reading : readings)
    reading.polarity_margin = std::numeric_limits<double>::infinity();
  if (by_anchors >= 0) return MostProbable(readings, {});
  InteriorOptions other = options;
  other.polarity = Opposite(options.polarity.value());
  return MostProbable(readings, ReadingsByAnchors(scan, camera, shapes, other));
}

}  // namespace orient::interior

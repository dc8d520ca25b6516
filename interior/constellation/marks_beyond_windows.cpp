#include "interior/constellation/marks_beyond_windows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/side_by_side.h"
#include "interior/locators/locator.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr int kLeastFound = 2;
constexpr std::size_t kMostReadings = 6;
// Half window around predicted places, and its growth with the distance from the nearest mark: the
// uncertainty due to film, scanner and the positions of coarse candidates.
constexpr double kWindowHalf_mm = 1.5, kGrow = 0.025;
// Closer than this, px, two candidates are one.
constexpr double kSameCandidate_px = 1.5;

// Predicts the marks that a reading lacks from its other marks.
class MarksBeyond {
 public:
  MarksBeyond(const FilmReading& reading, const Vector2d& scan_px)
      : reading_(reading),
        scan_px_(scan_px),
        film_(TransformOf(reading.marks, reading.prior, reading.best.choice)) {}

  // Whether the mark is lacking, on the scan, and not well within its own window.
  bool IsWorthALook(std::size_t i) const {
    if (reading_.best.choice[i] >= 0) return false;
    const Vector2d off = film_ * reading_.marks[i].place_mm - reading_.marks[i].place_mm;
    const Vector2d at = PixelOf(i);
    return off.cwiseAbs().maxCoeff() > 0.5 * kSmallestWindowMm - kWindowHalf_mm &&
           (at.array() >= 0).all() && (at.array() <= scan_px_.array()).all();
  }

  MarkSearch SearchOf(std::size_t i) const {
    const Vector2d at = PixelOf(i);
    const int half = static_cast<int>(
        std::ceil((kWindowHalf_mm + kGrow * NearestFound_mm(i)) / reading_.pixel_size.pixel_mm));
    const Eigen::Matrix2d axes = PhotoFromPixelAxes(reading_.orientations.front()).transpose();
    MarkSearch search;
    search.window = {static_cast<int>(std::floor(at.x())) - half,
                     static_cast<int>(std::floor(at.y())) - half, 2 * half + 1, 2 * half + 1};
    search.pixel_from_mm = film_.A * axes / reading_.pixel_size.pixel_mm;
    search.interpolate = true;  // small windows
    search.turns_rad = {0};
    return search;
  }

 private:
  Vector2d PixelOf(std::size_t i) const {
    return reading_.middle_px + film_ * reading_.marks[i].place_mm / reading_.pixel_size.pixel_mm;
  }

  double NearestFound_mm(std::size_t i) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < reading_.marks.size(); ++j)
      if (reading_.best.choice[j] >= 0)
        nearest =
            std::min(nearest, (reading_.marks[j].place_mm - reading_.marks[i].place_mm).norm());
    return nearest;
  }

  const FilmReading& reading_;
  Vector2d scan_px_;
  Affine2d film_;  // scan axes, mm, from the layout's places
};

// Adds the new candidates. All are scored again, as the level of clutter follows from all of them.
void AddCandidates(const MarkCandidates& found, std::size_t i, FilmReading* reading) {
  std::vector<MarkCandidate>& known = reading->candidates[i];
  for (const MarkCandidate& one :
       reading->polarity == Polarity::kPositive ? found.bright : found.dark)
    if (std::none_of(known.begin(), known.end(), [&](const MarkCandidate& other) {
          return (one.pixel - other.pixel).norm() < kSameCandidate_px;
        }))
      known.push_back(one);
  AssignmentMark& mark = reading->marks[i];
  mark.window_mm2 += found.searched_mm2;
  mark.candidates.clear();
  const std::vector<double> nats = ScoreNats(known);
  for (std::size_t j = 0; j < known.size(); ++j)
    mark.candidates.push_back(
        {(known[j].pixel - reading->middle_px) * reading->pixel_size.pixel_mm, nats[j]});
}

std::optional<FilmReading> Extended(const FilmReading& reading, const CameraFile& camera,
                                    const MarkShapes& shapes, std::optional<LocatorKind> wanted,
                                    ScanWindows* windows) {
  const Vector2d scan_px(windows->Scan().Width(), windows->Scan().Height());
  const MarksBeyond beyond(reading, scan_px);
  std::vector<std::size_t> lacking;
  for (std::size_t i = 0; i < reading.marks.size(); ++i)
    if (beyond.IsWorthALook(i)) lacking.push_back(i);
  if (lacking.empty()) return std::nullopt;
  std::vector<MarkCandidates> found(lacking.size());
  SideBySide(lacking.size(), [&](std::size_t k) {
    const MarkShape& shape = shapes.at(camera.fiducials[lacking[k]].mark);
    found[k] =
        MakeLocator(LocatorFor(shape, wanted))->Find(*windows, shape, beyond.SearchOf(lacking[k]));
  });
  FilmReading extended = reading;
  for (std::size_t k = 0; k < lacking.size(); ++k) AddCandidates(found[k], lacking[k], &extended);
  Assign(&extended);
  if (extended.best.nats <= reading.best.nats) return std::nullopt;
  return extended;
}

}  // namespace

std::vector<FilmReading> ReadingsBeyondWindows(const std::vector<FilmReading>& readings,
                                               const CameraFile& camera, const MarkShapes& shapes,
                                               std::optional<LocatorKind> locator,
                                               ScanWindows* windows) {
  std::vector<const FilmReading*> likely;
  for (const FilmReading& reading : readings)
    if (reading.best.Matched() >= kLeastFound) likely.push_back(&reading);
  std::stable_sort(likely.begin(), likely.end(), [](const FilmReading* a, const FilmReading* b) {
    return a->best.nats > b->best.nats;
  });
  if (likely.size() > kMostReadings) likely.resize(kMostReadings);
  std::vector<FilmReading> extended;
  for (const FilmReading* reading : likely)
    if (auto more = Extended(*reading, camera, shapes, locator, windows))
      extended.push_back(*std::move(more));
  return extended;
}

}  // namespace orient::interior

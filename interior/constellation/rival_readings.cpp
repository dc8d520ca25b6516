#include "interior/constellation/rival_readings.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/geometry/principal_axes.h"
#include "interior/constellation/set_evidence.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kMaxMargin = 30.0;
constexpr double kSamePlace_mm = 1.0;
constexpr double kThinnest = 0.1;  // of a set of marks that spans an area

// Largest distance, px, between where two readings put the corners of the marks' rectangle.
double LargestDifference(const FilmReading& a, const FilmReading& b) {
  const Affine2d film_a = TransformOf(a.marks, a.prior, a.best.choice);
  const Affine2d film_b = TransformOf(b.marks, b.prior, b.best.choice);
  Eigen::AlignedBox2d rectangle;
  for (const AssignmentMark& mark : a.marks) rectangle.extend(mark.place_mm);
  double most = 0;
  for (const auto corner : {Eigen::AlignedBox2d::BottomLeft, Eigen::AlignedBox2d::BottomRight,
                            Eigen::AlignedBox2d::TopLeft, Eigen::AlignedBox2d::TopRight}) {
    const Vector2d at = rectangle.corner(corner);
    const Vector2d pixel_a = a.middle_px + film_a * at / a.pixel_size.pixel_mm;
    const Vector2d pixel_b = b.middle_px + film_b * at / b.pixel_size.pixel_mm;
    most = std::max(most, (pixel_a - pixel_b).norm());
  }
  return most;
}

bool UsesTheSameMarks(const FilmReading& a, const FilmReading& b) {
  for (size_t i = 0; i < a.marks.size(); ++i)
    if ((a.best.choice[i] >= 0) != (b.best.choice[i] >= 0)) return false;
  return true;
}

// Positions of these marks in the reading, px.
std::vector<Vector2d> Places(const FilmReading& reading, const Assignment& marks) {
  std::vector<Vector2d> places;
  for (size_t i = 0; i < marks.choice.size(); ++i)
    if (marks.choice[i] >= 0) places.push_back(reading.candidates[i][marks.choice[i]].pixel);
  return places;
}

// Overlap of the rectangles around two sets of places, as a share of the smaller one.
double Overlap(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b) {
  Eigen::AlignedBox2d box_a, box_b;
  for (const Vector2d& place : a) box_a.extend(place);
  for (const Vector2d& place : b) box_b.extend(place);
  const Eigen::AlignedBox2d both = box_a.intersection(box_b);
  if (both.isEmpty()) return 0;
  return both.volume() / std::max(std::min(box_a.volume(), box_b.volume()), 1e-9);
}

// Whether every place of the smaller set is also one of the larger set.
bool LieTogether(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b,
                 double tolerance_px) {
  if (b.size() < a.size()) return LieTogether(b, a, tolerance_px);
  return std::all_of(a.begin(), a.end(), [&](const Vector2d& place) {
    return std::any_of(b.begin(), b.end(), [&](const Vector2d& other) {
      return (place - other).norm() <= tolerance_px;
    });
  });
}

}  // namespace

bool ReadingsAgree(const FilmReading& a, const FilmReading& b) {
  if (a.polarity != b.polarity) return false;
  const bool same_way = a.orientations == b.orientations;
  if (!same_way &&
      std::find(a.alike.begin(), a.alike.end(), b.orientations.front()) == a.alike.end())
    return false;
  if (a.best.Matched() == 0 || b.best.Matched() == 0) return true;
  if (!same_way && std::min(a.best.Matched(), b.best.Matched()) >= 3)
    return LieTogether(Places(a, a.best), Places(b, b.best), kSamePlace_mm / a.pixel_size.pixel_mm);
  const double tolerance_px = kSamePlace_mm / a.pixel_size.pixel_mm;
  std::vector<Vector2d> shared;
  for (size_t i = 0; i < a.marks.size(); ++i) {
    const int ca = a.best.choice[i], cb = b.best.choice[i];
    if (ca < 0 || cb < 0) continue;
    shared.push_back(a.marks[i].place_mm);
    if ((a.candidates[i][ca].pixel - b.candidates[i][cb].pixel).norm() > tolerance_px) return false;
  }
  const bool fixed = shared.size() >= 3 && Thickness(shared) > kThinnest;
  return fixed || LargestDifference(a, b) <= tolerance_px;
}

bool ShowsAnotherFilm(const FilmReading& best, const FilmReading& other, const Assignment& marks) {
  constexpr double kLeastOfBest = 0.5, kMostOverlap = 0.2;
  const auto all = static_cast<int>(best.marks.size());
  if (marks.Matched() < NeededMarks(all) || marks.nats < MinSetNats(all) ||
      marks.nats < kLeastOfBest * best.best.nats)
    return false;
  const double tolerance_px = kSamePlace_mm / best.pixel_size.pixel_mm;
  const std::vector<Vector2d> taken = Places(best, best.best), places = Places(other, marks);
  if (Overlap(taken, places) > kMostOverlap) return false;
  return std::none_of(places.begin(), places.end(), [&](const Vector2d& place) {
    return std::any_of(taken.begin(), taken.end(), [&](const Vector2d& other_place) {
      return (place - other_place).norm() <= tolerance_px;
    });
  });
}

FilmReading BestOf(const std::vector<FilmReading>& readings,
                   const std::vector<FilmReading>& excluded) {
  const auto best =
      std::max_element(readings.begin(), readings.end(),
                       [](const auto& a, const auto& b) { return a.best.nats < b.best.nats; });
  FilmReading result = *best;
  for (const FilmReading& other : readings)
    if (!ReadingsAgree(result, other))
      result.margin = std::min(result.margin, result.best.nats - other.best.nats);
  for (const FilmReading& other : readings)
    if (other.scanner != result.scanner && ReadingsAgree(result, other) &&
        !UsesTheSameMarks(result, other))
      result.scanner_margin = std::min(result.scanner_margin, result.best.nats - other.best.nats);
  for (const FilmReading& other : readings)
    if (ShowsAnotherFilm(result, other, other.best) ||
        ShowsAnotherFilm(result, other, other.second))
      result.margin = 0;
  result.margin = std::min(result.margin, kMaxMargin);
  for (const FilmReading& other : excluded)
    if (other.best.nats >= MinSetNats(static_cast<int>(other.marks.size())) &&
        !ShowsAnotherFilm(result, other, other.best))
      result.polarity_margin = std::min(result.polarity_margin, result.best.nats - other.best.nats);
  return result;
}

}  // namespace orient::interior

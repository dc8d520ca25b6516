#include "interior/rival_readings.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace orient {
namespace {

using Eigen::Vector2d;

constexpr double kMaxMargin = 30.0;

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

}  // namespace

bool SaysTheSame(const FilmReading& a, const FilmReading& b) {
  if (a.orientations != b.orientations || a.polarity != b.polarity) return false;
  if (a.best.Matched() == 0 || b.best.Matched() == 0) return true;
  const double tolerance_px = 1.0 / a.pixel_size.pixel_mm;  // one millimetre
  int shared = 0;
  for (size_t i = 0; i < a.marks.size(); ++i) {
    const int ca = a.best.choice[i], cb = b.best.choice[i];
    if (ca < 0 || cb < 0) continue;
    ++shared;
    if ((a.candidates[i][ca].pixel - b.candidates[i][cb].pixel).norm() > tolerance_px) return false;
  }
  return shared >= 2 || LargestDifference(a, b) <= tolerance_px;
}

FilmReading BestOf(const std::vector<FilmReading>& readings) {
  const auto best =
      std::max_element(readings.begin(), readings.end(),
                       [](const auto& a, const auto& b) { return a.best.nats < b.best.nats; });
  FilmReading result = *best;
  for (const FilmReading& other : readings)
    if (!SaysTheSame(result, other))
      result.margin = std::min(result.margin, result.best.nats - other.best.nats);
  for (const FilmReading& other : readings)
    if (other.scanner != result.scanner && SaysTheSame(result, other) &&
        !UsesTheSameMarks(result, other))
      result.scanner_margin = std::min(result.scanner_margin, result.best.nats - other.best.nats);
  result.margin = std::min(result.margin, kMaxMargin);
  return result;
}

}  // namespace orient

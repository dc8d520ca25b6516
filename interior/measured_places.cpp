#include "interior/measured_places.h"

#include <Eigen/LU>
#include <cmath>

namespace orient {
namespace {

using Eigen::Matrix2d;

// Of the drawing's size and turn: this moves a mark's outermost stroke by some hundredths of a
// pixel, on both sides alike.
constexpr double kSameLinear = 5e-4;

// Is the drawing seen by one transform what it is by the other?
bool SameDrawing(const MarkShape& shape, const Matrix2d& a, const Matrix2d& b) {
  const Matrix2d between = a.inverse() * b;
  const Matrix2d turn = between.array().round();
  if (!((between - turn).norm() < kSameLinear)) return false;
  return turn.isIdentity() || IsSymmetric(shape, turn);
}

}  // namespace

const FilmMark* MeasuredPlaces::Find(const MeasuringPlace& place) const {
  for (const auto& [known, mark] : measured_)
    if (known.shape == place.shape && known.polarity == place.polarity &&
        known.start == place.start &&
        SameDrawing(*place.shape, known.pixel_from_mm, place.pixel_from_mm))
      return &mark;
  return nullptr;
}

void MeasuredPlaces::Add(const MeasuringPlace& place, const FilmMark& measured) {
  measured_.push_back({place, measured});
}

}  // namespace orient

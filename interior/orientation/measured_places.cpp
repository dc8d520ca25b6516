#include "interior/orientation/measured_places.h"

#include <Eigen/LU>
#include <cmath>

namespace orient::interior {
namespace {

using Eigen::Matrix2d;

// Tolerance of the drawing's size and rotation: moves a mark's outermost stroke by hundredths of a
// pixel, on both sides alike.
constexpr double kSameLinear = 5e-4;

}  // namespace

bool MeasuredPlaces::SameDrawing(const MarkShape& shape, const Matrix2d& a,
                                 const Matrix2d& b) const {
  const Matrix2d between = a.inverse() * b;
  const Matrix2d turn = between.array().round();
  if (!((between - turn).norm() < kSameLinear)) return false;
  if (turn.isIdentity()) return true;
  const auto [at, fresh] =
      symmetric_.try_emplace({&shape, {turn(0, 0), turn(0, 1), turn(1, 0), turn(1, 1)}});
  if (fresh) at->second = IsSymmetric(shape, turn);
  return at->second;
}

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

}  // namespace orient::interior

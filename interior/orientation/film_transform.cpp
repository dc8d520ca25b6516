#include "interior/orientation/film_transform.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/geometry/principal_axes.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

// If a similarity misfits three marks by more, the scanner's two scales differ, or it is a
// print: the misfit would be an error all over the frame.
constexpr double kMostOfSimilarity_um = 300;

double Rms(const std::vector<Vector2d>& residuals) {
  double sum = 0;
  for (const Vector2d& v : residuals) sum += v.squaredNorm();
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

// By the calibrated positions, as measured marks are never exactly collinear.
bool OnOneLine(const std::vector<MeasuredMark>& marks) {
  constexpr double kThinnest = 0.05;
  std::vector<Vector2d> places;
  places.reserve(marks.size());
  for (const MeasuredMark& mark : marks) places.push_back(mark.photo_mm);
  return Thickness(places) <= kThinnest;
}

}  // namespace

FilmShape ShapeOf(const Affine2d& photo_from_pixel) {
  const Vector2d column = photo_from_pixel.A.col(0), row = photo_from_pixel.A.col(1);
  FilmShape shape;
  shape.column_um = 1e3 * column.norm();
  shape.row_um = 1e3 * row.norm();
  shape.scale_difference = 2 * (shape.column_um - shape.row_um) / (shape.column_um + shape.row_um);
  shape.shear_rad =
      std::asin(std::clamp(column.dot(row) / (column.norm() * row.norm()), -1.0, 1.0));
  return shape;
}

std::optional<FilmTransform> FitFilm(const std::vector<MeasuredMark>& marks, bool mirrored) {
  if (marks.size() < 3 || OnOneLine(marks)) return std::nullopt;
  std::vector<PointPair2d> pairs;
  for (const MeasuredMark& mark : marks) pairs.push_back({mark.pixel, mark.photo_mm});
  // photo y points up and rows down, so an unmirrored scan has the negative determinant.
  const auto similarity = FitSimilarity(pairs, !mirrored);
  if (!similarity) return std::nullopt;
  const double similarity_rms_um = 1e3 * Rms(similarity->residuals);
  const bool affinity_shows = marks.size() >= 4 || similarity_rms_um > kMostOfSimilarity_um;
  const auto affine = affinity_shows ? FitAffine(pairs) : similarity;
  if (!affine) return std::nullopt;
  FilmTransform film;
  film.affine = marks.size() >= 4;
  film.photo_from_pixel = affine->transform;
  for (const Vector2d& v : affine->residuals) film.residual_um.push_back(1e3 * v);
  film.sigma0_um = film.affine ? 1e3 * affine->sigma0 : 0;
  film.similarity_rms_um = similarity_rms_um;
  film.pixel_um = 1e3 * std::sqrt(std::abs(film.photo_from_pixel.A.determinant()));
  film.shape = ShapeOf(film.photo_from_pixel);
  return film;
}

}  // namespace orient::interior

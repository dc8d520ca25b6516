#include "patchdb/harvest/place.h"

#include <Eigen/LU>
#include <algorithm>

#include "core/geometry/principal_axes.h"

namespace orient::patchdb {
namespace {

using Unknowns = Eigen::Vector4d;  // X, Y, Z; by how much the orthophotos' heights are too high
using PixelRow = Eigen::Matrix<double, 2, 4>;

constexpr int kMaxIterations = 20;
constexpr double kConverged = 1e-4;    // m
constexpr double kDifferenceStep = 1;  // m; every source's mapping is smooth beyond that
// Redundancy, as a share of an observation's variance, below which nothing checks it.
constexpr double kLeastRedundancy = 0.02;

struct Linearised {
  std::vector<PixelRow> by_pixel;
  std::vector<Eigen::Matrix2d> covariances;
  std::vector<Eigen::Vector2d> residuals;  // measured - computed
  Eigen::RowVector4d by_height;
  double height_residual = 0;
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Unknowns right = Unknowns::Zero();
};

bool AddSighting(const Sighting& sighting, const Unknowns& at, Linearised* system) {
  const SourceView& view = *sighting.view;
  Eigen::Vector3d ground = at.head<3>();
  const Eigen::Vector3d effect =
      view.IsOrthophoto() ? view.HeightEffect(ground) : Eigen::Vector3d::Zero();
  ground.head<2>() += effect.head<2>() * at[3];
  const auto pixel = view.PixelFromGround(ground);
  const auto by_ground = PixelDerivatives(view, ground, kDifferenceStep);
  if (!pixel || !by_ground) return false;
  PixelRow row;
  row.leftCols<3>() = *by_ground;
  row.col(3) = by_ground->leftCols<2>() * effect.head<2>();
  const Eigen::Matrix2d covariance = sighting.covariance_px2 + view.OrientationCovariance(ground);
  const Eigen::Matrix2d weight = covariance.inverse();
  if (!weight.allFinite()) return false;
  const Eigen::Vector2d residual = sighting.pixel - *pixel;
  system->by_pixel.push_back(row);
  system->covariances.push_back(covariance);
  system->residuals.push_back(residual);
  system->normal += row.transpose() * weight * row;
  system->right += row.transpose() * weight * residual;
  return true;
}

// Slope towards east (axis 0) or north (1). The grid is as wide as the chip, with few nodes if the
// DEM is coarse: the difference is taken within it.
double Slope(const HeightGrid& heights, const Eigen::Vector2d& at, int axis) {
  const double reach = (heights.size - 1) / 2.0 * heights.step_m;
  Eigen::Vector2d before = at, after = at;
  before[axis] = std::max(at[axis] - heights.step_m, -reach);
  after[axis] = std::min(at[axis] + heights.step_m, reach);
  return (heights.At(after.x(), after.y()) - heights.At(before.x(), before.y())) /
         (after[axis] - before[axis]);
}

// Observation equation of the surface: Z - h(X, Y) = 0.
bool AddHeight(const HeightGrid& heights, const Eigen::Vector3d& start_m, double sigma_m,
               const Unknowns& at, Linearised* system) {
  const Eigen::Vector2d off = (at.head<3>() - start_m).head<2>();
  const double height = heights.At(off.x(), off.y());
  system->by_height << -Slope(heights, off, 0), -Slope(heights, off, 1), 1, 0;
  system->height_residual = height - at.z();
  if (!system->by_height.allFinite() || !std::isfinite(height)) return false;
  const double weight = 1 / (sigma_m * sigma_m);
  system->normal += weight * system->by_height.transpose() * system->by_height;
  system->right += weight * system->height_residual * system->by_height.transpose();
  system->normal(3, 3) += weight;
  system->right(3) -= weight * at[3];
  return true;
}

std::optional<Linearised> Linearise(const std::vector<Sighting>& sightings,
                                    const HeightGrid& heights, const Eigen::Vector3d& start_m,
                                    double sigma_m, const Unknowns& at) {
  Linearised system;
  for (const Sighting& sighting : sightings)
    if (!AddSighting(sighting, at, &system)) return std::nullopt;
  if (!AddHeight(heights, start_m, sigma_m, at, &system)) return std::nullopt;
  return system;
}

// Directions in which nothing checks the sighting are left out.
double SightingTest(const Eigen::Matrix2d& covariance, const PixelRow& row,
                    const Eigen::Matrix4d& inverse, const Eigen::Vector2d& residual) {
  const PrincipalAxes of_residual = AxesOf(covariance - row * inverse * row.transpose());
  double test = 0;
  for (int i = 0; i < 2; ++i) {
    if (of_residual.values[i] < kLeastRedundancy * covariance.trace()) continue;
    const double along = of_residual.vectors.col(i).dot(residual);
    test += along * along / of_residual.values[i];
  }
  return test;
}

Place PlaceOf(const Linearised& system, const Eigen::Matrix4d& inverse, const Unknowns& at,
              bool orthophotos_only, double sigma_m) {
  Place place;
  place.ground_m = at.head<3>();
  place.covariance_m2 = inverse.topLeftCorner<3, 3>();
  const double variance = sigma_m * sigma_m;
  // Both errors are observed as 0: the estimate errs by minus what their covariance says.
  const Unknowns gain = orthophotos_only
                            ? Unknowns(-inverse.col(3) / variance)
                            : Unknowns(inverse * system.by_height.transpose() / variance);
  place.height_effect = gain.head<3>();
  place.residuals_px = system.residuals;
  const double left =
      variance - (system.by_height * inverse * system.by_height.transpose()).value();
  if (left > kLeastRedundancy * variance)
    place.height_test = system.height_residual / std::sqrt(left);
  for (std::size_t i = 0; i < system.residuals.size(); ++i)
    place.sighting_test = std::max(
        place.sighting_test,
        SightingTest(system.covariances[i], system.by_pixel[i], inverse, system.residuals[i]));
  return place;
}

}  // namespace

std::optional<Place> EstimatePlace(const std::vector<Sighting>& sightings,
                                   const HeightGrid& heights, const Eigen::Vector3d& start_m,
                                   double height_sigma_m) {
  Unknowns at;
  at << start_m, 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const auto system = Linearise(sightings, heights, start_m, height_sigma_m, at);
    if (!system) return std::nullopt;
    const Eigen::Matrix4d inverse = system->normal.inverse();
    if (!inverse.allFinite()) return std::nullopt;
    const Unknowns step = inverse * system->right;
    if (step.norm() < kConverged) {
      const bool orthophotos_only =
          std::all_of(sightings.begin(), sightings.end(),
                      [](const Sighting& s) { return s.view->IsOrthophoto(); });
      return PlaceOf(*system, inverse, at, orthophotos_only, height_sigma_m);
    }
    at += step;
  }
  return std::nullopt;
}

}  // namespace orient::patchdb

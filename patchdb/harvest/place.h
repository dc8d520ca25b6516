// Where on the ground a patch lies: what one or several sources show of it and the height that the
// surface has there, adjusted together.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "patchdb/harvest/source_view.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

// One source shows the point at a pixel of its raster.
struct Sighting {
  const SourceView* view;  // not owned, never null
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2;  // of pointing or matching; that of the orientation is the view's
};

struct Place {
  Eigen::Vector3d ground_m;
  Eigen::Matrix3d covariance_m2;
  // How ground_m moves for each metre by which the heights are too high: the surface's, or where
  // only orthophotos show the point, those that they were made with.
  Eigen::Vector3d height_effect;
  std::vector<Eigen::Vector2d> residuals_px;  // measured - computed, one a sighting
  // How far the surface's height departs from the one that the sightings alone would give, in its
  // standard deviations (Baarda's w). 0 where they give none: a single view, orthophotos.
  double height_test = 0;
  // The largest of the sightings' own tests: v' Qvv^-1 v, chi-square with two degrees of freedom.
  double sighting_test = 0;
};

// Least squares with the unknowns X, Y, Z and the common error of the heights that orthophotos were
// made with (it moves what they show, SourceView::HeightEffect). Observations: two a
// sighting, weighted with its own and its orientation's covariance; the surface's height under the
// point; that common error, zero; both with height_sigma_m. `start_m` is where `heights` are
// centred. Empty where a sighting's source does not show the point, or the solution leaves the
// heights.
std::optional<Place> EstimatePlace(const std::vector<Sighting>& sightings,
                                   const HeightGrid& heights, const Eigen::Vector3d& start_m,
                                   double height_sigma_m);

}  // namespace orient::patchdb

// Matched patches as observations of a pose: individual errors and shared ones.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/geometry/pose.h"

namespace orient::exterior {

struct PatchObservation {
  Eigen::Vector3d ground_m;
  Eigen::Vector2d pixel;           // scan, measured
  Eigen::Matrix2d covariance_px2;  // of this observation alone
  // How the ground point moves for each metre by which the heights under its source are wrong, and
  // how wrong they may be (one sigma); zero where nothing is known.
  Eigen::Vector3d height_effect = Eigen::Vector3d::Zero();
  double height_sigma_m = 0;
  // One sigma of the ground point's own height where that effect does not apply: an orthophoto
  // does not show heights, and the surface's error differs from that of the heights with which
  // it was made.
  double surface_sigma_m = 0;
  // One sigma in the photo of how far its source may be displaced as a whole, and as much again
  // towards its border; orthophotos'. What photos have in common is in what all matches share.
  double source_sigma_px = 0;
  // The part of that covariance's OwnVariance (linearised_matches.h) due to the ground point's own
  // coordinates: unlike matches, surveyed points share no errors that residuals
  // would not show.
  double ground_px2 = 0;
  // What it was cut from: observations of one source share smooth errors.
  std::int64_t source = 0;
};

struct CommonErrors {
  // Covariance of photo_from_pixel (a11 a12 a21 a22 t1 t2; mm), zero for digital cameras.
  Matrix6d interior = Matrix6d::Zero();
  // Smooth deformation of the film between its marks: one sigma, and the distance in the photo over
  // which it fades, both in scan pixels; zero for digital cameras.
  double film_sigma_px = 0;
  double film_correlation_px = 1;
  // At which the photo was matched: side of one of its pixels, scan pixels.
  int reduction = 1;
  // Half of the frame's longer side, scan pixels.
  double half_frame_px = 1000;
  // Correlation length of height errors, and of others that fade over the ground.
  double height_correlation_m = 1000;
};

}  // namespace orient::exterior

// Tie points: places that two or more photos of a block show, measured in all of them.
//
// Every photo owns the part of the ground that it sees nearer to its middle than the others do;
// there one interest point a cell of its frame is sought in every other photo that shows it. So the
// ties spread over the von Gruber areas and over every overlap, three-fold and side-lap ones too,
// and no place is measured twice.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/ground_surface.h"
#include "core/geometry/photo_view.h"
#include "exterior/photo_image.h"

namespace orient {

// A photo whose pose is known at least roughly.
struct TiePhoto {
  std::string name;
  PhotoView view;
  Matrix6d pose_covariance = Matrix6d::Zero();  // in the order of Vector6d
  const PhotoImage* image = nullptr;            // not owned
};

struct TieSighting {
  std::size_t photo = 0;  // index into the photos
  Eigen::Vector2d pixel;  // scan
  Eigen::Matrix2d covariance_px2;
  double ncc = 1;  // with the owner's window
};

struct MeasuredTie {
  Eigen::Vector3d ground_m;       // on the surface under the owner's pose: a first value
  std::vector<TieSighting> seen;  // the owner first; at least two
};

struct TieOptions {
  int cells = 15;        // of a frame, each way
  int tries = 3;         // interest points a cell, until one is found in another photo
  int window_px = 256;   // side of what is searched for interest points, at most a cell
  int template_px = 35;  // side of a matched window
  // One sigma of what stands on the surface, in pixels of ground: roofs and crowns are good ties.
  double height_sigma_px = 5;
  double max_radius_px = 80;  // of a search window, however little is known of the poses
  double min_score = 0.65;    // NCC
  // How far the way back from the other photo may end beside the point that it began at.
  double max_way_back_px = 0.4;
  // Matching's covariance knows the grey values' noise only: one sigma of what it does not know.
  double model_sigma_px = 0.1;
};

// Those ties that photos[owner] owns. Reads windows of the images only. The same ones every time. A
// photo that is damaged shows nothing there; throws InputError where the owner is.
std::vector<MeasuredTie> FindTies(const std::vector<TiePhoto>& photos, std::size_t owner,
                                  const GroundSurface& surface, const TieOptions& options = {});

}  // namespace orient

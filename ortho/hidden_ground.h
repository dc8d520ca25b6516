// Ground that a photo does not see because other ground stands before it: behind houses and cliffs
// an orthophoto would show their roofs and edges twice.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/terrain/ground_surface.h"

namespace orient::ortho {

class HiddenGround {
 public:
  // Refers to the surface. `centre_m` is the projection centre.
  HiddenGround(const GroundSurface& surface, const Eigen::Vector3d& centre_m);

  // Whether anything within these bounds may be hidden: whether the surface anywhere before it is
  // steeper than the rays. False is certain, and settles most photos of open country.
  bool MayHide(const Bounds& bounds) const;

  // Whether the ray to a point of the surface meets the surface before, or comes from where the
  // ground in its way is not known.
  bool Hides(const Eigen::Vector3d& ground_m) const;

 private:
  double SteepestIn(const Bounds& bounds) const;

  const GroundSurface& surface_;
  Eigen::Vector3d centre_m_;
  Bounds extent_;
  double block_m_ = 1;
  int columns_ = 0, rows_ = 0;
  std::vector<float> steepest_;  // rise over run, of each block of cells, row by row from the south
};

}  // namespace orient::ortho

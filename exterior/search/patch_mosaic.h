// All patches of a region as one coarse orthophoto: many small patches together show surroundings
// that a single one does not. Private to exterior.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/raster/image.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

class PatchMosaic {
 public:
  // Every cell of `gsd_m` is the mean of the chips' pixels in it, NaN where there are none. Chips
  // whose pixels are larger than a cell are interpolated. Empty if patches are so far apart that
  // the mosaic would have more than `max_cells`.
  static std::optional<PatchMosaic> Of(const std::vector<patchdb::Patch>& patches, double gsd_m,
                                       double max_cells = 16e6);

  // A square of `side` pixels around a ground point: the image's pixel (u, v) off its middle shows
  // the ground at `ground_from_image` * (u, v). NaN where the mosaic has gaps.
  Image Draw(const Eigen::Vector2d& centre_m, const Eigen::Matrix2d& ground_from_image,
             int side) const;
  // Mean height of the patches in the square of this half size, NaN where there are none.
  double HeightAround(const Eigen::Vector2d& centre_m, double half_m) const;

 private:
  Eigen::Vector2d CellOf(const Eigen::Vector2d& ground_m) const {
    return {(ground_m.x() - west_m_) / gsd_m_, (north_m_ - ground_m.y()) / gsd_m_};
  }
  void Add(const patchdb::Patch& patch, std::vector<float>* weights);

  double gsd_m_ = 1, west_m_ = 0, north_m_ = 0;
  Image grey_;
  std::vector<Eigen::Vector3d> points_m_;  // the patches' points, from west to east
};

}  // namespace orient::exterior

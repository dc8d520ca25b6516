// Tiles of the patches' mosaic, and where in the photo they may lie. Private to exterior.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/matching/image_correlator.h"
#include "exterior/search/patch_mosaic.h"
#include "exterior/steps/consensus.h"
#include "exterior/steps/photo_image.h"

namespace orient::exterior {

class MosaicTiles {
 public:
  // At the coarsest level of the photo, no larger than can be searched whole, at which the patches
  // are dense enough to make tiles. `gsd_m`: of a scan pixel. If there are more tiles than can be
  // searched for, those nearest to `middle_m` are kept. Empty: there is no such level.
  static std::optional<MosaicTiles> Of(const std::vector<patchdb::Patch>& patches,
                                       const PhotoImage& photo, double gsd_m,
                                       const Eigen::Vector2d& middle_m);

  int Reduction() const { return reduction_; }
  std::size_t Count() const { return middles_m_.size(); }

  // The offset on the ground, in metres, of one scan pixel to the right and one down, about a
  // point.
  using Shape = std::function<Eigen::Matrix2d(const Eigen::Vector3d& ground_m)>;
  // One voting patch per tile, with candidates anywhere in the photo.
  std::vector<VotingPatch> Seek(const Shape& ground_from_scan) const;

 private:
  MosaicTiles(PatchMosaic mosaic, int reduction, ImageWindow photo, int side)
      : mosaic_(std::move(mosaic)),
        reduction_(reduction),
        photo_(std::move(photo)),
        search_(photo_.image, side) {}

  PatchMosaic mosaic_;
  int reduction_;
  ImageWindow photo_;
  ImageCorrelator search_;
  std::vector<Eigen::Vector3d> middles_m_;
};

}  // namespace orient::exterior

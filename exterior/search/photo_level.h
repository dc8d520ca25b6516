// A whole photo at one level, searched for small images by the orientation of their gradients: in
// tiles, so that only some need be searched. The tiles take some 20 bytes per pixel of the
// level. Private to exterior.
#pragma once

#include <vector>

#include "core/matching/image_correlator.h"
#include "exterior/steps/match.h"
#include "exterior/steps/photo_image.h"

namespace orient::exterior {

// Reduction of the finest level with at most `most_pixels` pixels.
int FinestReduction(const PhotoImage& photo, double most_pixels);

class PhotoLevel {
 public:
  // For images of `side` pixels of the level, odd.
  PhotoLevel(const PhotoImage& photo, int reduction, int side);

  int Reduction() const { return reduction_; }
  int Side() const { return side_; }

  struct Places {
    std::vector<Candidate> best;  // where the image's middle may lie, the best first
    double area_px2 = 0;          // of the scan, that was searched
  };
  // In the tiles that come within `radius_px` of a scan pixel.
  Places Find(const Image& image, const Eigen::Vector2d& around_px, double radius_px, int at_most,
              double min_score) const;

 private:
  struct Tile {
    Eigen::Vector2d first_px, last_px;  // of the scan, where an image's middle may lie
    ImageWindow window;
    ChannelCorrelator search;
  };
  int reduction_, side_;
  std::vector<Tile> tiles_;
};

}  // namespace orient::exterior

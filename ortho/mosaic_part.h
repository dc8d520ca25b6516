// An orthophoto as a part of a mosaic.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ortho/map_grid.h"

namespace orient::ortho {

// Grey values as a mosaic shows them: gain * value + offset.
struct Tone {
  double gain = 1, offset = 0;

  double Shown(double value) const { return gain * value + offset; }
};

// A file that MakeOrthophoto wrote, of whatever grid of the mosaic's pixel size.
struct MosaicPart {
  std::string name, path;
  MapGrid grid;
  Eigen::Vector2d nadir_m;
  std::vector<Tone> tones = {};  // of each band; empty: as they are
};

}  // namespace orient::ortho

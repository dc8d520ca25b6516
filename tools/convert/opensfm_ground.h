// Which ground system the poses of an OpenSfM reconstruction are in.
//
// OpenSfM's own are topocentric. OpenDroneMap replaces reconstruction.json by one of the same form
// whose poses are in a projected CRS minus an offset (opensfm/actions/export_geocoords.py): x =
// A x_t + b of topocentric x_t, where A and b are the projection's derivative and value at
// reference_lla; R becomes R A^-1. Taken for topocentric, they would be turned by the meridian
// convergence. The shots' gps_position stays topocentric and gives it away.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/exchange/opensfm.h"
#include "core/terrain/crs.h"

namespace orient {

struct OpensfmGroundOptions {
  std::string input;       // the folder, for messages and for the files that lie beside
  std::optional<Crs> crs;  // of the block; OpenDroneMap's coords.txt goes before it
  std::optional<Eigen::Vector2d> offset;  // said by the user: the poses are projected, minus this
};

// The reconstruction with topocentric poses, whatever it was written in. `messages` says which
// system was taken and what speaks for it. Throws InputError where gps_position fits neither
// system, or where the poses are projected and the offset is not known.
OpensfmReconstruction TopocentricOpensfm(OpensfmReconstruction reconstruction,
                                         const OpensfmGroundOptions& options,
                                         std::vector<std::string>* messages);

}  // namespace orient

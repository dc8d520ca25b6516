// The interior orientation of many photos as tables (CSV) for people and spreadsheets.
#pragma once

#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"

namespace orient {

// One row per photo: status, film transform, precision, messages. Empty cells for what is not
// known.
std::string InteriorTable(const std::vector<InteriorResult>& results);

// One row per mark and photo: where it is on the scan and in the camera, its residual.
std::string MarkTable(const std::vector<InteriorResult>& results,
                      const std::vector<Fiducial>& fiducials);

}  // namespace orient

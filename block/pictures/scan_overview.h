// The whole scan of a photo that is not ok: where marks or patches were searched for, and what was
// found.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/raster/raster.h"

namespace orient::block {

enum class OverviewState { kUsed, kRejected, kNotFound };

// A mark or a patch. All places in pixels of the scan.
struct OverviewItem {
  std::string label;  // empty: none is written
  OverviewState state = OverviewState::kNotFound;
  std::optional<SearchedWindow> window;     // where it was searched for
  std::optional<Eigen::Vector2d> expected;  // where the transform or the pose has it
  std::optional<Eigen::Vector2d> found;
};

// Fiducial marks, those not found as well.
std::vector<OverviewItem> OverviewOf(const InteriorResult& result);
// Patches that could be visible.
std::vector<OverviewItem> OverviewOf(const ExteriorResult& result);

// Writes a PNG of at most 900 pixels a side: windows as frames, expected places as small circles,
// a line from there to a cross where something was found; green used, orange rejected, red
// not found. Throws InputError where the scan cannot be read or the file not written.
void WriteScanOverview(const std::string& path, const Raster& scan,
                       const std::vector<OverviewItem>& items);

// Writes the scan as a PNG of at most 240 pixels a side; reads all of it. Throws as above.
void WriteThumbnail(const std::string& path, const Raster& scan);

}  // namespace orient::block

// The orthophoto of one oriented photo, as a Cloud Optimized GeoTIFF.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/terrain/crs.h"
#include "core/terrain/ground_accuracy.h"
#include "core/terrain/photo_view.h"
#include "ortho/map_grid.h"

namespace orient::ortho {

struct OrientedPhoto {
  std::string name, scan;  // `scan`: its file
  PhotoView view;
  std::optional<Matrix6d> covariance = std::nullopt;  // of the pose; empty: not known
  std::vector<Bounds> marks = {};  // fiducial marks in the frame (photo system, mm): not shown
  bool negative = false;           // the scan's: its orthophoto is a positive
};

struct OrthoOptions {
  std::string dem;
  Crs crs;
  double gsd_m = 1;
  double height_sigma_m = 0;                         // of the DEM
  double border_mm = 0;                              // of the frame that is not shown
  int threads = 0;                                   // 0: one a core
  std::map<std::string, std::string> metadata = {};  // further entries
};

// The part of the DEM that the photo may show. Throws InputError if it has no heights there.
GroundSurface SurfaceUnderPhoto(const PhotoView& view, const std::string& dem, const Crs& crs);

// Ground size, m, of a pixel of the photo at the centre of its frame.
double NaturalGsd(const PhotoView& view, const GroundSurface& surface);

// What an orthophoto will be.
struct OrthoPlan {
  MapGrid grid;
  std::vector<Eigen::Vector2d> outline_m;  // of what the photo shows, closed
  std::optional<GroundAccuracy> accuracy;
  double with_heights = 1;  // share of the frame under which the DEM has some
};

// Throws InputError: no ground that the photo shows, far too many pixels.
OrthoPlan PlanOrthophoto(const OrientedPhoto& photo, const OrthoOptions& options);

// Shares of the grid's pixels.
struct OrthoShares {
  double seen = 0, hidden = 0;
};

// Writes `path`, with the scan's bands and type of values and no data where the frame, the surface
// or the scan ends, and where the surface hides the ground; and beside it, where anything is
// hidden, HiddenPath(path), 1 there and 0 elsewhere. Works in tiles on all cores: memory does not
// grow with the photo. `listener` may be null. Throws InputError: a scan that cannot be read or
// shows nothing.
OrthoShares MakeOrthophoto(const OrientedPhoto& photo, const OrthoOptions& options,
                           const OrthoPlan& plan, const std::string& path,
                           ProgressListener* listener);

// Metadata of an orthophoto: OrthoPlan::with_heights.
inline constexpr const char* kWithHeights = "ORIENT_FRAME_WITH_HEIGHTS";

// Metadata of an orthophoto: whether there is a HiddenPath, "yes" or "no".
inline constexpr const char* kHasHidden = "ORIENT_HAS_HIDDEN";

// "dir/4711.tif" -> "dir/4711.hidden.tif".
std::string HiddenPath(const std::string& path);

}  // namespace orient::ortho

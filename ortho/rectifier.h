// One photo over the ground: where the pixels of a map lie in its scan, and what it shows there.
#pragma once

#include <cstdint>
#include <vector>

#include "core/raster/band_raster.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "ortho/frame_table.h"
#include "ortho/hidden_ground.h"
#include "ortho/map_grid.h"

namespace orient::ortho {

enum class Shown : std::uint8_t { kNothing, kHidden, kSeen };

// A window of an orthophoto, row by row. `values` of pixels that are not seen are 0.
struct OrthoTile {
  PixelWindow window;
  std::vector<Image> values;  // of each band
  std::vector<Shown> shown;
};

struct RectifierOptions {
  double border_mm = 0;            // along the frame's edge that is not shown
  std::vector<Bounds> marks = {};  // of the photo system, mm: nor are these
  bool negative = false;           // unsigned values are inverted, others cannot be
  double most_values = 1 << 24;    // of the scan, read at a time: 64 MB
};

class Rectifier {
 public:
  // Refers to surface and scan, and is safe to use from several threads.
  Rectifier(const PhotoView& view, const GroundSurface& surface, const BandRaster& scan,
            const RectifierOptions& options);

  // Pixel centres of the grid's window in the scan; shown says which of them have one.
  struct Places {
    std::vector<Eigen::Vector2d> scan_px;
    std::vector<Shown> shown;
  };
  Places PlacesOf(const MapGrid& grid, const PixelWindow& window) const;

  // Bicubic; averaged over the pixel's area where it is coarser than the scan's by a fifth or more.
  // Throws InputError where the scan is damaged.
  OrthoTile Draw(const MapGrid& grid, const PixelWindow& window) const;

 private:
  // Of one point of the ground.
  struct Place {
    Eigen::Vector2d scan_px = Eigen::Vector2d::Zero();
    double height = 0;
    bool seen = false;
  };
  Place PlaceOf(const Eigen::Vector2d& ground_m) const;
  std::vector<Place> PlacesOfRow(const MapGrid& grid, const PixelWindow& window, int row) const;
  OrthoTile Quartered(const MapGrid& grid, const PixelWindow& window) const;
  void MarkHidden(const MapGrid& grid, const PixelWindow& window,
                  const std::vector<double>& heights, Places* places) const;

  const GroundSurface& surface_;
  const BandRaster& scan_;
  bool negative_;
  double most_values_;
  Eigen::Vector3d centre_m_;
  Eigen::Matrix3d photo_from_ground_;
  double principal_distance_mm_;
  FrameTable table_;
  HiddenGround hidden_;
};

// Bounds of the ground that the photo's frame shows: of its outline on the surface, or where the
// surface ends. Empty where it shows none.
std::optional<Bounds> ShownGround(const PhotoView& view, const GroundSurface& surface);

}  // namespace orient::ortho

// Which orthophoto a mosaic shows where: a polygon for each photo, in a file that may be edited.
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/terrain/crs.h"
#include "ortho/map_grid.h"

namespace orient::ortho {

// What of the ground a photo shows, and from where.
struct SeamPhoto {
  std::string name;
  Eigen::Vector2d nadir_m;
  std::vector<Eigen::Vector2d> outline_m;  // closed
};

// Polygons of a GeoPackage's layer "seamlines" with the column "photo". Where polygons overlap the
// first counts.
class Seamlines {
 public:
  // Every place of the ground to the photo, of those that show it, whose nadir is the nearest: its
  // lines run where both photos look equally steeply, and houses lean least.
  static Seamlines ByNearestNadir(const std::vector<SeamPhoto>& photos);
  // The outlines of cells: `photo_of_cell` is an index into `photos`, row by row, -1 for nobody's.
  static Seamlines OfCells(const std::vector<std::string>& photos, const MapGrid& cells,
                           const std::vector<int>& photo_of_cell);
  // Throws InputError naming the file: not readable, no such layer or column, another CRS.
  static Seamlines FromFile(const std::string& path, const Crs& crs);

  Seamlines(Seamlines&&) noexcept;
  Seamlines& operator=(Seamlines&&) noexcept;
  ~Seamlines();

  // With these items of metadata. The same lines and items give the same bytes.
  void Write(const std::string& path, const Crs& crs,
             const std::map<std::string, std::string>& metadata = {}) const;

  // Of the polygons, in their order; a photo may have several.
  const std::vector<std::string>& Photos() const;
  // The index into Photos() at each pixel's centre, row by row; -1 outside all polygons.
  std::vector<int> PhotoAt(const MapGrid& grid, const PixelWindow& window) const;

 private:
  struct Impl;
  explicit Seamlines(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace orient::ortho

// Coordinate reference systems of ground coordinates, and transforms between them (PROJ).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

namespace orient {

// A projected, metric CRS with east, north axes. Cheap to copy.
class Crs {
 public:
  // From anything PROJ accepts (EPSG:32635, WKT, PROJ string). Throws InputError that names
  // `origin` (a file or an option) when the text is not understood, not projected, not in metres or
  // its axes are not east and north. A CRS whose authority lists north first is read as east, north
  // (the order of every GIS); of a compound CRS only the horizontal part counts.
  static Crs Parse(const std::string& definition, const std::string& origin);
  // From a .prj or any text file holding the definition.
  static Crs FromFile(const std::string& path);

  const std::string& Wkt() const { return wkt_; }  // WKT2
  std::string Wkt1() const;                        // for .prj files
  std::string Name() const;                        // of one without a name its PROJ string
  std::optional<int> Epsg() const;
  bool SameAs(const Crs& other) const;  // horizontally, whatever the spelling

 private:
  explicit Crs(std::string wkt) : wkt_(std::move(wkt)) {}
  std::string wkt_;
};

// The same for any two definitions, geographic ones too. Throws InputError: not understood.
bool SameHorizontalCrs(const std::string& a, const std::string& b);

// 360 degrees in the unit of a geographic CRS; empty for others.
std::optional<double> FullTurnOf(const std::string& definition);

// Throws InputError naming `origin` where the definition has heights that are not in metres, or
// depths. One without heights says nothing about them.
void RequireHeightsInMetres(const std::string& definition, const std::string& origin);

// Horizontal coordinates of one CRS in another, always in the order x (east, longitude), y (north,
// latitude), in each CRS's own unit. Not thread-safe: one object per thread.
class CoordinateTransform {
 public:
  CoordinateTransform(const Crs& target, const Crs& source);  // throws InputError: no such path
  // The same for any two definitions: a raster may be geographic (degrees), a Crs may not.
  static CoordinateTransform Between(const std::string& target_definition,
                                     const std::string& source_definition);
  ~CoordinateTransform();
  CoordinateTransform(CoordinateTransform&&) noexcept;
  CoordinateTransform& operator=(CoordinateTransform&&) noexcept;

  // target_from_source for (x, y); empty where the transform is not defined.
  std::optional<Eigen::Vector2d> operator()(const Eigen::Vector2d& xy) const;

 private:
  struct Impl;
  explicit CoordinateTransform(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace orient

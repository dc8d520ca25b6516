// Small DEM files for tests: an ASCII grid with a VRT that gives it any CRS, unit and nodata value.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

namespace orient {

struct DemFile {
  Eigen::MatrixXf heights;  // NaN is written as nodata
  double west = 0, north = 0;
  double cell_x = 1, cell_y = 1;
  std::string srs = "EPSG:32635";  // empty: none
  std::string unit = "m";
  bool georeferenced = true;
};

// Writes <stem>.asc and <stem>.vrt; returns the path of the VRT.
inline std::string WriteDem(const std::string& stem, const DemFile& dem) {
  constexpr float kNodata = -9999;
  std::ofstream grid(stem + ".asc");
  grid << "ncols " << dem.heights.cols() << "\nnrows " << dem.heights.rows()
       << "\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value " << kNodata << "\n";
  grid.precision(9);
  for (Eigen::Index row = 0; row < dem.heights.rows(); ++row) {
    for (Eigen::Index col = 0; col < dem.heights.cols(); ++col)
      grid << (std::isfinite(dem.heights(row, col)) ? dem.heights(row, col) : kNodata) << ' ';
    grid << '\n';
  }
  std::ofstream vrt(stem + ".vrt");
  vrt.precision(17);
  vrt << "<VRTDataset rasterXSize=\"" << dem.heights.cols() << "\" rasterYSize=\""
      << dem.heights.rows() << "\">\n";
  if (!dem.srs.empty()) vrt << "<SRS>" << dem.srs << "</SRS>\n";
  if (dem.georeferenced)
    vrt << "<GeoTransform>" << dem.west << ", " << dem.cell_x << ", 0, " << dem.north << ", 0, "
        << -dem.cell_y << "</GeoTransform>\n";
  vrt << "<VRTRasterBand dataType=\"Float32\" band=\"1\"><NoDataValue>" << kNodata
      << "</NoDataValue><UnitType>" << dem.unit << "</UnitType><SimpleSource><SourceFilename>"
      << stem << ".asc</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>\n"
      << "</VRTDataset>\n";
  return stem + ".vrt";
}

}  // namespace orient

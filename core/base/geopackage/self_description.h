// What a GeoPackage says of itself to the programs that open it: styles, and metadata.
//
// As SQL, since one of our GeoPackages is written through GDAL and another through SQLite.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace orient {

// How QGIS draws a layer that nobody has given another style.
struct LayerStyle {
  std::string layer;        // its geometry column is `geom`
  std::string qml;          // as QGIS saves styles
  std::string description;  // shown beside the style's name, "orient"
};

// Statements, to be run in their order within one transaction. They make the tables where they are
// not there and leave those, and styles of the same layers, that are. Texts are UTF-8.

// Table layer_styles, which QGIS reads by itself.
std::vector<std::string> StatementsOfStyles(const std::vector<LayerStyle>& styles);

// Items of the file's metadata (gpkg_metadata) as GDAL writes and reads them. No time of day is in
// it: the same items give the same rows. Without items there are no statements.
std::vector<std::string> StatementsOfMetadata(const std::map<std::string, std::string>& items);

// Whether a table is one of those that these statements make.
bool IsOfSelfDescription(const std::string& table);

}  // namespace orient

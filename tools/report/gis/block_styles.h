// How block.gpkg looks in QGIS: its table layer_styles.
#pragma once

#include "tools/report/gis/new_geopackage.h"

namespace orient {

// A default style for each layer of block.gpkg, data/report/<layer>.qml: photos and footprints by
// status, patches by state, residuals as arrows. Other programs pass the table over.
void WriteStyles(bool with_ties, NewGeopackage* file);

}  // namespace orient

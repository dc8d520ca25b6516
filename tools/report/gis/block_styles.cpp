#include "tools/report/gis/block_styles.h"

#include <string>
#include <vector>

#include "core/base/geopackage/self_description.h"
#include "tools/report/template.h"

namespace orient {

void WriteStyles(bool with_ties, NewGeopackage* file) {
  std::vector<LayerStyle> styles;
  for (const std::string layer : {"photos", "footprints", "patches", "residuals", "ties"})
    if (layer != "ties" || with_ties)
      styles.push_back({layer, std::string(ReportFile(layer + ".qml")), "as in report.html"});
  file->Execute(StatementsOfStyles(styles));
}

}  // namespace orient

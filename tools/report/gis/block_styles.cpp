#include "tools/report/gis/block_styles.h"

#include <string>

#include "tools/report/template.h"

namespace orient {

void WriteStyles(bool with_ties, NewGeopackage* file) {
  NewLayer layer = file->AddLayer("layer_styles", wkbNone, "Styles that QGIS reads",
                                  {{"f_table_catalog", OFTString},
                                   {"f_table_schema", OFTString},
                                   {"f_table_name", OFTString},
                                   {"f_geometry_column", OFTString},
                                   {"styleName", OFTString},
                                   {"styleQML", OFTString},
                                   {"styleSLD", OFTString},
                                   {"useAsDefault", OFTInteger},
                                   {"description", OFTString},
                                   {"owner", OFTString},
                                   {"update_time", OFTDateTime}});
  for (const std::string table : {"photos", "footprints", "patches", "residuals", "ties"}) {
    if (table == "ties" && !with_ties) continue;
    NewLayer::Row row = layer.NewRow();
    for (const char* field : {"f_table_catalog", "f_table_schema", "styleSLD", "owner"})
      row.Set(field, std::string());
    row.Set("f_table_name", table);
    row.Set("f_geometry_column", std::string("geom"));
    row.Set("styleName", std::string("orient"));
    row.Set("styleQML", std::string(ReportFile(table + ".qml")));
    row.SetInteger("useAsDefault", 1);
    row.Set("description", std::string("as in report.html"));
    layer.Write(std::move(row));
  }
}

}  // namespace orient

#include "tools/block_styles.h"

#include <string>
#include <vector>

namespace orient {
namespace {

// Colours of the report: as "r,g,b,a".
constexpr const char* kOk = "44,122,87,255";
constexpr const char* kWeak = "168,106,0,255";
constexpr const char* kFailed = "179,54,43,255";
constexpr const char* kMatched = "31,98,173,255";
constexpr const char* kRejected = "192,45,134,255";
constexpr const char* kMissed = "141,151,163,255";

std::string Option(const char* name, const std::string& value) {
  return "<Option type=\"QString\" name=\"" + std::string(name) + "\" value=\"" + value + "\"/>";
}

// One symbol layer of class `kind` with its properties.
std::string Symbol(const char* type, const std::string& name, const char* kind,
                   const std::string& options) {
  return "<symbol type=\"" + std::string(type) + "\" name=\"" + name +
         "\" alpha=\"1\" clip_to_extent=\"1\" force_rhr=\"0\"><layer class=\"" + kind +
         "\" enabled=\"1\" locked=\"0\" pass=\"0\"><Option type=\"Map\">" + options +
         "</Option></layer></symbol>";
}

std::string Marker(const std::string& name, const char* shape, const char* colour, double size_mm) {
  return Symbol("marker", name, "SimpleMarker",
                Option("name", shape) + Option("color", colour) + Option("outline_color", colour) +
                    Option("size", std::to_string(size_mm)) + Option("size_unit", "MM"));
}

std::string Arrow(const std::string& name, const char* colour) {
  const std::string head = "<symbol type=\"fill\" name=\"@" + name +
                           "@0\" alpha=\"1\"><layer class=\"SimpleFill\" enabled=\"1\" pass=\"0\">"
                           "<Option type=\"Map\">" +
                           Option("color", colour) + Option("outline_style", "no") +
                           Option("style", "solid") + "</Option></layer></symbol>";
  std::string arrow = Symbol("line", name, "ArrowLine",
                             Option("arrow_width", "0.3") + Option("arrow_start_width", "0.3") +
                                 Option("head_length", "1.2") + Option("head_thickness", "0.8") +
                                 Option("head_type", "0") + Option("arrow_type", "0") +
                                 Option("is_curved", "0") + Option("is_repeated", "0"));
  const std::string end = "</layer></symbol>";
  arrow.insert(arrow.size() - end.size(), head);
  return arrow;
}

std::string Outline(const std::string& name, const char* colour) {
  return Symbol("fill", name, "SimpleFill",
                Option("style", "no") + Option("outline_color", colour) +
                    Option("outline_style", "solid") + Option("outline_width", "0.4") +
                    Option("outline_width_unit", "MM"));
}

struct Category {
  const char* value;  // "" : every other one
  std::string symbol;
};

std::string Style(const std::string& renderer) {
  return "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n"
         "<qgis version=\"3.22\" styleCategories=\"Symbology\">" +
         renderer + "</qgis>";
}

// Symbols are named "0", "1", ... in the order of the categories.
std::string ByCategory(const char* attribute, const std::vector<Category>& categories) {
  std::string values, symbols;
  for (std::size_t i = 0; i < categories.size(); ++i) {
    const std::string value = categories[i].value;
    values += "<category symbol=\"" + std::to_string(i) + "\" value=\"" + value + "\" label=\"" +
              (value.empty() ? "other" : value) + "\" render=\"true\"/>";
    symbols += categories[i].symbol;
  }
  return Style("<renderer-v2 type=\"categorizedSymbol\" attr=\"" + std::string(attribute) +
               "\" symbollevels=\"0\" enableorderby=\"0\" forceraster=\"0\"><categories>" + values +
               "</categories><symbols>" + symbols + "</symbols></renderer-v2>");
}

std::string One(const std::string& symbol) {
  return Style(
      "<renderer-v2 type=\"singleSymbol\" symbollevels=\"0\" enableorderby=\"0\" "
      "forceraster=\"0\"><symbols>" +
      symbol + "</symbols></renderer-v2>");
}

std::string PhotosStyle() {
  return ByCategory("status", {{"ok", Marker("0", "cross", kOk, 4)},
                               {"weak", Marker("1", "cross", kWeak, 5)},
                               {"failed", Marker("2", "cross", kFailed, 5)}});
}

std::string FootprintsStyle() {
  return ByCategory("status", {{"ok", Outline("0", kOk)},
                               {"weak", Outline("1", kWeak)},
                               {"failed", Outline("2", kFailed)}});
}

std::string PatchesStyle() {
  return ByCategory("state", {{"matched", Marker("0", "circle", kMatched, 1.6)},
                              {"rejected", Marker("1", "cross2", kRejected, 2.2)},
                              {"not_found", Marker("2", "circle", kMissed, 1.2)},
                              {"not_visible", Marker("3", "circle", "211,216,222,255", 0.8)}});
}

// Patches are "matched", ties "used" where they count.
std::string ResidualsStyle() {
  return ByCategory("state", {{"matched", Arrow("0", kMatched)},
                              {"used", Arrow("1", kOk)},
                              {"rejected", Arrow("2", kRejected)},
                              {"", Arrow("3", kMissed)}});
}

}  // namespace

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
  const auto add = [&](const char* table, const std::string& qml) {
    NewLayer::Row row = layer.NewRow();
    for (const char* field : {"f_table_catalog", "f_table_schema", "styleSLD", "owner"})
      row.Set(field, std::string());
    row.Set("f_table_name", std::string(table));
    row.Set("f_geometry_column", std::string("geom"));
    row.Set("styleName", std::string("orient"));
    row.Set("styleQML", qml);
    row.SetInteger("useAsDefault", 1);
    row.Set("description", std::string("as in report.html"));
    layer.Write(std::move(row));
  };
  add("photos", PhotosStyle());
  add("footprints", FootprintsStyle());
  add("patches", PatchesStyle());
  add("residuals", ResidualsStyle());
  if (with_ties) add("ties", One(Marker("0", "triangle", kOk, 1.8)));
}

}  // namespace orient

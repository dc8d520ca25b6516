#include "core/base/geopackage/self_description.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace orient {
namespace {

constexpr std::array<std::string_view, 3> kTables = {"layer_styles", "gpkg_metadata",
                                                     "gpkg_metadata_reference"};

// QGIS's columns; it ignores the styles if one of them is missing.
constexpr const char* kMakeStyles =
    "CREATE TABLE IF NOT EXISTS layer_styles (id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, "
    "f_table_catalog TEXT, f_table_schema TEXT, f_table_name TEXT, f_geometry_column TEXT, "
    "styleName TEXT, styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN, description TEXT, "
    "owner TEXT, ui TEXT, update_time DATETIME)";
constexpr const char* kRegisterStyles =
    "INSERT INTO gpkg_contents (table_name, data_type, identifier, description) SELECT "
    "'layer_styles', 'attributes', 'layer_styles', 'Styles that QGIS reads' WHERE NOT EXISTS "
    "(SELECT 1 FROM gpkg_contents WHERE table_name = 'layer_styles')";

// As GeoPackage 1.3 prints them (annexes F.8 and C).
constexpr const char* kMakeExtensions =
    "CREATE TABLE IF NOT EXISTS gpkg_extensions (table_name TEXT, column_name TEXT, extension_name "
    "TEXT NOT NULL, definition TEXT NOT NULL, scope TEXT NOT NULL, CONSTRAINT ge_tce UNIQUE "
    "(table_name, column_name, extension_name))";
constexpr const char* kMakeMetadata =
    "CREATE TABLE IF NOT EXISTS gpkg_metadata (id INTEGER CONSTRAINT m_pk PRIMARY KEY ASC NOT "
    "NULL, md_scope TEXT NOT NULL DEFAULT 'dataset', md_standard_uri TEXT NOT NULL, mime_type TEXT "
    "NOT NULL DEFAULT 'text/xml', metadata TEXT NOT NULL DEFAULT '')";
constexpr const char* kMakeReferences =
    "CREATE TABLE IF NOT EXISTS gpkg_metadata_reference (reference_scope TEXT NOT NULL, table_name "
    "TEXT, column_name TEXT, row_id_value INTEGER, timestamp DATETIME NOT NULL DEFAULT "
    "(strftime('%Y-%m-%dT%H:%M:%fZ','now')), md_file_id INTEGER NOT NULL, md_parent_id INTEGER, "
    "CONSTRAINT crmr_mfi_fk FOREIGN KEY (md_file_id) REFERENCES gpkg_metadata(id), CONSTRAINT "
    "crmr_mpi_fk FOREIGN KEY (md_parent_id) REFERENCES gpkg_metadata(id))";

std::string Replaced(std::string_view text, std::string_view what, std::string_view by) {
  std::string result;
  for (std::size_t begin = 0;;) {
    const std::size_t at = text.find(what, begin);
    result += text.substr(begin, at - begin);
    if (at == std::string_view::npos) return result;
    result += by;
    begin = at + what.size();
  }
}

// An SQL string literal; `text` ends at its first null character.
std::string Quoted(std::string_view text) {
  return "'" + Replaced(text.substr(0, text.find('\0')), "'", "''") + "'";
}

// For XML content and attributes; control characters, invalid in XML, become blanks.
std::string EscapedForXml(std::string_view text) {
  std::string escaped = Replaced(text, "&", "&amp;");
  escaped = Replaced(escaped, "<", "&lt;");
  escaped = Replaced(escaped, ">", "&gt;");
  escaped = Replaced(escaped, "\"", "&quot;");
  std::replace_if(
      escaped.begin(), escaped.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n'; }, ' ');
  return escaped;
}

std::string RegisterExtension(const std::string& table) {
  return "INSERT INTO gpkg_extensions SELECT '" + table +
         "', NULL, 'gpkg_metadata', 'http://www.geopackage.org/spec120/#extension_metadata', "
         "'read-write' WHERE NOT EXISTS (SELECT 1 FROM gpkg_extensions WHERE table_name = '" +
         table + "')";
}

std::string XmlOf(const std::map<std::string, std::string>& items) {
  std::string xml = "<GDALMultiDomainMetadata>\n  <Metadata>\n";
  for (const auto& [name, text] : items)
    xml += "    <MDI key=\"" + EscapedForXml(name) + "\">" + EscapedForXml(text) + "</MDI>\n";
  return xml + "  </Metadata>\n</GDALMultiDomainMetadata>\n";
}

}  // namespace

std::vector<std::string> StatementsOfStyles(const std::vector<LayerStyle>& styles) {
  std::vector<std::string> statements = {kMakeStyles, kRegisterStyles};
  for (const LayerStyle& style : styles)
    statements.push_back(
        "INSERT INTO layer_styles (f_table_catalog, f_table_schema, f_table_name, "
        "f_geometry_column, styleName, styleQML, styleSLD, useAsDefault, description, owner) "
        "SELECT '', '', " +
        Quoted(style.layer) + ", 'geom', 'orient', " + Quoted(style.qml) + ", '', 1, " +
        Quoted(style.description) +
        ", '' WHERE NOT EXISTS (SELECT 1 FROM layer_styles WHERE f_table_name = " +
        Quoted(style.layer) + ")");
  return statements;
}

std::vector<std::string> StatementsOfMetadata(const std::map<std::string, std::string>& items) {
  if (items.empty()) return {};
  const std::string xml = Quoted(XmlOf(items));
  return {kMakeExtensions,
          kMakeMetadata,
          kMakeReferences,
          RegisterExtension("gpkg_metadata"),
          RegisterExtension("gpkg_metadata_reference"),
          "INSERT INTO gpkg_metadata (md_scope, md_standard_uri, mime_type, metadata) SELECT "
          "'dataset', 'http://gdal.org', 'text/xml', " +
              xml + " WHERE NOT EXISTS (SELECT 1 FROM gpkg_metadata WHERE metadata = " + xml + ")",
          "INSERT INTO gpkg_metadata_reference (reference_scope, timestamp, md_file_id) SELECT "
          "'geopackage', '1970-01-01T00:00:00.000Z', id FROM gpkg_metadata WHERE metadata = " +
              xml + " AND id NOT IN (SELECT md_file_id FROM gpkg_metadata_reference)"};
}

bool IsOfSelfDescription(const std::string& table) {
  return std::find(kTables.begin(), kTables.end(), table) != kTables.end();
}

}  // namespace orient

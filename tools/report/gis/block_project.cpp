#include "tools/report/gis/block_project.h"

#include <cpl_vsi.h>
#include <fmt/format.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <vector>

#include "core/base/atomic_write.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "tools/report/template.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// One layer of the project, topmost first.
struct Layer {
  std::string id, title, source;  // the latter relative to the project
  bool is_raster = false, shown = true;
  std::string style = {};  // file of data/report; empty: QGIS decides
};

struct Contents {
  std::vector<Layer> layers;
  std::string crs;  // WKT
  OGREnvelope extent;
};

// What is within <qgis> of a style file is within <maplayer> of a project.
std::string WithinStyle(const std::string& file) {
  if (file.empty()) return "";
  const std::string text(ReportFile(file));
  const std::size_t root = text.find("<qgis"), begin = text.find('>', root) + 1;
  return text.substr(begin, text.rfind("</qgis>") - begin);
}

struct Table {
  std::string name, title;
  bool shown;
};

// Those that are drawn over others come first.
const std::vector<Table> kTables = {{"photos", "photos", true},
                                    {"residuals", "residuals x 100", false},
                                    {"patches", "patches", true},
                                    {"ties", "tie points", false},
                                    {"footprints", "footprints", true}};

Contents ReadGeopackage(const fs::path& directory) {
  const std::string path = (directory / "block.gpkg").string();
  const QuietGdal quiet;
  const GDALDatasetUniquePtr dataset = OpenVectorDataset(path);
  if (!dataset) throw InputError("cannot read " + path + "; 'orient report' writes it again");
  Contents contents;
  for (const Table& table : kTables) {
    OGRLayer* layer = dataset->GetLayerByName(table.name.c_str());
    if (layer == nullptr) continue;
    contents.layers.push_back({table.name, table.title, "./block.gpkg|layername=" + table.name,
                               false, table.shown, table.name + ".qml"});
    OGREnvelope extent;
    if (layer->GetExtent(&extent) == OGRERR_NONE) contents.extent.Merge(extent);
    if (!contents.crs.empty() || layer->GetSpatialRef() == nullptr) continue;
    char* wkt = nullptr;
    const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
    if (layer->GetSpatialRef()->exportToWkt(&wkt, options) == OGRERR_NONE) contents.crs = wkt;
    CPLFree(wkt);
  }
  quiet.ThrowFaults();
  return contents;
}

// A folder that cannot be listed must not pass for one without orthophotos.
void ThrowIfOfEnvironment(const std::error_code& error, const fs::path& path) {
  if (IsOfEnvironment(error.value()))
    throw EnvironmentError(fmt::format("cannot read {}: {}", path.string(), error.message()));
}

bool IsThere(const fs::path& path) {
  std::error_code error;
  const bool there = fs::exists(path, error);
  ThrowIfOfEnvironment(error, path);
  return there;
}

// The mosaic or, without one, the orthophotos form the background of the map.
void AddOrthophotos(const fs::path& directory, Contents* contents) {
  const fs::path folder = directory / "ortho";
  if (IsThere(folder / "seamlines.gpkg"))
    contents->layers.push_back(
        {"seamlines", "seamlines", "./ortho/seamlines.gpkg|layername=seamlines", false, false});
  const bool mosaic = IsThere(folder / "mosaic.tif");
  if (mosaic) contents->layers.push_back({"mosaic", "mosaic", "./ortho/mosaic.tif", true});
  constexpr std::string_view kEnding = ".ortho.tif";
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const std::string name = entry.path().filename().string(); name.ends_with(kEnding))
      files.push_back(name);
  ThrowIfOfEnvironment(error, folder);
  std::sort(files.begin(), files.end());
  for (std::size_t i = 0; i < files.size(); ++i)
    contents->layers.push_back({fmt::format("ortho_{}", i + 1),
                                files[i].substr(0, files[i].size() - kEnding.size()),
                                "./ortho/" + files[i], true, !mosaic});
}

Markup ProjectText(const std::string& title, const Contents& contents) {
  Markup tree, order, layers;
  for (const Layer& layer : contents.layers) {
    const std::string style = WithinStyle(layer.style);
    const std::string id = "orient_block_" + layer.id;  // QGIS makes others of ten letters or less
    tree += Fill("project.qgs#tree", {{"id", id},
                                      {"title", layer.title},
                                      {"source", layer.source},
                                      {"provider", layer.is_raster ? "gdal" : "ogr"},
                                      {"checked", layer.shown ? "Qt::Checked" : "Qt::Unchecked"}});
    order += Fill("project.qgs#order", {{"id", id}});
    layers += Fill("project.qgs#layer",
                   {{"type", layer.is_raster ? "raster" : "vector"},
                    {"labels", style.find("<labeling") == std::string::npos ? "0" : "1"},
                    {"id", id},
                    {"title", layer.title},
                    {"source", layer.source},
                    {"provider", layer.is_raster ? "gdal" : "ogr"},
                    {"crs", contents.crs},
                    {"style", Markup(style)}});
  }
  const OGREnvelope& extent = contents.extent;
  const auto number = [](double value) { return fmt::format("{:.3f}", value); };
  return Fill("project.qgs", {{"title", title},
                              {"crs", contents.crs},
                              {"tree", tree},
                              {"order", order},
                              {"layers", layers},
                              {"min_x", number(extent.IsInit() ? extent.MinX : 0)},
                              {"min_y", number(extent.IsInit() ? extent.MinY : 0)},
                              {"max_x", number(extent.IsInit() ? extent.MaxX : 1)},
                              {"max_y", number(extent.IsInit() ? extent.MaxY : 1)}});
}

// A zip archive of one file, made in memory.
std::string Zipped(const std::string& name, const std::string& contents, const std::string& path) {
  const std::string archive = fmt::format("/vsimem/{}.zip", fmt::ptr(&contents));
  VSILFILE* file = VSIFOpenL(("/vsizip/" + archive + "/" + name).c_str(), "wb");
  const bool written =
      file != nullptr && VSIFWriteL(contents.data(), 1, contents.size(), file) == contents.size();
  const bool closed = file != nullptr && VSIFCloseL(file) == 0;
  vsi_l_offset size = 0;
  const GByte* bytes = VSIGetMemFileBuffer(archive.c_str(), &size, FALSE);
  std::string zipped;
  if (bytes != nullptr)
    zipped.assign(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
  VSIUnlink(archive.c_str());
  if (!written || !closed || zipped.empty())
    throw InputError("cannot write " + path + ": GDAL makes no zip archive of it");
  return zipped;
}

// A project changed in QGIS belongs to its user: QGIS dates what it saves.
bool WasSavedByQgis(const std::string& path) {
  const QuietGdal quiet;
  VSILFILE* file = VSIFOpenL(("/vsizip/{" + path + "}").c_str(), "rb");
  quiet.ThrowFaults();
  if (file == nullptr) return true;  // not one of ours
  std::string beginning(4096, '\0');
  beginning.resize(VSIFReadL(beginning.data(), 1, beginning.size(), file));
  VSIFCloseL(file);
  quiet.ThrowFaults();
  return beginning.find("saveDateTime") != std::string::npos;
}

}  // namespace

std::string WriteBlockProject(const std::string& directory) {
  const fs::path folder(directory);
  if (!fs::exists(folder / "block.gpkg")) return "";
  Contents contents = ReadGeopackage(folder);
  AddOrthophotos(folder, &contents);
  const std::string path = (folder / "block.qgz").string();
  if (fs::exists(path) && WasSavedByQgis(path)) return "";
  const std::string title = fs::canonical(folder).filename().string();
  WriteFileAtomically(path, Zipped("block.qgs", ProjectText(title, contents).Text(), path));
  return path;
}

}  // namespace orient

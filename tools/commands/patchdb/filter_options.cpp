#include "tools/commands/patchdb/filter_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/base/date.h"
#include "core/base/error.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"

namespace orient {
namespace {

using Ring = std::vector<Eigen::Vector2d>;

void AddRing(const OGRLinearRing* ring, std::vector<Ring>* rings) {
  Ring points;
  for (int i = 0; i < ring->getNumPoints(); ++i) points.emplace_back(ring->getX(i), ring->getY(i));
  if (points.size() >= 3) rings->push_back(points);
}

void AddPolygons(const OGRGeometry* geometry, std::vector<Ring>* rings) {
  if (geometry == nullptr) return;
  const auto type = wkbFlatten(geometry->getGeometryType());
  if (type == wkbPolygon) {
    const OGRPolygon* polygon = geometry->toPolygon();
    if (polygon->getExteriorRing() == nullptr) return;
    AddRing(polygon->getExteriorRing(), rings);
    for (int i = 0; i < polygon->getNumInteriorRings(); ++i)
      AddRing(polygon->getInteriorRing(i), rings);
  } else if (type == wkbMultiPolygon || type == wkbGeometryCollection) {
    for (const OGRGeometry* part : *geometry->toGeometryCollection()) AddPolygons(part, rings);
  }
}

void ToCrs(const std::string& definition, const Crs& crs, const std::string& path,
           std::vector<Ring>* rings) {
  if (SameHorizontalCrs(definition, crs.Wkt())) return;
  const auto transform = CoordinateTransform::Between(crs.Wkt(), definition);
  for (Ring& ring : *rings)
    for (Eigen::Vector2d& point : ring) {
      const auto there = transform(point);
      if (!there) throw InputError(path + ": its polygon cannot be transformed to " + crs.Name());
      point = *there;
    }
}

// Throws InputError where no patch has one of these numbers.
void RequireThere(const patchdb::PatchDatabase& database, const std::vector<std::int64_t>& ids) {
  if (ids.empty()) return;
  patchdb::PatchFilter these;
  these.ids = ids;
  std::vector<std::int64_t> absent = ids;
  for (const std::int64_t id : patchdb::ChooseIds(database, these)) std::erase(absent, id);
  if (!absent.empty())
    throw InputError(fmt::format("{} has no patch {}; 'orient patchdb list' has their numbers",
                                 database.Path(), fmt::join(absent, ", ")));
}

std::string WktOf(const OGRSpatialReference& crs) {
  char* text = nullptr;
  const char* const options[] = {"FORMAT=WKT2_2018", nullptr};
  crs.exportToWkt(&text, options);
  const std::string wkt = text == nullptr ? "" : text;
  CPLFree(text);
  return wkt;
}

}  // namespace

std::vector<Ring> ReadPolygon(const std::string& path, const Crs& crs) {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  const GDALDatasetUniquePtr file = OpenVectorDataset(path);
  if (file == nullptr)
    throw InputError(path + " cannot be read as polygons" + quiet.Message() +
                     "; give a file of a vector format that GDAL reads");
  std::vector<Ring> rings;
  for (OGRLayer* layer : file->GetLayers()) {
    std::vector<Ring> found;
    for (const auto& feature : *layer) AddPolygons(feature->GetGeometryRef(), &found);
    // Without a CRS of its own it is taken to be in the database's.
    if (layer->GetSpatialRef() != nullptr) ToCrs(WktOf(*layer->GetSpatialRef()), crs, path, &found);
    rings.insert(rings.end(), found.begin(), found.end());
  }
  quiet.ThrowFaults();
  if (rings.empty()) throw InputError(path + " holds no polygon");
  return rings;
}

void FilterOptions::DeclarePlace(CLI::App& app) {
  app.add_option("--box", box_, "Within west south east north, in the database's CRS")
      ->expected(4)
      ->delimiter(',');
  app.add_option("--polygon", polygon_, "Within the polygons of a vector file (any CRS)");
}

void FilterOptions::DeclareState(CLI::App& app) {
  app.add_option("--state", state_, "State of the patches")
      ->check(CLI::IsMember({"active", "retired", "all"}));
}

void FilterOptions::DeclareRules(CLI::App& app) {
  app.add_option("--id", ids_, "These patches, by number")->delimiter(',');
  app.add_option("--source", source_, "Cut from the source of this name");
  app.add_option("--max-quality", max_quality_, "Quality below this (0 .. 1)")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--max-success", max_success_,
                 "Expected to succeed in less than this share of attempts (0 .. 1)")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--min-failures", min_failures_, "At least this many failed attempts (weighted)");
  app.add_option("--older-than", older_than_, "Source taken before this date (ISO 8601)")
      ->check(DateProblem);
}

void FilterOptions::DeclareRetired(CLI::App& app) {
  app.add_option("--retired-before", retired_before_, "Retired before this date (ISO 8601)")
      ->check(DateProblem);
}

patchdb::PatchFilter FilterOptions::Filter(const patchdb::PatchDatabase& database,
                                           AbsentIds absent) const {
  patchdb::PatchFilter filter;
  if (!box_.empty()) {
    if (!std::all_of(box_.begin(), box_.end(), [](double value) { return std::isfinite(value); }))
      throw UsageError("--box needs four numbers: west south east north");
    filter.bounds = Bounds{box_[0], box_[1], box_[2], box_[3]};
    if (filter.bounds->Empty())
      throw UsageError("--box is empty; give west south east north in that order");
  }
  if (!polygon_.empty()) filter.polygon = ReadPolygon(polygon_, database.GroundCrs());
  if (state_ != "all")
    filter.life = state_ == "active" ? patchdb::PatchLife::kActive : patchdb::PatchLife::kRetired;
  if (absent == AbsentIds::kRefuse) RequireThere(database, ids_);
  filter.ids = ids_;
  filter.source = source_;
  filter.quality_below = max_quality_;
  filter.success_below = max_success_;
  filter.min_failures = min_failures_;
  filter.older_than = older_than_;
  filter.retired_before = retired_before_;
  return filter;
}

}  // namespace orient

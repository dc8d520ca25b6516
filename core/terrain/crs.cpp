#include "core/terrain/crs.h"

#include <fmt/format.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/quiet_gdal.h"
#include "core/base/trimmed.h"

namespace orient {
namespace {

std::string Quoted(const std::string& text) {
  constexpr std::size_t kLongest = 80;
  std::string quoted = "'";
  quoted.append(text, 0, kLongest);
  if (text.size() > kLongest) quoted.append("...");
  return quoted.append("'");
}

// With x east, y north. Never reads a file or the network.
std::optional<OGRSpatialReference> UnderstandWhole(const std::string& definition) {
  OGRSpatialReference crs;
  if (crs.SetFromUserInput(definition.c_str(),
                           OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get()) !=
      OGRERR_NONE) {
    ThrowIfOutOfResources();  // PROJ reads a database of its own
    return std::nullopt;
  }
  crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return crs;
}

std::optional<OGRSpatialReference> Understand(const std::string& definition) {
  auto crs = UnderstandWhole(definition);
  if (!crs) return crs;
  crs->StripVertical();
  if (crs->GetAxesCount() == 3) crs->DemoteTo2D(nullptr);  // with heights above the ellipsoid
  return crs;
}

OGRSpatialReference Known(const std::string& wkt) {
  const QuietGdal quiet;
  auto crs = Understand(wkt);
  if (!crs) throw InputError("the CRS " + Quoted(wkt) + " is not understood" + quiet.Message());
  return *crs;
}

// East and north in either order; near a pole, where both axes point north (or south), by name.
bool IsEastNorth(const OGRSpatialReference& crs) {
  OGRAxisOrientation first = OAO_Other, second = OAO_Other;
  const char* first_name = crs.GetAxis(nullptr, 0, &first);
  const char* second_name = crs.GetAxis(nullptr, 1, &second);
  if (first_name == nullptr || second_name == nullptr) return false;
  if ((first == OAO_East && second == OAO_North) || (first == OAO_North && second == OAO_East))
    return true;
  const bool polar = first == second && (first == OAO_North || first == OAO_South);
  return polar && std::string(first_name).find("asting") != std::string::npos &&
         std::string(second_name).find("orthing") != std::string::npos;
}

std::string Exported(const OGRSpatialReference& crs, const char* format) {
  const QuietGdal quiet;
  const std::string option = std::string("FORMAT=") + format;
  // Heights above the ellipsoid are a third axis; WKT 1 knows such heights only by themselves.
  const char* const options[] = {option.c_str(), "ALLOW_ELLIPSOIDAL_HEIGHT_AS_VERTICAL_CRS=YES",
                                 nullptr};
  char* text = nullptr;
  const bool ok = crs.exportToWkt(&text, options) == OGRERR_NONE && text != nullptr;
  const std::string wkt = ok ? text : "";
  CPLFree(text);
  if (!ok)
    throw InputError("the CRS cannot be written as " + std::string(format) + quiet.Message());
  return wkt;
}

struct HeightUnit {
  std::string name;
  double metres = 1;
};

// Of a vertical CRS, or of heights above the ellipsoid as a third axis; WKT 1 knows these only by
// themselves, and tells their unit. Empty where the CRS has no heights.
std::optional<HeightUnit> UnitOfHeights(const OGRSpatialReference& crs) {
  if (crs.IsVertical() == 0 && crs.GetAxesCount() != 3) return std::nullopt;
  const std::string wkt = Exported(crs, "WKT1_GDAL");
  const char* text = wkt.c_str();
  OGR_SRSNode root;
  if (root.importFromWkt(&text) != OGRERR_NONE) return std::nullopt;
  const OGR_SRSNode* heights = root.GetNode("VERT_CS");
  const int unit = heights == nullptr ? -1 : heights->FindChild("UNIT");
  if (unit < 0 || heights->GetChild(unit)->GetChildCount() < 2) return std::nullopt;
  return HeightUnit{heights->GetChild(unit)->GetChild(0)->GetValue(),
                    CPLAtof(heights->GetChild(unit)->GetChild(1)->GetValue())};
}

}  // namespace

Crs Crs::Parse(const std::string& definition, const std::string& origin) {
  const QuietGdal quiet;
  const std::string text(Trimmed(definition));
  const auto crs = text.empty() ? std::nullopt : Understand(text);
  const std::string what = origin + ": the CRS " + Quoted(text);
  const std::string remedy = "; give a projected CRS in metres, for example EPSG:32635";
  if (!crs) throw InputError(what + " is not understood" + quiet.Message() + remedy);
  if (crs->IsGeographic()) throw InputError(what + " is geographic (degrees)" + remedy);
  if (!crs->IsProjected()) throw InputError(what + " is not projected" + remedy);
  const char* unit = nullptr;
  const double metres = crs->GetLinearUnits(&unit);
  if (std::abs(metres - 1) > 1e-12)
    throw InputError(fmt::format("{} is in '{}', not in metres{}", what,
                                 unit == nullptr ? "unknown unit" : unit, remedy));
  if (!IsEastNorth(*crs)) throw InputError(what + " has axes other than east and north" + remedy);
  return Crs(Exported(*crs, "WKT2_2019"));
}

Crs Crs::FromFile(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError(path + ": there is no file with the CRS; write its WKT or EPSG code there");
  return Parse(ReadFile(path), path);
}

std::string Crs::Wkt1() const { return Exported(Known(wkt_), "WKT1_GDAL"); }

std::string Crs::Name() const {
  const OGRSpatialReference crs = Known(wkt_);
  const char* given = crs.GetName();
  const std::string name = given == nullptr ? "" : given;
  if (!name.empty() && name != "unknown" && name != "unnamed") return name;
  const QuietGdal quiet;
  char* text = nullptr;
  const bool ok = crs.exportToProj4(&text) == OGRERR_NONE && text != nullptr;
  const std::string proj(ok ? Trimmed(text) : "");
  CPLFree(text);
  return proj.empty() ? name : proj.substr(0, proj.find(" +no_defs"));
}

std::optional<int> Crs::Epsg() const {
  OGRSpatialReference crs = Known(wkt_);
  const QuietGdal quiet;
  if (crs.GetAuthorityCode(nullptr) == nullptr) crs.AutoIdentifyEPSG();
  const char* authority = crs.GetAuthorityName(nullptr);
  const char* code = crs.GetAuthorityCode(nullptr);
  if (authority == nullptr || code == nullptr || std::string(authority) != "EPSG")
    return std::nullopt;
  return std::atoi(code);
}

std::optional<double> FullTurnOf(const std::string& definition) {
  const QuietGdal quiet;
  const auto crs = Understand(definition);
  if (!crs || !crs->IsGeographic() || !(crs->GetAngularUnits() > 0)) return std::nullopt;
  return 2 * std::numbers::pi / crs->GetAngularUnits();
}

void RequireHeightsInMetres(const std::string& definition, const std::string& origin) {
  const QuietGdal quiet;
  const auto crs = UnderstandWhole(definition);
  if (!crs) return;
  const std::optional<HeightUnit> unit = UnitOfHeights(*crs);
  if (unit && std::abs(unit->metres - 1) > 1e-12)
    throw InputError(
        fmt::format("{}: the heights of the CRS {} are in '{}', not in metres; convert "
                    "them, and write the CRS without them (gdal_edit.py -a_srs)",
                    origin, Quoted(crs->GetName()), unit->name));
  if (crs->IsVertical() == 0) return;
  OGRAxisOrientation orientation = OAO_Up;
  crs->GetAxis("VERT_CS", 0, &orientation);
  if (orientation == OAO_Down)
    throw InputError(
        fmt::format("{}: the CRS {} counts depths, downwards; convert them to heights, "
                    "and write the CRS without them (gdal_edit.py -a_srs)",
                    origin, Quoted(crs->GetName())));
}

bool Crs::SameAs(const Crs& other) const { return SameHorizontalCrs(wkt_, other.wkt_); }

bool SameHorizontalCrs(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const OGRSpatialReference crs_a = Known(a), crs_b = Known(b);
  const QuietGdal quiet;
  const char* const options[] = {"CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS",
                                 "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", nullptr};
  return crs_a.IsSame(&crs_b, options) != 0;
}

struct CoordinateTransform::Impl {
  std::unique_ptr<OGRCoordinateTransformation> transform;
};

CoordinateTransform::CoordinateTransform(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

CoordinateTransform::CoordinateTransform(const Crs& target, const Crs& source)
    : CoordinateTransform(Between(target.Wkt(), source.Wkt())) {}

CoordinateTransform CoordinateTransform::Between(const std::string& target_definition,
                                                 const std::string& source_definition) {
  const OGRSpatialReference target = Known(target_definition), source = Known(source_definition);
  const QuietGdal quiet;
  auto impl = std::make_unique<Impl>();
  impl->transform.reset(OGRCreateCoordinateTransformation(&source, &target));
  if (!impl->transform) ThrowIfOutOfResources();
  if (!impl->transform)
    throw InputError("there is no transform from the CRS " + Quoted(source.GetName()) + " to " +
                     Quoted(target.GetName()) + quiet.Message());
  return CoordinateTransform(std::move(impl));
}

CoordinateTransform::~CoordinateTransform() = default;
CoordinateTransform::CoordinateTransform(CoordinateTransform&&) noexcept = default;
CoordinateTransform& CoordinateTransform::operator=(CoordinateTransform&&) noexcept = default;

std::optional<Eigen::Vector2d> CoordinateTransform::operator()(const Eigen::Vector2d& xy) const {
  if (!xy.allFinite()) return std::nullopt;
  const QuietGdal quiet;
  double x = xy.x(), y = xy.y();
  int success = 0;
  impl_->transform->Transform(1, &x, &y, nullptr, &success);
  if (success == 0 || !std::isfinite(x) || !std::isfinite(y)) return std::nullopt;
  return Eigen::Vector2d(x, y);
}

}  // namespace orient

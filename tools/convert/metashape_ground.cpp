#include "tools/convert/metashape_ground.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "core/terrain/crs.h"
#include "core/terrain/geocentric.h"

namespace orient {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d CentreOf(const MetashapeChunk& chunk, const MetashapeCamera& camera) {
  const Vector3d local = camera.transform.block<3, 1>(0, 3);
  return chunk.scale * (chunk.rotation * local) + chunk.translation;
}

Vector3d OnTheEllipsoid(double longitude_rad, double latitude_rad) {
  return GeocentricFromGeodetic({latitude_rad, longitude_rad, 0});
}

// Horizontal distance between a geocentric point and a reference in the chunk's coordinate system.
std::optional<double> PlanDistance(const CoordinateTransform& geographic_from_reference,
                                   const Vector3d& geocentric, const Vector3d& reference) {
  const auto lon_lat = geographic_from_reference(reference.head<2>());
  if (!lon_lat) return std::nullopt;
  const Geodetic at = GeodeticFromGeocentric(geocentric);
  return (OnTheEllipsoid(at.longitude_rad, at.latitude_rad) -
          OnTheEllipsoid(RadFromDeg(lon_lat->x()), RadFromDeg(lon_lat->y())))
      .norm();
}

// Empty where PROJ knows nothing of the chunk's coordinate system: then nothing can be compared.
std::optional<CoordinateTransform> GeographicFromReference(const std::string& reference) {
  try {
    return CoordinateTransform::Between("EPSG:4326", reference);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

std::vector<double> PlanDistances(const MetashapeChunk& chunk) {
  std::vector<double> distances;
  std::optional<CoordinateTransform> geographic;
  if (IsGeocentric(chunk)) {
    geographic = GeographicFromReference(chunk.reference);
    if (!geographic) return {};
  }
  for (const MetashapeCamera& camera : chunk.cameras) {
    if (!camera.reference) continue;
    const Vector3d centre = CentreOf(chunk, camera);
    if (!geographic)
      distances.push_back((centre - *camera.reference).head<2>().norm());
    else if (const auto distance = PlanDistance(*geographic, centre, *camera.reference))
      distances.push_back(*distance);
  }
  return distances;
}

std::string Ground(const MetashapeChunk& chunk) {
  return IsGeocentric(chunk) ? "geocentric, as its reference is no local system"
                             : "the block's own coordinates, as its reference is a local system";
}

void RequireTransform(const MetashapeChunk& chunk, const std::string& file) {
  if (chunk.placed || !IsGeocentric(chunk)) return;
  throw InputError(file + ": the chunk has no transform: where its cameras lie on the earth is " +
                   "not known; georeference it in Metashape and export its cameras again");
}

void NoteLeftOut(const MetashapeChunk& chunk, std::vector<std::string>* notes) {
  if (chunk.other_chunks > 0)
    notes->push_back(fmt::format("the first of {} chunks was read; export the others one by one",
                                 chunk.other_chunks + 1));
  const auto left_out = [&](std::size_t cameras, const char* why) {
    if (cameras > 0) notes->push_back(fmt::format("cameras left out: {} {}", cameras, why));
  };
  left_out(chunk.disabled, "disabled");
  left_out(chunk.not_aligned, "not aligned");
  left_out(chunk.of_other_components, "of other components than the active one");
}

}  // namespace

std::optional<MetashapeReferenceFit> FitToReferences(const MetashapeChunk& chunk) {
  constexpr double kFarAway_m = 50;
  // References of a geocentric chunk may themselves be geocentric, without horizontal coordinates.
  if (chunk.reference.starts_with("GEOCCS")) return std::nullopt;
  std::vector<double> distances = PlanDistances(chunk);
  if (distances.empty()) return std::nullopt;
  const auto middle = distances.begin() + std::ssize(distances) / 2;
  std::nth_element(distances.begin(), middle, distances.end());
  return MetashapeReferenceFit{distances.size(), *middle,
                               std::max(kFarAway_m, 3 * chunk.accuracy_m)};
}

std::vector<std::string> NotesOnMetashape(const MetashapeChunk& chunk, const std::string& file) {
  RequireTransform(chunk, file);
  std::vector<std::string> notes;
  NoteLeftOut(chunk, &notes);
  const std::string taken = "the chunk's system is taken for " + Ground(chunk);
  const auto fit = FitToReferences(chunk);
  if (!fit) {
    notes.push_back(taken + "; it has no camera references to compare the poses with");
    return notes;
  }
  if (!(fit->median_m <= fit->bound_m))
    throw InputError(fmt::format(
        "{}: {}, but then the median difference in plan between {} cameras and their <reference> "
        "is {:.0f} m: poses and references are not of one system; update the chunk's transform in "
        "Metashape and export its cameras again, or disable references that are wrong",
        file, taken, fit->cameras, fit->median_m));
  notes.push_back(
      fmt::format("{}: its cameras lie {:.1f} m from their references in plan (median of {})",
                  taken, fit->median_m, fit->cameras));
  return notes;
}

}  // namespace orient

#include "tools/report/gis/block_geopackage.h"

#include <ogrsf_frmts.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "core/base/geopackage/self_description.h"
#include "core/base/quiet_gdal.h"
#include "tools/report/gis/block_styles.h"
#include "tools/report/gis/new_geopackage.h"
#include "tools/report/html_text.h"
#include "tools/report/run_record.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

OGRPoint Point(const Eigen::Vector3d& p) { return OGRPoint(p.x(), p.y(), p.z()); }

std::optional<double> Component(const std::optional<Eigen::Vector2d>& vector, int i) {
  if (!vector) return std::nullopt;
  return (*vector)[i];
}

void WritePose(const ExteriorResult& result, NewLayer::Row* row) {
  constexpr const char* kAngles[] = {"omega", "phi", "kappa"};
  constexpr const char* kSigmas[] = {"sigma_x",     "sigma_y",   "sigma_z",
                                     "sigma_omega", "sigma_phi", "sigma_kappa"};
  if (result.pose) {
    row->SetGeometry(Point(result.pose->position_m));
    for (int i = 0; i < 3; ++i)
      row->Set(kAngles[i], DegFromRad(NormalizeAngle(result.pose->opk_rad[i])));
  }
  for (int i = 0; result.covariance && i < 6; ++i) {
    const double sigma = std::sqrt(std::max(0.0, (*result.covariance)(i, i)));
    row->Set(kSigmas[i], i < 3 ? sigma : DegFromRad(sigma));
  }
}

void WriteOthers(const std::vector<PhotoWithoutResult>& photos, NewLayer* layer) {
  for (const PhotoWithoutResult& photo : photos) {
    NewLayer::Row row = layer->NewRow();
    row.Set("name", photo.name);
    row.Set("status", std::string(Name(photo.status)));
    row.Set("message", photo.message);
    layer->Write(std::move(row));
  }
}

void WritePhotos(const fs::path& directory, const std::vector<ExteriorResult>& results,
                 const std::vector<PhotoWithoutResult>& others, NewGeopackage* file) {
  NewLayer layer = file->AddLayer("photos", wkbPoint25D, "Projection centres",
                                  {{"name", OFTString},
                                   {"status", OFTString},
                                   {"omega", OFTReal},
                                   {"phi", OFTReal},
                                   {"kappa", OFTReal},
                                   {"sigma_x", OFTReal},
                                   {"sigma_y", OFTReal},
                                   {"sigma_z", OFTReal},
                                   {"sigma_omega", OFTReal},
                                   {"sigma_phi", OFTReal},
                                   {"sigma_kappa", OFTReal},
                                   {"sigma0_px", OFTReal},
                                   {"matched", OFTInteger},
                                   {"searched", OFTInteger},
                                   {"message", OFTString},
                                   {"picture", OFTString}});
  for (const ExteriorResult& result : results) {
    std::int64_t matched = 0, searched = 0;
    for (const PatchResult& patch : result.patches) {
      matched += patch.state == PatchState::kMatched;
      searched += patch.state != PatchState::kNotVisible;
    }
    NewLayer::Row row = layer.NewRow();
    WritePose(result, &row);
    row.Set("name", result.photo);
    row.Set("status", std::string(Name(result.status)));
    row.Set("sigma0_px", result.sigma0_px);
    row.SetInteger("matched", matched);
    row.SetInteger("searched", searched);
    row.Set("message", JoinedSentences(result.findings));
    const std::string picture = result.photo + ".patches.png";
    if (fs::exists(directory / picture)) row.Set("picture", picture);
    layer.Write(std::move(row));
  }
  WriteOthers(others, &layer);
}

void WriteFootprints(const std::vector<ExteriorResult>& results, NewGeopackage* file) {
  NewLayer layer = file->AddLayer("footprints", wkbPolygon, "Outlines of the frames on the ground",
                                  {{"name", OFTString}, {"status", OFTString}});
  for (const ExteriorResult& result : results) {
    if (result.footprint_m.size() < 3) continue;
    OGRLinearRing ring;
    for (const Eigen::Vector3d& corner : result.footprint_m) ring.addPoint(corner.x(), corner.y());
    ring.closeRings();
    OGRPolygon polygon;
    polygon.addRing(&ring);
    NewLayer::Row row = layer.NewRow();
    row.SetGeometry(polygon);
    row.Set("name", result.photo);
    row.Set("status", std::string(Name(result.status)));
    layer.Write(std::move(row));
  }
}

void WritePatches(const std::vector<ExteriorResult>& results, NewGeopackage* file) {
  NewLayer layer = file->AddLayer("patches", wkbPoint25D, "Patches as each photo found them",
                                  {{"patch", OFTInteger64},
                                   {"photo", OFTString},
                                   {"state", OFTString},
                                   {"ncc", OFTReal},
                                   {"residual_col_px", OFTReal},
                                   {"residual_row_px", OFTReal},
                                   {"sigma_col_px", OFTReal},
                                   {"sigma_row_px", OFTReal},
                                   {"reason", OFTString}});
  for (const ExteriorResult& result : results)
    for (const PatchResult& patch : result.patches) {
      if (patch.state == PatchState::kNotVisible) continue;  // most of them, drawn over the others
      NewLayer::Row row = layer.NewRow();
      if (patch.ground_m) row.SetGeometry(Point(*patch.ground_m));
      row.SetInteger("patch", patch.id);
      row.Set("photo", result.photo);
      row.Set("state", std::string(Name(patch.state)));
      row.Set("ncc", patch.ncc);
      row.Set("residual_col_px", Component(patch.residual_px, 0));
      row.Set("residual_row_px", Component(patch.residual_px, 1));
      row.Set("sigma_col_px", Component(patch.sigma_px, 0));
      row.Set("sigma_row_px", Component(patch.sigma_px, 1));
      row.Set("reason", JoinedSentences(patch.findings));
      layer.Write(std::move(row));
    }
}

// Measured pixels and the ground that they show, photo by photo.
using GroundPairs = std::map<std::string, std::vector<PointPair2d>>;

GroundPairs PairsOf(const std::vector<ExteriorResult>& results, const AdjustmentResult* adjusted) {
  GroundPairs pairs;
  for (const ExteriorResult& result : results)
    for (const PatchResult& patch : result.patches)
      if (patch.state == PatchState::kMatched && patch.ground_m && patch.pixel)
        pairs[result.photo].push_back({*patch.pixel, patch.ground_m->head<2>(), 1.0});
  if (adjusted == nullptr) return pairs;
  for (const PointResult& tie : adjusted->ties)
    for (const SightingResult& sighting : tie.seen)
      if (tie.ground_m && sighting.state == "used")
        pairs[sighting.photo].push_back({sighting.pixel, tie.ground_m->head<2>(), 1.0});
  return pairs;
}

// The linear part of ground_from_pixel [m per px] that a photo's points agree on: enough to turn
// and scale a residual, whatever the relief. Photos with fewer than three points have none.
using GroundScales = std::map<std::string, Eigen::Matrix2d>;

GroundScales ScalesOf(const GroundPairs& pairs) {
  GroundScales scales;
  for (const auto& [photo, points] : pairs)
    if (const auto fit = FitAffine(points)) scales.emplace(photo, fit->transform.A);
  return scales;
}

// The same for every photo of a block, so that lengths can be compared in the map.
constexpr double kExaggeration = 100;

class ResidualLayer {
 public:
  ResidualLayer(NewGeopackage* file, GroundScales scales)
      : scales_(std::move(scales)),
        layer_(file->AddLayer("residuals", wkbLineString, "Residuals on the ground, exaggerated",
                              {{"kind", OFTString},
                               {"patch", OFTInteger64},
                               {"photo", OFTString},
                               {"state", OFTString},
                               {"length_px", OFTReal},
                               {"exaggeration", OFTReal}})) {}

  void Write(const char* kind, std::int64_t id, const std::string& photo, const std::string& state,
             const Eigen::Vector3d& ground_m, const Eigen::Vector2d& residual_px) {
    const auto scale = scales_.find(photo);
    if (scale == scales_.end() || !residual_px.allFinite()) return;
    const Eigen::Vector2d from = ground_m.head<2>();
    const Eigen::Vector2d to = from + kExaggeration * scale->second * residual_px;
    OGRLineString line;
    line.addPoint(from.x(), from.y());
    line.addPoint(to.x(), to.y());
    NewLayer::Row row = layer_.NewRow();
    row.SetGeometry(line);
    row.Set("kind", std::string(kind));
    row.SetInteger("patch", id);
    row.Set("photo", photo);
    row.Set("state", state);
    row.Set("length_px", residual_px.norm());
    row.Set("exaggeration", kExaggeration);
    layer_.Write(std::move(row));
  }

 private:
  GroundScales scales_;
  NewLayer layer_;
};

void WriteResiduals(const std::vector<ExteriorResult>& results, const AdjustmentResult* adjusted,
                    NewGeopackage* file) {
  ResidualLayer layer(file, ScalesOf(PairsOf(results, adjusted)));
  for (const ExteriorResult& result : results)
    for (const PatchResult& patch : result.patches)
      if (patch.ground_m && patch.residual_px)
        layer.Write("patch", patch.id, result.photo, std::string(Name(patch.state)),
                    *patch.ground_m, *patch.residual_px);
  if (adjusted == nullptr) return;
  for (const PointResult& tie : adjusted->ties)
    for (const SightingResult& sighting : tie.seen)
      if (tie.ground_m && sighting.residual_px)
        layer.Write("tie", tie.id, sighting.photo, sighting.state, *tie.ground_m,
                    *sighting.residual_px);
}

// Root mean square of the used sightings' residuals.
std::optional<double> RmsPx(const PointResult& tie) {
  double sum = 0;
  int count = 0;
  for (const SightingResult& sighting : tie.seen)
    if (sighting.state == "used" && sighting.residual_px) {
      sum += sighting.residual_px->squaredNorm();
      ++count;
    }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / count);
}

void WriteTies(const AdjustmentResult& adjusted, NewGeopackage* file) {
  NewLayer layer = file->AddLayer("ties", wkbPoint25D, "Tie points of the block adjustment",
                                  {{"tie", OFTInteger64},
                                   {"photos", OFTString},
                                   {"rays", OFTInteger},
                                   {"rejected", OFTInteger},
                                   {"rms_px", OFTReal},
                                   {"sigma_x", OFTReal},
                                   {"sigma_y", OFTReal},
                                   {"sigma_z", OFTReal}});
  for (const PointResult& tie : adjusted.ties) {
    NewLayer::Row row = layer.NewRow();
    if (tie.ground_m) row.SetGeometry(Point(*tie.ground_m));
    row.SetInteger("tie", tie.id);
    std::vector<std::string> photos;
    std::int64_t rejected = 0;
    for (const SightingResult& sighting : tie.seen) {
      photos.push_back(sighting.photo);
      rejected += sighting.state == "rejected";
    }
    row.Set("photos", Joined(photos, " "));
    row.SetInteger("rays", tie.rays);
    row.SetInteger("rejected", rejected);
    row.Set("rms_px", RmsPx(tie));
    constexpr const char* kSigmas[] = {"sigma_x", "sigma_y", "sigma_z"};
    for (int i = 0; tie.sigma_m && i < 3; ++i) row.Set(kSigmas[i], (*tie.sigma_m)[i]);
    layer.Write(std::move(row));
  }
}

// Writes program and inputs of run.json, but neither its times nor its command line, so that the
// same block gives the same file.
void DescribeRuns(const std::string& directory, NewGeopackage* file) {
  std::map<std::string, std::string> items;
  for (const auto& [stage, run] : ReadRunRecords(directory))
    items["orient_" + stage] = ProgramAndInputs(run);
  file->Execute(StatementsOfMetadata(items));
}

}  // namespace

std::string WriteBlockGeopackage(const std::string& directory, const Crs& crs,
                                 const std::vector<ExteriorResult>& results,
                                 const AdjustmentResult* adjusted,
                                 const std::vector<PhotoWithoutResult>& others) {
  const std::string path = (fs::path(directory) / "block.gpkg").string();
  const QuietGdal quiet;
  NewGeopackage file(path, crs);
  WritePhotos(directory, results, others, &file);
  WriteFootprints(results, &file);
  WritePatches(results, &file);
  WriteResiduals(results, adjusted, &file);
  if (adjusted != nullptr) WriteTies(*adjusted, &file);
  WriteStyles(adjusted != nullptr, &file);
  DescribeRuns(directory, &file);
  file.Finish();
  return path;
}

}  // namespace orient

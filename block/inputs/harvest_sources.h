// The sources of a harvest, photos or orthophotos: where they lie, and how they are opened.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/terrain/earth_effects.h"
#include "patchdb/harvest/harvest.h"

namespace orient::block {

struct PhotosToHarvest {
  std::vector<std::string> paths;
  CameraFile camera;
  OrientationTable orientation;
  // If the marks leave a photo's scan orientation open, exterior orientation results beside this
  // file give it.
  std::string orientation_path;
  std::string interior_folder;         // empty: a digital camera
  EarthMode earth = EarthMode::kAuto;  // what the orientation was made with
};

// A source that is open, with what shows its ground.
struct OpenSource {
  std::unique_ptr<Raster> raster;
  std::unique_ptr<patchdb::SourceView> view;
  std::unique_ptr<patchdb::Coverage> coverage;
};

// The parts of a harvest that depend on what the sources are; a source is named by its place in the
// list of paths.
class HarvestSources {
 public:
  virtual ~HarvestSources() = default;
  virtual patchdb::SourceKind Kind() const = 0;
  // Ground that a source may show, at heights from `low_m` to `high_m`.
  virtual Bounds Footprint(std::size_t source, double low_m, double high_m) const = 0;
  virtual OpenSource Open(std::size_t source, const GroundSurface& surface,
                          bool as_witness) const = 0;
  virtual patchdb::HarvestResult Harvest(std::size_t source, const Raster& raster,
                                         const GroundSurface& surface,
                                         const patchdb::HarvestOptions& options,
                                         const patchdb::HarvestProgress& progress,
                                         const patchdb::HarvestContext& context) const = 0;
};

// Refer to what they are given. Throw InputError: a photo without orientation, one that does not
// look at the ground, an orthophoto without georeference.
std::unique_ptr<HarvestSources> PhotoSources(const PhotosToHarvest& photos,
                                             double orientation_sigma_px);
std::unique_ptr<HarvestSources> OrthophotoSources(const std::vector<std::string>& paths,
                                                  const Crs& crs, double orientation_sigma_px);

}  // namespace orient::block

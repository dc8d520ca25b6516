// The sources of a harvest, photos or orthophotos: where they lie, and how they are opened.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "patchdb/harvest.h"
#include "tools/harvest_run.h"

namespace orient {

// A source that is open, with what shows its ground.
struct OpenSource {
  std::unique_ptr<Raster> raster;
  std::unique_ptr<SourceView> view;
  std::unique_ptr<Coverage> coverage;
};

// The parts of a harvest that depend on what the sources are; a source is named by its place in the
// list of paths.
class HarvestSources {
 public:
  virtual ~HarvestSources() = default;
  virtual SourceKind Kind() const = 0;
  // Ground that a source may show, at heights from `low_m` to `high_m`.
  virtual Bounds Footprint(std::size_t source, double low_m, double high_m) const = 0;
  virtual OpenSource Open(std::size_t source, const GroundSurface& surface,
                          bool as_witness) const = 0;
  virtual HarvestResult Harvest(std::size_t source, const Raster& raster,
                                const GroundSurface& surface, const HarvestOptions& options,
                                const HarvestProgress& progress,
                                const HarvestContext& context) const = 0;
};

// Refer to what they are given. Throw InputError: a photo without orientation, one that does not
// look at the ground, an orthophoto without georeference.
std::unique_ptr<HarvestSources> PhotoSources(const PhotosToHarvest& photos,
                                             double orientation_sigma_px);
std::unique_ptr<HarvestSources> OrthophotoSources(const std::vector<std::string>& paths,
                                                  const Crs& crs, double orientation_sigma_px);

}  // namespace orient

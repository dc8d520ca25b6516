#include "tools/report/figures/ortho_figures.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/geometry/rotation.h"
#include "core/raster/band_raster.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr std::string_view kOrtho = ".ortho.tif";

std::optional<double> NumberOf(const BandRaster& raster, const char* name) {
  const auto value = NumberIn(raster.Metadata(name));
  return value && *value >= 0 && *value < 1e9 ? value : std::nullopt;
}

std::optional<GroundAccuracy> AccuracyIn(const BandRaster& raster) {
  const auto median_m = NumberOf(raster, "ORIENT_CE90_MEDIAN_M");
  const auto worst_m = NumberOf(raster, "ORIENT_CE90_WORST_M");
  if (!median_m || !worst_m) return std::nullopt;
  return GroundAccuracy{*median_m, *worst_m};
}

// As the orthophoto's metadata and the table of poses round it.
std::optional<Pose> PoseIn(const BandRaster& raster) {
  std::istringstream text(raster.Metadata("ORIENT_POSE"));
  Pose pose;
  for (double& metres : pose.position_m)
    if (!(text >> metres)) return std::nullopt;
  for (double& angle : pose.opk_rad) {
    if (!(text >> angle)) return std::nullopt;
    angle = RadFromDeg(angle);
  }
  return pose;
}

class Reader {
 public:
  Reader(fs::path block, fs::path folder) : block_(std::move(block)), folder_(std::move(folder)) {}

  OrthoFolder Read() {
    result_.folder = folder_.string();
    std::vector<std::string> names;
    std::error_code ignored;
    for (fs::directory_iterator entry(block_ / folder_, ignored), end; !ignored && entry != end;
         entry.increment(ignored))
      if (const std::string name = entry->path().filename().string();
          name.ends_with(kOrtho) && name.size() > kOrtho.size())
        names.push_back(name);
    std::sort(names.begin(), names.end());
    for (const std::string& name : names) AddPhoto(name);
    AddMosaic();
    result_.seamlines = Existing("seamlines.gpkg");
    result_.tones = Existing("mosaic_tones.csv");
    return std::move(result_);
  }

 private:
  std::string Existing(const std::string& name) const {
    std::error_code ignored;
    return fs::is_regular_file(block_ / folder_ / name, ignored) ? (folder_ / name).string() : "";
  }

  std::optional<BandRaster> Open(const std::string& file) {
    try {
      return BandRaster::Open((block_ / file).string());
    } catch (const InputError& error) {
      result_.unreadable.push_back(error.what());
      return std::nullopt;
    }
  }

  void AddPhoto(const std::string& name) {
    const std::string file = (folder_ / name).string();
    const auto raster = Open(file);
    if (!raster) return;
    result_.photos.push_back({name.substr(0, name.size() - kOrtho.size()), file, raster->Width(),
                              raster->Height(), NumberOf(*raster, "ORIENT_GSD_M"),
                              AccuracyIn(*raster), raster->Metadata("ORIENT_DEM"), PoseIn(*raster),
                              raster->Metadata(kMadeFrom),
                              NumberOf(*raster, "ORIENT_FRAME_WITH_HEIGHTS")});
  }

  void AddMosaic() {
    const std::string file = Existing("mosaic.tif");
    if (file.empty()) return;
    const auto raster = Open(file);
    if (!raster) return;
    MosaicSources now;
    for (const OrthoFigures& photo : result_.photos) now[photo.photo] = photo.made_from;
    const MosaicSources then = SourcesOf(raster->Metadata(kMadeFrom));
    result_.mosaic =
        MosaicFigures{file,          raster->Width(),     raster->Height(), AccuracyIn(*raster),
                      !then.empty(), ChangesOf(then, now)};
  }

  fs::path block_, folder_;
  OrthoFolder result_;
};

}  // namespace

OrthoFolder ReadOrthophotosIn(const std::string& folder) { return Reader(folder, "").Read(); }

std::optional<OrthoFolder> ReadOrthoFolder(const std::string& directory) {
  for (const char* folder : {"ortho", ""}) {
    OrthoFolder found = Reader(directory, folder).Read();
    if (!found.photos.empty() || found.mosaic || !found.unreadable.empty()) return found;
  }
  return std::nullopt;
}

std::optional<GroundAccuracy> AccuracyOfAll(const std::vector<OrthoFigures>& photos) {
  std::vector<double> medians_m;
  double worst_m = 0;
  for (const OrthoFigures& photo : photos) {
    if (!photo.ce90) continue;
    medians_m.push_back(photo.ce90->median_m);
    worst_m = std::max(worst_m, photo.ce90->worst_m);
  }
  if (medians_m.empty()) return std::nullopt;
  return GroundAccuracy{Median(std::move(medians_m)), worst_m};
}

}  // namespace orient

#include "tools/simulate/simulate.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/files/orientation_table.h"
#include "tools/simulate/block_layout.h"
#include "tools/simulate/geotiff.h"
#include "tools/simulate/ground_raster.h"
#include "tools/simulate/photo_making.h"
#include "tools/simulate/scene.h"
#include "tools/simulate/truth_file.h"

namespace orient {
namespace {

namespace fs = std::filesystem;
using namespace simulation;  // NOLINT: this file is where its parts come together

// The ground raster is finer than the photos, so that averaging it over a pixel is exact enough.
constexpr double kCellPerGsd = 0.7;

// Everything of the block that does not depend on the date, made once.
struct Block {
  const SimulationOptions& options;
  std::string directory;
  Crs crs;
  SimulatedCamera fresh_camera, old_camera;
  BlockLayout layout;
  Terrain terrain;
  Scene scene;
  std::vector<PhotoPlan> fresh, old;
};

void RefuseSteepGround(const Terrain& terrain, const SimulatedCamera& camera) {
  const double tangent =
      camera.file.camera.FrameRadius() / camera.file.camera.principal_distance_mm;
  if (terrain.MaxSlope() * tangent * 1.25 > 0.95)
    throw UsageError(
        "--relief-m: the ground becomes so steep that parts of it would be hidden; "
        "give less relief or a larger --gsd-m");
}

// The part of the ground that the photos of one date show.
Bounds RasterExtent(const SimulatedCamera& camera, const std::vector<PlannedPhoto>& photos,
                    const Terrain& terrain) {
  const Bounds tight = FootprintBounds(camera.file.camera, photos, terrain.MinHeight());
  constexpr double kMargin_m = 8;
  return {tight.min_x - kMargin_m, tight.min_y - kMargin_m, tight.max_x + kMargin_m,
          tight.max_y + kMargin_m};
}

double CellSize(const SimulationOptions& options, bool old) {
  return kCellPerGsd * options.gsd_m * (old ? options.old_gsd_ratio : 1);
}

double Cells(const Bounds& extent, double cell_m) {
  return (extent.max_x - extent.min_x) * (extent.max_y - extent.min_y) / (cell_m * cell_m);
}

// Before anything is made, since making it takes minutes.
void RefuseLargeGround(const Bounds& extent, double cell_m) {
  constexpr double kMostCells = 1.2e9;  // 5 GB
  if (Cells(extent, cell_m) > kMostCells)
    throw UsageError(
        "--photos, --gsd-m: the block's ground does not fit into memory at this "
        "resolution; give fewer photos or larger scan pixels");
}

void RefuseLargeTerrain(const Bounds& ground, double cell_m) {
  constexpr double kMostCells = 1e8;  // 2 GB while it is made
  const double cells = Cells(ground, cell_m);
  if (cells > kMostCells)
    throw UsageError(fmt::format(
        "--dem-cell-m {:g}: the DEM would have {:.2g} cells; give larger ones", cell_m, cells));
}

void PutOverEarth(const SimulationOptions& options, const BlockLayout& layout,
                  const std::vector<PlannedPhoto>& photos, SimulatedCamera* camera) {
  const double flying_m =
      photos.empty() ? layout.mean_height_m : photos[photos.size() / 2].pose.position_m.z();
  camera->over_earth =
      WithEarthEffects(camera->file.camera, options.earth, flying_m, layout.mean_height_m);
}

Block PlanEverything(const SimulationOptions& options, const std::string& directory) {
  SimulatedCamera fresh_camera = NewCamera(options), old_camera = OldCamera(options);
  const BlockLayout layout = PlanBlock(options, fresh_camera, old_camera);
  PutOverEarth(options, layout, layout.fresh, &fresh_camera);
  PutOverEarth(options, layout, layout.old, &old_camera);
  RefuseLargeTerrain(layout.ground, options.dem_cell_m);
  const Terrain terrain =
      Terrain::Make(layout.ground, {layout.mean_height_m, options.relief_m, options.dem_cell_m,
                                    Mix(options.seed + 2), options.hills_m});
  RefuseSteepGround(terrain, fresh_camera);
  RefuseSteepGround(terrain, old_camera);
  RefuseLargeGround(RasterExtent(fresh_camera, layout.fresh, terrain), CellSize(options, false));
  RefuseLargeGround(RasterExtent(old_camera, layout.old, terrain), CellSize(options, true));
  Block block{options,
              directory,
              Crs::Parse(options.crs, "--crs"),
              fresh_camera,
              old_camera,
              layout,
              terrain,
              Scene::Make(layout.ground, {options.change, options.objects, Mix(options.seed + 3),
                                          options.inverted}),
              {},
              {}};
  for (size_t i = 0; i < layout.fresh.size(); ++i)
    block.fresh.push_back(
        PlanPhoto(options, fresh_camera, layout.fresh[i], false, static_cast<int>(i)));
  for (size_t i = 0; i < layout.old.size(); ++i)
    block.old.push_back(PlanPhoto(options, old_camera, layout.old[i], true, static_cast<int>(i)));
  return block;
}

// Says that a folder is a simulation's, though there is no truth.json yet.
fs::path UnfinishedPath(const fs::path& directory) { return directory / "unfinished_simulation"; }

void RefuseOthersFolder(const SimulationOptions& options, const fs::path& directory) {
  std::error_code error;
  if (!fs::exists(directory) || fs::is_empty(directory, error)) return;
  if (!options.overwrite)
    throw UsageError(directory.string() + ": not empty; give another --out or --overwrite");
  if (!fs::exists(directory / "truth.json") && !fs::exists(UnfinishedPath(directory)))
    throw UsageError(directory.string() +
                     ": not empty and not made by a simulation; give another --out");
}

// Empties what an earlier simulation made; anything else in the way is refused.
void PrepareFolder(const SimulationOptions& options, const fs::path& directory) {
  RefuseOthersFolder(options, directory);
  MakeOutputDirectory(directory.string());
  WriteFileAtomically(UnfinishedPath(directory).string(), "to be repeated with --overwrite\n");
  for (const char* old : {"scans", "old", "truth", "truth.json"}) fs::remove_all(directory / old);
  for (const char* folder : {"scans", "old/photos", "old/interior", "truth/interior"})
    MakeOutputDirectory((directory / folder).string());
}

GroundRaster RenderEpoch(const Block& block, bool old) {
  const SimulatedCamera& camera = old ? block.old_camera : block.fresh_camera;
  const auto& photos = old ? block.layout.old : block.layout.fresh;
  return RenderGround(block.scene, block.terrain, old ? Epoch::kOld : Epoch::kNew,
                      RasterExtent(camera, photos, block.terrain), CellSize(block.options, old));
}

void WriteOrtho(const Block& block, const GroundRaster& ground) {
  const double gsd = block.options.gsd_m * block.options.old_gsd_ratio;
  const Bounds extent = ground.Extent();
  const int width = static_cast<int>((extent.max_x - extent.min_x) / gsd) - 1;
  const int height = static_cast<int>((extent.max_y - extent.min_y) / gsd) - 1;
  std::vector<std::uint16_t> values;
  values.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col) {
      float sum = 0;
      for (const double dc : {0.25, 0.75})
        for (const double dr : {0.25, 0.75})
          sum += ground.ToneAt(extent.min_x + (col + dc) * gsd, extent.max_y - (row + dr) * gsd);
      values.push_back(static_cast<std::uint16_t>(15 + 0.25f * 225 * std::min(sum, 4.0f)));
    }
  WriteGreyTiff(block.directory + "/old/ortho.tif", width, height, values, 8, std::nullopt,
                GeoReference{extent.min_x, extent.max_y, gsd, block.crs});
}

void WritePhotos(const Block& block, bool old, const std::function<void()>& step,
                 std::vector<std::string>* paths) {
  const SimulatedCamera& camera = old ? block.old_camera : block.fresh_camera;
  const GroundRaster ground = RenderEpoch(block, old);
  step();
  for (const PhotoPlan& plan : old ? block.old : block.fresh) {
    const std::string path =
        block.directory + (old ? "/old/photos/" : "/scans/") + plan.photo.name + ".tif";
    WriteGreyTiff(path, plan.scan.Setup().width, plan.scan.Setup().height,
                  MakePhoto(block.options, camera, plan, ground, block.terrain), block.options.bits,
                  camera.pixel_size_mm, std::nullopt);
    WriteInteriorResult(block.directory + (old ? "/old/interior" : "/truth/interior"),
                        TrueInterior(camera, plan));
    paths->push_back(path);
    step();
  }
  if (old && block.options.ortho) WriteOrtho(block, ground);
}

void WriteDem(const Block& block) {
  const Eigen::MatrixXf& heights = block.terrain.Heights();
  std::vector<float> values;
  for (Eigen::Index row = 0; row < heights.rows(); ++row)
    for (Eigen::Index col = 0; col < heights.cols(); ++col) values.push_back(heights(row, col));
  WriteFloatTiff(
      block.directory + "/dem.tif", static_cast<int>(heights.cols()),
      static_cast<int>(heights.rows()), values,
      GeoReference{block.terrain.West(), block.terrain.North(), block.terrain.Cell(), block.crs});
}

void WriteOrientations(const Block& block) {
  OrientationTable approximate{{}, block.crs}, exact{{}, block.crs}, old{{}, block.crs};
  RandomStream random(Mix(block.options.seed + 4));
  const double attitude_rad = RadFromDeg(block.options.attitude_error_deg);
  for (const PhotoPlan& plan : block.fresh) {
    exact.rows.push_back({plan.photo.name, plan.photo.pose, std::nullopt});
    Pose wrong = plan.photo.pose;
    for (int i = 0; i < 3; ++i) {
      wrong.position_m[i] += block.options.position_error_m * random.Gaussian();
      wrong.opk_rad[i] = NormalizeAngle(wrong.opk_rad[i] + attitude_rad * random.Gaussian());
    }
    approximate.rows.push_back({plan.photo.name, wrong, std::nullopt});
  }
  for (const PhotoPlan& plan : block.old)
    old.rows.push_back({plan.photo.name, plan.photo.pose, std::nullopt});
  WriteOrientationTable(block.directory + "/approx.csv", approximate);
  WriteOrientationTable(block.directory + "/truth/orientation.csv", exact);
  WriteOrientationTable(block.directory + "/old/orientation.csv", old);
}

// WKT is full of quotes.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c == '\n' || c == '\r' ? ' ' : c;
  }
  return quoted + "\"";
}

void WriteBlockFile(const Block& block) {
  const SimulationOptions& options = block.options;
  std::ostringstream text;
  text << "# A simulated block; its truth is in truth.json.\n"
       << "crs = " << Quoted(options.crs) << "\n"
       << "dem = \"dem.tif\"\npatchdb = \"patches.gpkg\"\ncamera = \"camera.toml\"\n"
       << "photos = [\"scans/*.tif\"]\napproximations = \"approx.csv\"\n\n"
       << "[approximate_accuracy]\nposition_m = " << std::max(options.position_error_m, 0.01)
       << "\nattitude_deg = " << std::max(options.attitude_error_deg, 0.001) << "\n\n"
       << "[scan]\n";
  if (block.fresh_camera.film_half_mm > 0) {
    text << "pixel_size_um = " << block.fresh_camera.pixel_size_mm * 1e3 << "\n"
         << "polarity = \"" << Name(options.polarity) << "\"\n"
         << "orientation = \""
         << (options.orientation ? std::string(Name(*options.orientation)) : "auto") << "\"\n";
  }
  text << "\n[output]\ndirectory = \"out\"\n";
  WriteFileAtomically(block.directory + "/block.toml", text.str());
}

}  // namespace

SimulationSummary Simulate(const SimulationOptions& options, const std::string& out_dir,
                           const std::function<void(int, int)>& step) {
  if (const auto wrong = options.Check()) throw UsageError(*wrong);
  const Block block = PlanEverything(options, out_dir);
  const int steps = 2 + static_cast<int>(block.old.size() + block.fresh.size());
  int done = 0;
  const auto advance = [&] {
    if (step) step(++done, steps);
  };
  if (step) step(done, steps);
  PrepareFolder(options, out_dir);
  WriteDem(block);
  WriteOrientations(block);
  WriteCameraFile(out_dir + "/camera.toml", block.fresh_camera.file);
  WriteCameraFile(out_dir + "/old/camera.toml", block.old_camera.file);

  SimulationSummary summary;
  WritePhotos(block, true, advance, &summary.old_photos);
  WritePhotos(block, false, advance, &summary.photos);
  const BlockTruth truth{options,          block.scene, block.terrain, block.fresh_camera,
                         block.old_camera, block.fresh, block.old};
  WriteChangeMask(out_dir + "/change.tif", truth, block.crs);
  WriteStandingMask(out_dir + "/truth/standing.tif", truth, block.crs);
  WriteBlockFile(block);
  summary.block_file = out_dir + "/block.toml";
  summary.truth_file = out_dir + "/truth.json";
  summary.width = block.fresh.front().scan.Setup().width;
  summary.height = block.fresh.front().scan.Setup().height;
  summary.flying_height_m = FlyingHeight(block.fresh_camera, options.gsd_m);
  summary.parcels = static_cast<int>(block.scene.land.Parcels().size());
  summary.buildings = static_cast<int>(block.scene.buildings.size());
  summary.trees = static_cast<int>(block.scene.trees.size());
  WriteTruth(summary.truth_file, truth);
  fs::remove(UnfinishedPath(out_dir));
  return summary;
}

}  // namespace orient

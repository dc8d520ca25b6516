// A simulated town in six overlapping photos, an orthophoto, terrain and surface models: what
// stands where, and what truly lies under each pixel, is known.
#pragma once

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <random>

#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "patchdb/store/patch_database.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/block_layout.h"
#include "tools/simulate/cameras.h"
#include "tools/simulate/geotiff.h"
#include "tools/simulate/ground_raster.h"
#include "tools/simulate/noise.h"
#include "tools/simulate/photo_making.h"
#include "tools/simulate/photo_rendering.h"

namespace orient::simulation {

inline constexpr double kGsd = 0.3;       // m
inline constexpr double kDsmCell = 0.6;   // m
inline constexpr double kDemCell = 5;     // m
inline constexpr double kStanding = 0.5;  // m above the ground: a building or tree

// Houses of 4 to 25 m wherever no road runs, as dense as in a town's middle, and trees between
// them.
inline void BuildUp(Scene* scene) {
  RandomStream random(7);
  const double width = scene->extent.max_x - scene->extent.min_x;
  const double height = scene->extent.max_y - scene->extent.min_y;
  const auto in = [&random](double low, double high) {
    return static_cast<float>(random.Uniform(low, high));
  };
  const auto is_free = [&](const Eigen::Vector2f& place, float radius) {
    const LandAt at = scene->land.At(place.x(), place.y());
    if (std::abs(at.road_m) < radius + 4 || std::abs(at.track_m) < radius + 2) return false;
    return std::none_of(scene->buildings.begin(), scene->buildings.end(), [&](const Building& b) {
      return (b.centre - place).norm() < radius + std::hypot(b.half_length, b.half_width) + 1;
    });
  };
  for (double y = 10; y < height; y += 21)
    for (double x = 10; x < width; x += 21) {
      Building house;
      house.centre = {static_cast<float>(x) + in(-4, 4), static_cast<float>(y) + in(-4, 4)};
      const float angle = in(-0.1, 0.1);
      house.axis = {std::cos(angle), std::sin(angle)};
      house.half_length = in(5, 9);
      house.half_width = in(4, 7);
      house.eave = in(4, 20);
      house.ridge = house.eave + (random.Chance(0.5) ? 0 : in(1, 5));
      house.tone = in(0.2, 0.8);
      if (is_free(house.centre, 5)) scene->buildings.push_back(house);
    }
  for (int i = 0; i < width * height / 400; ++i) {
    Tree tree;
    tree.centre = {in(0, width), in(0, height)};
    tree.radius = in(1.2, 4);
    tree.height = tree.radius * in(1.8, 3.2);
    tree.seed = static_cast<std::uint32_t>(random.Next());
    if (is_free(tree.centre, tree.radius)) scene->trees.push_back(tree);
  }
}

// Two strips of three photos, 60 % and 30 % overlap.
inline std::vector<PlannedPhoto> Photos(const Eigen::Vector2d& centre, double height_m,
                                        double footprint_m) {
  std::vector<PlannedPhoto> photos;
  RandomStream random(3);
  for (int strip = 0; strip < 2; ++strip)
    for (int number = 0; number < 3; ++number) {
      Pose pose;
      pose.position_m << centre.x() + (number - 1) * 0.4 * footprint_m,
          centre.y() + (strip - 0.5) * 0.7 * footprint_m, height_m;
      for (int i = 0; i < 3; ++i) pose.opk_rad[i] = RadFromDeg(1.0) * random.Gaussian();
      pose.opk_rad[2] += RadFromDeg(180.0 * strip);
      photos.push_back({"photo_" + std::to_string(strip) + std::to_string(number), pose});
    }
  return photos;
}

struct Harvested {
  std::vector<patchdb::Patch> patches;
  std::map<std::int64_t, std::string> sources;  // photo or orthophoto of each source_id
};

struct City {
  TemporaryFolder folder;
  Crs crs = Crs::Parse("EPSG:32635", "test");
  SimulatedCamera camera;
  std::vector<PlannedPhoto> photos;
  Terrain terrain = Terrain(Eigen::MatrixXf::Zero(2, 2), 0, 0, 1);
  GroundRaster ground;

  City() {
    SimulationOptions options;
    options.camera = CameraPreset::kDigital;
    options.gsd_m = kGsd;
    options.grain = 2;
    camera = NewCamera(options);
    const Eigen::Vector2d centre(512000, 5204000);
    const double above = FlyingHeight(camera, kGsd);
    const double footprint =
        camera.file.camera.frame_mm.minCoeff() * above / camera.file.camera.principal_distance_mm;
    photos = Photos(centre, 250 + above, footprint);
    const double half = 1.05 * footprint;
    const Bounds extent{centre.x() - half, centre.y() - half, centre.x() + half, centre.y() + half};
    TerrainOptions relief;
    relief.relief_m = 25;
    relief.cell_m = kDemCell;
    terrain = Terrain::Make(
        {extent.min_x - 200, extent.min_y - 200, extent.max_x + 200, extent.max_y + 200}, relief);
    Scene scene = Scene::Make(extent, {});
    BuildUp(&scene);
    ground = RenderGround(scene, terrain, Epoch::kOld, extent, 0.7 * kGsd);
    for (const PlannedPhoto& photo : photos) WritePhoto(options, photo);
    WriteCameraFile(folder / "camera.toml", camera.file);
    WriteTable("true.csv", 0.02, 1e-5, 0);  // a tenth of a pixel
    WriteHeights("dem.tif", kDemCell, false, 0, 0);
    WriteHeights("dsm.tif", kDsmCell, true, 0, 0);
    WriteOrtho();
  }

  void WritePhoto(const SimulationOptions& options, const PlannedPhoto& photo) const {
    const PhotoPlan plan = PlanPhoto(options, camera, photo, true, 1);
    WriteGreyTiff(folder / (photo.name + ".tif"), camera.width_px, camera.height_px,
                  MakePhoto(options, camera, plan, ground, terrain), 8, std::nullopt, std::nullopt);
  }

  void WriteTable(const std::string& name, double position_m, double angle_rad,
                  unsigned seed) const {
    OrientationTable table{{}, crs};
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (const PlannedPhoto& photo : photos) {
      Vector6d sigma;
      sigma << Eigen::Vector3d::Constant(position_m), Eigen::Vector3d::Constant(angle_rad);
      Vector6d pose = photo.pose.AsVector();
      for (int i = 0; i < 6; ++i) pose[i] += sigma[i] * normal(random);
      table.rows.push_back({photo.name, Pose::FromVector(pose),
                            position_m > 0 ? std::optional(sigma) : std::nullopt});
    }
    WriteOrientationTable(folder / name, table);
  }

  // With what stands, or with smooth errors of `sigma_m` (waves of about 150 m).
  void WriteHeights(const std::string& name, double cell, bool standing, double sigma_m,
                    unsigned seed) const {
    const Bounds extent = ground.Extent();
    const int width = static_cast<int>((extent.max_x - extent.min_x) / cell);
    const int height = static_cast<int>((extent.max_y - extent.min_y) / cell);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> phase(0, 2 * M_PI);
    std::vector<Eigen::Vector3d> waves;
    for (int i = 0; i < 24; ++i) {
      const double direction = phase(random);
      waves.emplace_back(std::cos(direction) / 24, std::sin(direction) / 24, phase(random));
    }
    std::vector<float> values;
    for (int row = 0; row < height; ++row)
      for (int col = 0; col < width; ++col) {
        const double x = extent.min_x + (col + 0.5) * cell, y = extent.max_y - (row + 0.5) * cell;
        double value = terrain.HeightAt(x, y);
        if (standing) value += static_cast<double>(ground.ObjectAt(x, y));
        for (const Eigen::Vector3d& wave : waves)
          value += sigma_m * std::sin(wave.x() * x + wave.y() * y + wave.z()) * std::sqrt(2.0 / 24);
        values.push_back(static_cast<float>(value));
      }
    WriteFloatTiff(folder / name, width, height, values, {extent.min_x, extent.max_y, cell, crs});
  }

  void WriteOrtho() const {
    const Bounds extent = ground.Extent();
    const int side = static_cast<int>((extent.max_x - extent.min_x) / kGsd) - 1;
    std::vector<std::uint16_t> values;
    for (int row = 0; row < side; ++row)
      for (int col = 0; col < side; ++col)
        values.push_back(static_cast<std::uint16_t>(
            15 + 225 * std::min(1.0f, ground.ToneAt(extent.min_x + (col + 0.5) * kGsd,
                                                    extent.max_y - (row + 0.5) * kGsd))));
    WriteGreyTiff(folder / "ortho.tif", side, side, values, 8, std::nullopt,
                  GeoReference{extent.min_x, extent.max_y, kGsd, crs});
  }

  Harvested Harvest(std::vector<std::string> arguments) const {
    const std::string database = folder / "city.gpkg";
    std::filesystem::remove(database);
    const auto run = [](const std::vector<std::string>& words) {
      const ProgramRun done = RunOrient(words);
      if (done.exit_code != 0) throw std::runtime_error(done.err);
      std::cout << done.out;
    };
    run({"patchdb", "create", database, "--crs", "EPSG:32635"});
    arguments.insert(arguments.begin(), {"patchdb", arguments[0], database});
    arguments.erase(arguments.begin() + 3);
    run(arguments);
    const patchdb::PatchDatabase made =
        patchdb::PatchDatabase::Open(database, patchdb::PatchDatabase::Mode::kRead);
    Harvested harvested{made.ListPatches(0, 1000000), {}};
    for (const patchdb::PatchSource& source : made.Sources())
      harvested.sources[source.id] = PhotoName(source.name);
    return harvested;
  }

  Harvested HarvestPhotos(const std::string& photos_glob, const std::string& table,
                          const std::string& dem, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "harvest",       folder / photos_glob, "--camera", folder / "camera.toml",
        "--orientation", folder / table,       "--dem",    folder / dem};
    arguments.insert(arguments.end(), more.begin(), more.end());
    if (std::find(more.begin(), more.end(), "--further-views") == more.end())
      arguments.insert(arguments.end(), {"--further-views", "4"});
    return Harvest(arguments);
  }

  const PlannedPhoto* Photo(const std::string& name) const {
    const auto photo = std::find_if(photos.begin(), photos.end(),
                                    [&](const PlannedPhoto& p) { return p.name == name; });
    return photo == photos.end() ? nullptr : &*photo;
  }

  // How high above the ground that stands which a photo shows in a chip's middle: the ray comes
  // down until it meets something. Of an orthophoto: what stands there.
  double HeightShown(const patchdb::Patch& patch, const std::string& source) const {
    const PlannedPhoto* photo = Photo(source);
    if (photo == nullptr)
      return static_cast<double>(ground.ObjectAt(patch.ground_m.x(), patch.ground_m.y()));
    const Pose& pose = photo->pose;
    const Eigen::Vector3d sight =
        (pose.position_m - patch.ground_m) / (pose.position_m.z() - patch.ground_m.z());
    for (double above = 40; above > -5; above -= 0.1) {
      const Eigen::Vector3d place = patch.ground_m + above * sight;
      const double bare = terrain.HeightAt(place.x(), place.y());
      const auto standing = static_cast<double>(ground.ObjectAt(place.x(), place.y()));
      if (place.z() <= bare + standing) return standing > 0 ? place.z() - bare : 0;
    }
    return 0;
  }
};

}  // namespace orient::simulation

// The simulated worlds of exterior_jaw_wu: made in a folder and read back with their truth; and
// masks of the ground.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "block/inputs/mark_shapes.h"
#include "block/inputs/scan_interior.h"
#include "block/stages/exterior_stage.h"
#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "interior/interior.h"
#include "patchdb/store/patch_database.h"
#include "tools/commands/commands.h"
#include "tools/simulate/simulate.h"

namespace orient::jaw_wu {

struct Case {
  SimulationOptions simulation;
  int chip_px = 61;
  bool hard = false;
};

inline Case CaseOf(const std::string& name, bool rc10) {
  Case c;
  SimulationOptions& s = c.simulation;
  s.camera = rc10 ? CameraPreset::kRc10 : CameraPreset::kDemo;
  s.pixel_size_um = 25;
  s.photos = 2;
  s.overwrite = true;
  if (name == "fine") {
    s.old_gsd_ratio = 0.3;
    c.chip_px = 201;
  } else if (name == "coarse") {
    s.old_gsd_ratio = 1;
    s.change = 0.3;
  } else if (name == "hard" || name == "mountains") {
    c.hard = true;
    s.pixel_size_um = 50;
    s.gsd_m = 2;
    s.photos = 8;
    s.strips = 2;
    s.relief_m = 1200;
    s.hills_m = 6000;
    s.dem_cell_m = 20;
    s.old_gsd_ratio = 1;
    if (name == "hard") {
      s.change = 0.5;
      s.inverted = 2.0 / 3;
    }
  } else {
    throw UsageError("the case is fine, coarse, hard or mountains");
  }
  return c;
}

inline void Orient(const std::vector<std::string>& arguments) {
  std::ostringstream out;
  const int code = RunProgram(MakeCommands(), arguments, out, std::cerr);
  if (code != 0 && code != 3) throw InputError("orient " + arguments[0] + ": " + out.str());
}

// Makes the world if it does not exist yet.
inline void MakeWorld(const Case& c, const std::string& folder, std::uint32_t seed) {
  if (std::filesystem::exists(folder + "/all.gpkg")) return;
  SimulationOptions options = c.simulation;
  options.seed = seed;
  Simulate(options, folder);
  Orient({"interior", "--camera", folder + "/camera.toml", "--out", folder + "/interior",
          "--overwrite", folder + "/scans/*.tif"});
  Orient({"patchdb", "create", folder + "/all.part.gpkg", "--crs", options.crs});
  Orient({"patchdb", "harvest", folder + "/all.part.gpkg", "--camera", folder + "/old/camera.toml",
          "--orientation", folder + "/old/orientation.csv", "--dem", folder + "/dem.tif",
          "--chip-px", std::to_string(c.chip_px), folder + "/old/photos/*.tif"});
  std::filesystem::rename(folder + "/all.part.gpkg", folder + "/all.gpkg");
}

// A point of the bare ground and its true position in a scan.
struct Check {
  Eigen::Vector3d ground_m;
  Eigen::Vector2d pixel;
};

struct World {
  std::string folder;
  Case of;
  std::string patches_of = "any";  // or "open": without objects; "all": of the harvest
  OrientationTable truth;
  CameraFile camera;  // with the run's earth curvature and refraction
  interior::MarkShapes marks;
  GroundSurface surface;
  std::vector<patchdb::Patch> patches;
  std::map<std::string, std::map<int, Check>> checks;

  World(const Case& c, const std::string& at)
      : folder(at),
        of(c),
        truth(ReadOrientationTable(at + "/truth/orientation.csv")),
        camera(ReadCameraFile(at + "/camera.toml")),
        marks(block::LoadMarkShapes(camera)),
        surface(GroundSurface::FromFile(at + "/dem.tif", *truth.crs)),
        patches(patchdb::PatchDatabase::Open(at + "/all.gpkg", patchdb::PatchDatabase::Mode::kRead)
                    .ListPatches(0, std::numeric_limits<int>::max())) {
    block::ExteriorRunOptions run = Run("none");
    run.approximations = at + "/truth/orientation.csv";
    run.patchdb = at + "/all.gpkg";
    camera.camera = WithEarth(camera.camera, block::EarthK1OfRun(run));
    std::ifstream file(at + "/truth.json");
    const nlohmann::json json = nlohmann::json::parse(file);
    for (const nlohmann::json& photo : json.at("photos"))
      for (const nlohmann::json& seen : photo.at("check")) {
        const int number = seen.at("point");
        const auto ground = json.at("check_points")
                                .at(static_cast<std::size_t>(number))
                                .get<std::array<double, 3>>();
        const auto pixel = seen.at("pixel").get<std::array<double, 2>>();
        checks[photo.at("photo").get<std::string>()][number] = {Eigen::Vector3d(ground.data()),
                                                                Eigen::Vector2d(pixel.data())};
      }
  }

  block::ExteriorRunOptions Run(const std::string& name) const {
    block::ExteriorRunOptions run;
    for (const OrientationRow& row : truth.rows)
      run.photos.push_back(folder + "/scans/" + row.photo + ".tif");
    run.camera = folder + "/camera.toml";
    run.approximations = folder + "/start_" + name + ".csv";
    run.dem = folder + "/dem.tif";
    run.patchdb = folder + "/" + patches_of + ".gpkg";
    run.interior = folder + "/interior";
    run.out = folder + "/out_" + name;
    return run;
  }

  // As simulated, without the smooth film deformation.
  PhotoView TrueView(const std::string& photo) const {
    return {
        camera.camera,
        *ReadInteriorResult(InteriorResultPath(folder + "/truth/interior", photo)).photo_from_pixel,
        truth.Find(photo)->pose};
  }

  // As found by interior and exterior orientation.
  PhotoView FoundView(const ExteriorResult& result) const {
    const Raster scan = Raster::Open(folder + "/scans/" + result.photo + ".tif");
    const block::ScanInterior interior = block::FilmGeometry(
        camera, marks, scan, InteriorResultPath(folder + "/interior", result.photo));
    for (const exterior::FilmPosition& position : interior.positions)
      if (position.orientation == result.orientation)
        return {camera.camera, position.photo_from_pixel, *result.pose, position.film_correction};
    throw InputError(result.photo + ": its scan orientation is not the interior's");
  }
};

// A mask of the ground.
class GroundMask {
 public:
  explicit GroundMask(const std::string& path) {
    const Raster raster = Raster::Open(path);
    transform_ = *raster.GeoTransform();
    mask_ = raster.ReadGrey().image;
  }
  bool Touches(const Eigen::Vector3d& at, double half_m) const {
    const auto index = [&](double x, int k) {
      return static_cast<int>(
          std::floor((x - transform_[static_cast<std::size_t>(k)]) / transform_[k == 0 ? 1 : 5]));
    };
    for (int row = index(at.y() + half_m, 3); row <= index(at.y() - half_m, 3); ++row)
      for (int col = index(at.x() - half_m, 0); col <= index(at.x() + half_m, 0); ++col)
        if (row >= 0 && col >= 0 && row < mask_.height && col < mask_.width &&
            mask_.At(col, row) > 0)
          return true;
    return false;
  }

 private:
  std::array<double, 6> transform_{};
  Image mask_;
};

}  // namespace orient::jaw_wu

#include "tests/end_to_end/simulated_block.h"

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "block/inputs/mark_shapes.h"
#include "block/inputs/photo_interior.h"
#include "core/geometry/rotation.h"
#include "core/terrain/photo_view.h"
#include "interior/interior.h"
#include "tests/support/run_orient.h"

namespace orient {
namespace {

Eigen::Vector3d Vector3FromJson(const nlohmann::json& j, const char* x, const char* y,
                                const char* z) {
  return {j.at(x).get<double>(), j.at(y).get<double>(), j.at(z).get<double>()};
}

TruePhoto TruePhotoFromJson(const nlohmann::json& photo, const nlohmann::json& points) {
  const nlohmann::json& pose = photo.at("pose");
  const nlohmann::json& scan = photo.at("scan");
  TruePhoto truth;
  truth.name = photo.at("photo").get<std::string>();
  truth.pose.position_m = Vector3FromJson(pose, "x", "y", "z");
  truth.pose.opk_rad = Vector3FromJson(pose, "omega", "phi", "kappa") * RadFromDeg(1);
  truth.width = scan.at("width");
  truth.height = scan.at("height");
  truth.pixel_size_mm = 1e-3 * scan.at("pixel_size_um").get<double>();
  for (const nlohmann::json& check : photo.at("check")) {
    const auto ground =
        points.at(check.at("point").get<std::size_t>()).get<std::array<double, 3>>();
    const auto pixel = check.at("pixel").get<std::array<double, 2>>();
    truth.seen.push_back({Eigen::Vector3d(ground.data()), Eigen::Vector2d(pixel.data())});
  }
  return truth;
}

}  // namespace

std::vector<TruePhoto> ReadTruth(const std::string& block_folder) {
  std::ifstream file(block_folder + "/truth.json");
  const nlohmann::json json = nlohmann::json::parse(file);
  std::vector<TruePhoto> photos;
  for (const nlohmann::json& photo : json.at("photos"))
    photos.push_back(TruePhotoFromJson(photo, json.at("check_points")));
  return photos;
}

void HarvestOldPhotos(const std::string& block, const std::string& database, int max_per_photo) {
  const auto run = [](const std::vector<std::string>& arguments) {
    const ProgramRun done = RunOrient(arguments);
    if (done.exit_code != 0) throw std::runtime_error(done.err);
  };
  run({"patchdb", "create", database, "--crs", "EPSG:32635"});
  run({"patchdb", "harvest", database, "--camera", block + "/old/camera.toml", "--orientation",
       block + "/old/orientation.csv", "--dem", block + "/dem.tif", "--max-per-photo",
       std::to_string(max_per_photo), block + "/old/photos/*.tif"});
}

SimulationOptions QuickFilm(int photos) {
  SimulationOptions options;
  options.photos = photos;
  options.gsd_m = 0.9;
  options.pixel_size_um = 90;
  options.objects = false;
  options.position_error_m = 3;
  options.attitude_error_deg = 0.5;
  return options;
}

SimulationSummary MakeBlock(const SimulationOptions& options, const std::string& folder) {
  const SimulationSummary summary = Simulate(options, folder);
  HarvestOldPhotos(folder, folder + "/patches.gpkg");
  return summary;
}

double ProjectionRms(const CameraFile& camera, const InteriorResult& interior,
                     const ExteriorResult& exterior, const std::vector<SeenPoint>& seen) {
  if (!exterior.pose || !exterior.orientation || seen.empty()) return std::nan("");
  const auto turned = interior::InOrientation(interior, camera, block::LoadMarkShapes(camera),
                                              *exterior.orientation);
  if (!turned) return std::nan("");
  const PhotoView view{camera.camera, *turned->photo_from_pixel, *exterior.pose,
                       block::CorrectionOf(*turned)};
  double sum = 0;
  for (const SeenPoint& point : seen) {
    const auto pixel = view.PixelFromGround(point.ground_m);
    if (!pixel) return std::nan("");
    sum += (*pixel - point.pixel).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(seen.size()));
}

}  // namespace orient

// The worlds of false_ok: simulated blocks drawn at random, and the inputs given to the program,
// which are at first true and are then falsified (false_ok_faults.h).
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "patchdb/store/patch_database.h"
#include "tools/commands/commands.h"
#include "tools/simulate/simulate.h"

namespace orient::false_ok {
namespace fs = std::filesystem;

// Random numbers that do not depend on the standard library.
class Chance {
 public:
  explicit Chance(std::uint32_t seed) : random_(seed) {}
  std::uint32_t Number() { return static_cast<std::uint32_t>(random_()); }
  double Between(double low, double high) { return low + (high - low) * Number() / 4294967296.0; }
  // Uniform in the logarithm.
  double Scale(double low, double high) { return std::exp(Between(std::log(low), std::log(high))); }
  bool Happens(double probability) { return Between(0, 1) < probability; }
  double Signed(double low, double high) {
    return Happens(0.5) ? Scale(low, high) : -Scale(low, high);
  }
  template <typename List>
  auto& OneOf(List& list) {
    return list[Number() % std::size(list)];
  }
  // Standard normal (Box and Muller 1958).
  double Normal() {
    const double radius = std::sqrt(-2 * std::log(1 - Between(0, 1)));
    return radius * std::cos(2 * std::numbers::pi * Between(0, 1));
  }

 private:
  std::mt19937 random_;
};

// Exit code of an `orient` command; its output goes to `said`.
inline int Run(const std::vector<std::string>& words, std::string* said = nullptr) {
  std::ostringstream out;
  const int code = RunProgram(MakeCommands(), words, out, out);
  if (said) *said = out.str();
  return code;
}

inline void RunWell(const std::vector<std::string>& words) {
  std::string said;
  if (Run(words, &said) != 0) throw InputError("orient " + words[0] + ": " + said);
}

// A block whose photos have some 350 to 1200 pixels per side.
inline SimulationOptions DrawnBlock(Chance& chance) {
  SimulationOptions o;
  constexpr std::array kCameras = {
      CameraPreset::kDemo,    CameraPreset::kDemo,    CameraPreset::kDemo,    CameraPreset::kDemo,
      CameraPreset::kDigital, CameraPreset::kDigital, CameraPreset::kDigital, CameraPreset::kUmk};
  o.camera = chance.OneOf(kCameras);
  o.pixel_size_um = o.camera == CameraPreset::kUmk ? 150 : chance.Scale(90, 170);
  o.photos = 2;
  o.gsd_m = chance.Scale(0.4, 1.2);
  o.kappa_deg = chance.Between(-180, 180);
  o.tilt_deg = chance.Between(0, 3);
  o.relief_m = chance.Scale(10, 250);
  o.dem_cell_m = 10;
  o.change = chance.Between(0, 0.5);
  o.objects = chance.Happens(0.3);
  o.earth = EarthMode::kFlat;
  const bool film = o.camera != CameraPreset::kDigital;
  if (film && chance.Happens(0.5)) o.orientation.reset();
  if (film && chance.Happens(0.3)) o.polarity = Polarity::kNegative;
  o.scan_rotation_deg = chance.Between(0, 1.5);
  o.film_shrink_ppm = chance.Between(0, 600);
  o.film_bend_um = chance.Between(0, 8);
  o.grain = chance.Scale(1, 12);
  o.blur_px = chance.Between(0.3, 1.2);
  o.missing_marks = film && chance.Happens(0.1) ? 1 : 0;
  o.dirty_marks = film && chance.Happens(0.3) ? 1 : 0;
  o.mark_symbols = film && chance.Happens(0.3);
  o.old_gsd_ratio = chance.Scale(0.7, 1.6);
  o.old_height_ratio = chance.Between(1, 2);
  o.old_kappa_deg = chance.Between(-180, 180);
  o.overwrite = true;
  return o;
}

using PixelMap = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;

// What an image shows: a photo of a simulated block, and where the simulator's pixels are in it.
struct Shown {
  std::string folder, photo;
  PixelMap moved = [](const Eigen::Vector2d& pixel) { return pixel; };
};

// The inputs given to the program, and the truth about them.
struct Trial {
  std::string folder;                         // of falsified inputs, and of the results
  std::map<std::string, std::string> photos;  // names, and the scan given for each
  std::string camera, dem, patchdb;
  OrientationTable approximations;
  std::vector<std::string> interior_words, exterior_words;
  std::map<std::string, Shown> shows;
  // The patches and photos are unrelated: no pose is right.
  bool unrelated = false;
  // The camera's marks are wrong, so the transform to the photo system is not judged.
  bool marks_are_wrong = false;
};

class World {
 public:
  World(const std::string& folder, std::uint32_t number) : folder_(folder), chance_(number) {
    options_ = DrawnBlock(chance_);
    options_.seed = number;
    patches_ = static_cast<int>(chance_.Scale(15, 80));
    Make(options_, folder_);
  }

  const std::string& Folder() const { return folder_; }
  const SimulationOptions& Options() const { return options_; }
  Chance& Random() { return chance_; }
  bool Digital() const { return options_.camera == CameraPreset::kDigital; }

  // Different terrain under the same flight, made when first asked for.
  const std::string& Elsewhere() {
    if (elsewhere_.empty()) {
      SimulationOptions other = options_;
      other.seed += 1000003;
      elsewhere_ = folder_ + "_elsewhere";
      Make(other, elsewhere_);
    }
    return elsewhere_;
  }
  // Removes all files of the world.
  void Remove() const {
    fs::remove_all(folder_);
    if (!elsewhere_.empty()) fs::remove_all(elsewhere_);
  }

  // True inputs, except for errors of the approximations of the stated size.
  Trial True(int number) {
    Trial trial;
    trial.folder = folder_ + "/trial_" + std::to_string(number);
    fs::create_directories(trial.folder);
    trial.camera = folder_ + "/camera.toml";
    trial.dem = folder_ + "/dem.tif";
    trial.patchdb = folder_ + "/patches.gpkg";
    trial.exterior_words = {"--earth", "flat"};
    trial.approximations = ReadOrientationTable(folder_ + "/truth/orientation.csv");
    for (OrientationRow& row : trial.approximations.rows) {
      trial.photos[row.photo] = folder_ + "/scans/" + row.photo + ".tif";
      trial.shows[row.photo] = {folder_, row.photo};
      Vector6d pose = row.pose.AsVector();
      for (int i = 0; i < 6; ++i) pose[i] += kSigma[i] * chance_.Normal();
      row.pose = Pose::FromVector(pose);
      row.sigma = kSigma;
    }
    return trial;
  }
  // Sigmas of the approximations: 10 m and 3 degrees.
  inline static const Vector6d kSigma =
      (Vector6d() << 10, 10, 10, Eigen::Vector3d::Constant(3 * std::numbers::pi / 180)).finished();

 private:
  void Make(const SimulationOptions& options, const std::string& folder) const {
    fs::remove_all(folder);  // left by an interrupted run
    Simulate(options, folder);
    const std::string patches = folder + "/patches.gpkg";
    RunWell({"patchdb", "create", patches, "--crs", options.crs});
    RunWell({"patchdb", "harvest", patches, "--camera", folder + "/old/camera.toml",
             "--orientation", folder + "/old/orientation.csv", "--dem", folder + "/dem.tif",
             "--max-per-photo", std::to_string(patches_), folder + "/old/photos/*.tif"});
  }

  std::string folder_, elsewhere_;
  Chance chance_;
  SimulationOptions options_;
  int patches_ = 0;  // per old photo
};

}  // namespace orient::false_ok

// How often photos of known orientation are oriented from random starts, and how often wrongly.
//
//   exterior_trials --photos P... --camera C --truth T --dem D --patchdb DB [--position-m 600]
//                   [--attitude-deg 6] [--kappa-unknown] [--stated 1] [--shift-m 0]
//                   [--shift-together] [--trials 10] [--seed 1]
//
// Each trial displaces every photo (of a digital camera) by `position-m` in a random horizontal
// direction, and in height by at most this and at most a fifth of the flying height, tilts it by
// `attitude-deg` in a random direction, and rotates it by at most the same or by any angle. The
// accuracy stated to the program is `stated` times that error. With `shift-m`, the patches are at
// wrong positions: each is moved by that much in its own direction, or all in the same one.
// Prints how many photos end ok, weak and failed, for those that are ok the RMS reprojection
// difference to the truth over the whole frame and its value expected from the covariances, and the
// false accepts: ok, but off by more than 3 px.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <limits>
#include <numbers>
#include <random>

#include "block/stages/exterior_stage.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/geometry/collinearity.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/reprojection.h"
#include "patchdb/store/patch_database.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr double kFalse_px = 3;

struct TrialOptions {
  block::ExteriorRunOptions run;
  std::string truth;
  double position_m = 600, attitude_deg = 6, stated = 1, shift_m = 0;
  bool kappa_unknown = false, shift_together = false;
  int trials = 10;
  unsigned seed = 1;
};

// Uniform in [-1, 1].
double Unit(std::mt19937& random) { return static_cast<double>(random()) / 2147483648.0 - 1; }

Eigen::Vector2d Direction(std::mt19937& random) {
  const double angle = std::numbers::pi * Unit(random);
  return {std::cos(angle), std::sin(angle)};
}

OrientationTable Disturbed(const OrientationTable& truth, double ground_m,
                           const TrialOptions& options, std::mt19937& random) {
  OrientationTable table = truth;
  const double tilt = RadFromDeg(options.attitude_deg);
  const double turn = options.kappa_unknown ? std::numbers::pi : tilt;
  for (OrientationRow& row : table.rows) {
    const double height = std::min(options.position_m, 0.2 * (row.pose.position_m.z() - ground_m));
    row.pose.position_m.head<2>() += options.position_m * Direction(random);
    row.pose.position_m.z() += height * Unit(random);
    row.pose.opk_rad.head<2>() += tilt * Direction(random);
    row.pose.opk_rad.z() = NormalizeAngle(row.pose.opk_rad.z() + turn * Unit(random));
    Vector6d sigma;
    sigma << options.position_m, options.position_m, height, tilt, tilt, turn;
    row.sigma = options.stated * sigma;
  }
  return table;
}

void StoreShifted(const TrialOptions& options, const std::string& to, std::mt19937& random) {
  const patchdb::PatchDatabase known =
      patchdb::PatchDatabase::Open(options.run.patchdb, patchdb::PatchDatabase::Mode::kRead);
  std::vector<patchdb::Patch> patches = known.ListPatches(0, std::numeric_limits<int>::max());
  const Eigen::Vector2d together = Direction(random);
  for (patchdb::Patch& patch : patches) {
    patch.id = patch.source_id = 0;
    patch.ground_m.head<2>() +=
        options.shift_m * (options.shift_together ? together : Direction(random));
  }
  patchdb::PatchSource source;
  source.name = "another place";
  source.gsd_m = patches.front().gsd_m;
  fs::remove(to);
  patchdb::PatchDatabase::Create(to, known.GroundCrs()).AddSource(source, patches);
}

// The RMS reprojection difference over the frame expected from the result's covariance; ground
// at the DEM's mean height.
double StatedRms(PhotoView view, const ExteriorResult& result, double ground_m) {
  constexpr int kGrid = 10;
  view.pose = *result.pose;
  const Affine2d pixel_from_photo = view.photo_from_pixel.Inverse();
  double sum = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const Eigen::Vector2d share((i + 0.5) / kGrid, (j + 0.5) / kGrid);
      const Ray ray = *GroundRayFromPhoto(
          view.camera, view.pose,
          view.PhotoFromPixel(share.cwiseProduct(view.camera.image_px->cast<double>())));
      const Eigen::Vector3d ground =
          ray.origin_m + ray.direction * ((ground_m - ray.origin_m.z()) / ray.direction.z());
      const auto d = PhotoFromGroundWithDerivatives(view.camera, view.pose, ground);
      const Eigen::Matrix<double, 2, 6> by_pose = pixel_from_photo.A * d->by_pose;
      sum += (by_pose * *result.covariance * by_pose.transpose()).trace();
    }
  return std::sqrt(sum / (kGrid * kGrid));
}

double Median(std::vector<double>* values) {
  std::sort(values->begin(), values->end());
  return (*values)[values->size() / 2];
}

struct Counts {
  int ok = 0, weak = 0, failed = 0, wrong = 0, weak_wrong = 0;
  std::vector<double> rms_px, stated_px;

  void Add(Status status, double rms, double stated) {
    const bool off = !(rms <= kFalse_px);
    if (status == Status::kOk) {
      ++ok;
      rms_px.push_back(rms);
      stated_px.push_back(stated);
      wrong += off ? 1 : 0;
    } else if (status == Status::kWeak) {
      ++weak;
      weak_wrong += off ? 1 : 0;
    } else {
      ++failed;
    }
  }
  void Print(const std::string& name) {
    std::printf("%-30s %4d ok %4d weak %4d failed, false %d (weak and off %d)", name.c_str(), ok,
                weak, failed, wrong, weak_wrong);
    if (!rms_px.empty())
      std::printf(", rms %.3f px median, %.3f worst (stated %.3f)", Median(&rms_px),
                  *std::max_element(rms_px.begin(), rms_px.end()), Median(&stated_px));
    std::printf("\n");
  }
};

void Run(TrialOptions options) {
  const Camera camera = ReadCameraFile(options.run.camera).camera;
  const OrientationTable truth = ReadOrientationTable(options.truth);
  const GroundSurface surface = GroundSurface::FromFile(options.run.dem, *truth.crs);
  const fs::path folder =
      fs::temp_directory_path() / ("exterior_trials_" + std::to_string(std::random_device{}()));
  fs::create_directory(folder);
  options.run.approximations = folder / "start.csv";
  options.run.out = folder / "out";
  std::mt19937 random(options.seed);
  const std::string true_patches = options.run.patchdb;
  std::map<std::string, Counts> counts;
  Counts all;
  for (int trial = 0; trial < options.trials; ++trial) {
    if (options.shift_m > 0) {
      options.run.patchdb = true_patches;
      StoreShifted(options, folder / "shifted.gpkg", random);
      options.run.patchdb = folder / "shifted.gpkg";
    }
    WriteOrientationTable(options.run.approximations,
                          Disturbed(truth, surface.MeanHeight(), options, random));
    for (const ExteriorResult& result : block::RunExterior(options.run)) {
      const PhotoView view{camera, DigitalPhotoFromPixel(camera), truth.Find(result.photo)->pose};
      const double rms = result.pose ? ReprojectionRms(view, *result.pose, camera.image_px->x(),
                                                       camera.image_px->y(), surface)
                                     : std::nan("");
      const double stated =
          result.pose ? StatedRms(view, result, surface.MeanHeight()) : std::nan("");
      counts[result.photo].Add(result.status, rms, stated);
      all.Add(result.status, rms, stated);
      if (result.status != Status::kOk || rms > kFalse_px)
        std::printf("trial %d, %s: %s, %.1f px: %s\n", trial, result.photo.c_str(),
                    std::string(Name(result.status)).c_str(), rms,
                    result.findings.empty() ? "" : Sentence(result.findings.back()).c_str());
    }
  }
  fs::remove_all(folder);
  for (auto& [photo, of] : counts) of.Print(photo);
  all.Print("all");
  std::printf("%.1f s of processor time a photo\n",
              static_cast<double>(std::clock()) / CLOCKS_PER_SEC /
                  static_cast<double>(options.trials) /
                  static_cast<double>(options.run.photos.size()));
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  orient::TrialOptions options;
  CLI::App app("Orients photos of known orientation from random starts");
  app.add_option("--photos", options.run.photos)->required();
  app.add_option("--camera", options.run.camera)->required();
  app.add_option("--truth", options.truth)->required();
  app.add_option("--dem", options.run.dem)->required();
  app.add_option("--patchdb", options.run.patchdb)->required();
  app.add_option("--position-m", options.position_m);
  app.add_option("--attitude-deg", options.attitude_deg);
  app.add_flag("--kappa-unknown", options.kappa_unknown);
  app.add_option("--stated", options.stated);
  app.add_option("--shift-m", options.shift_m);
  app.add_flag("--shift-together", options.shift_together);
  app.add_option("--trials", options.trials);
  app.add_option("--seed", options.seed);
  CLI11_PARSE(app, argc, argv);
  try {
    orient::Run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "exterior_trials: %s\n", error.what());
    return 2;
  }
  return 0;
}

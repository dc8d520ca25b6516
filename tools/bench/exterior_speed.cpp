// Time and memory of the exterior orientation of one large photo, compared with SIFT and RANSAC PnP
// (OpenCV) with the same control.
//
//   exterior_speed DIR [FAR]
//
// DIR is made if it is missing: a simulated scan of 9200 x 9200 px (23 cm film at 1:10 000, 25 um)
// and an orthophoto of an older date from which patches are harvested. Prints, all in one run and
// each in its own process, the processor time, wall-clock time and peak memory of
//   - all of `orient exterior` for the photo from an approximation of 10 m and 3 degrees, with 30,
//     60, 120 and 240 patches;
//   - the same with 60 and 240 patches from wide starts: kappa unknown, off by 100 m and 10 degrees
//     (one sigma), five draws;
//   - SIFT on the photo (in tiles, or it would take 15 GB) and on the chips of the 60 patches,
//     matching (ratio test), solvePnPRansac; and the ratio of both methods, for both times;
//   - the same 60 patches in databases with 1e3, 1e4 ... FAR (100000) patches elsewhere.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <sstream>
#include <stdexcept>

#include "block/stages/exterior_stage.h"
#include "block/stages/harvest_stage.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "exterior/steps/predict.h"
#include "patchdb/store/patch_database.h"
#include "tools/commands/memory.h"
#include "tools/simulate/simulate.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr int kPatches = 60;
constexpr int kTile_px = 2300;
constexpr double kRatioTest = 0.8;
constexpr double kPnpReach_px = 3;

struct Cost {
  double seconds = 0, on_the_clock_s = 0, megabytes = 0;  // seconds: processor time of all cores
};

// Runs the work in its own process. Throws if it fails.
Cost Measure(const std::string& what, const std::function<void()>& work) {
  std::fflush(stdout);
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("cannot fork");
  if (child == 0) {
    try {
      work();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", what.c_str(), error.what());
      std::_Exit(1);
    }
    std::fflush(stdout);
    std::_Exit(0);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  const std::chrono::duration<double> clock = std::chrono::steady_clock::now() - begin;
  if (status != 0) throw std::runtime_error(what + " failed");
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {seconds(usage.ru_utime) + seconds(usage.ru_stime), clock.count(),
          static_cast<double>(usage.ru_maxrss) / 1024};
}

struct Data {
  std::string folder;
  std::string photo;
  CameraFile camera;
  OrientationTable truth;
  std::string At(const std::string& name) const { return folder + "/" + name; }
};

void MakeData(const std::string& folder) {
  SimulationOptions options;
  options.camera = CameraPreset::kRc10;
  options.photos = 1;
  options.pixel_size_um = 25;
  options.objects = false;
  options.ortho = true;
  Simulate(options, folder);
  block::HarvestRun run;
  run.dem = folder + "/dem.tif";
  run.options = patchdb::OrthoHarvestOptions();
  run.options.chip_px = 61;
  run.options.max_count = 900;  // enough for 240 spread over the photo
  patchdb::PatchDatabase database =
      patchdb::PatchDatabase::Create(folder + "/all.gpkg", Crs::Parse(options.crs, "simulation"));
  block::HarvestOrthophotos(database, run, {folder + "/old/ortho.tif"});
}

Data Open(const std::string& folder) {
  if (!fs::exists(folder + "/all.gpkg")) {
    const Cost cost = Measure("making the data", [&] { MakeData(folder); });
    std::printf("made %s in %.0f s\n", folder.c_str(), cost.seconds);
  }
  Data data{folder, "", ReadCameraFile(folder + "/camera.toml"),
            ReadOrientationTable(folder + "/truth/orientation.csv")};
  data.photo = data.At("scans/" + data.truth.rows.front().photo + ".tif");
  return data;
}

// `count` of the harvested patches, spread over the photo.
std::vector<patchdb::Patch> Spread(const Data& data, int count) {
  const patchdb::PatchDatabase all =
      patchdb::PatchDatabase::Open(data.At("all.gpkg"), patchdb::PatchDatabase::Mode::kRead);
  std::vector<patchdb::Patch> patches = all.ListPatches(0, std::numeric_limits<int>::max());
  const InteriorResult interior = ReadInteriorResult(
      InteriorResultPath(data.At("truth/interior"), data.truth.rows.front().photo));
  const PhotoView view{data.camera.camera, *interior.photo_from_pixel,
                       data.truth.rows.front().pose};
  exterior::PredictionOptions options;
  options.width_px = interior.width;
  options.height_px = interior.height;
  options.border_px = 60;
  const auto seen = exterior::Predict(view, Matrix6d::Zero(), patches, options);
  std::vector<patchdb::Patch> spread;
  for (const exterior::PatchPrediction& p : exterior::SelectSpread(seen, patches, count, options)) {
    spread.push_back(patches[p.patch]);
    spread.back().id = spread.back().source_id = 0;
  }
  if (static_cast<int>(spread.size()) < count)
    throw std::runtime_error("the orthophoto gave only " + std::to_string(spread.size()) +
                             " patches in the photo");
  return spread;
}

// Stores the patches, and `far` small ones outside the footprint.
std::string Store(const Data& data, std::vector<patchdb::Patch> patches, int far) {
  std::string path = data.At("some.gpkg");
  fs::remove(path);
  patchdb::PatchDatabase database = patchdb::PatchDatabase::Create(path, *data.truth.crs);
  patchdb::PatchSource source;
  source.name = "photo";
  source.gsd_m = patches.front().gsd_m;
  patchdb::Patch elsewhere = patches.front();
  elsewhere.chip = Image(11, 11, 100);
  elsewhere.heights = {3, 5 * elsewhere.gsd_m, std::vector<float>(9, 100)};
  const Eigen::Vector2d west = elsewhere.ground_m.head<2>() - Eigen::Vector2d(300000, 0);
  database.AddSource(source, patches);
  constexpr int kAtOnce = 10000;
  for (int done = 0; done < far; done += kAtOnce) {
    std::vector<patchdb::Patch> more(static_cast<std::size_t>(std::min(kAtOnce, far - done)),
                                     elsewhere);
    for (std::size_t i = 0; i < more.size(); ++i) {
      const int place = done + static_cast<int>(i);
      more[i].ground_m.head<2>() = west + 200 * Eigen::Vector2d(place % 1000, place / 1000);
    }
    patchdb::PatchSource another = source;
    another.name = "far " + std::to_string(done);
    database.AddSource(another, more);
  }
  return path;
}

Cost Ours(const Data& data, const std::string& database,
          const std::string& approximations = "approx.csv") {
  return Measure("orient exterior", [&] {
    KeepReleasedMemory();
    block::ExteriorRunOptions options;
    options.photos = {data.photo};
    options.camera = data.At("camera.toml");
    options.approximations = data.At(approximations);
    options.dem = data.At("dem.tif");
    options.patchdb = database;
    options.interior = data.At("truth/interior");
    options.out = data.At("out");
    const ExteriorResult result = block::RunExterior(options).front();
    int matched = 0;
    for (const PatchResult& patch : result.patches)
      matched += patch.state == PatchState::kMatched ? 1 : 0;
    const Pose& truth = data.truth.rows.front().pose;
    std::printf("  %s, %d matched, projection centre off by %.2f m: ",
                std::string(Name(result.status)).c_str(), matched,
                result.pose ? (result.pose->position_m - truth.position_m).norm() : -1);
  });
}

// Writes a table with the true pose plus random errors of these sigmas; kappa is arbitrary.
std::string WideStart(const Data& data, unsigned draw) {
  constexpr double kPosition_m = 100, kTilt_rad = 10 * std::numbers::pi / 180;
  std::mt19937 random(draw);
  std::normal_distribution<double> normal;
  OrientationTable table = data.truth;
  OrientationRow& row = table.rows.front();
  for (int i = 0; i < 3; ++i) row.pose.position_m[i] += kPosition_m * normal(random);
  for (int i = 0; i < 2; ++i) row.pose.opk_rad[i] += kTilt_rad * normal(random);
  row.pose.opk_rad.z() =
      std::uniform_real_distribution(-std::numbers::pi, std::numbers::pi)(random);
  row.sigma.emplace();
  *row.sigma << Eigen::Vector3d::Constant(kPosition_m), kTilt_rad, kTilt_rad, std::numbers::pi;
  std::string name = "wide.csv";
  WriteOrientationTable(data.At(name), table);
  return name;
}

cv::Mat Grey(const Image& chip) {
  cv::Mat grey(chip.height, chip.width, CV_8U);
  for (int row = 0; row < chip.height; ++row)
    for (int col = 0; col < chip.width; ++col) {
      const float value = chip.At(col, row);
      grey.at<std::uint8_t>(row, col) =
          std::isnan(value) ? 0 : cv::saturate_cast<std::uint8_t>(value);
    }
  return grey;
}

struct Features {
  std::vector<cv::Point2f> pixels;
  cv::Mat descriptors;
};

Features OfPhoto(const std::string& path, cv::SIFT& sift) {
  const cv::Mat photo = cv::imread(path, cv::IMREAD_GRAYSCALE);
  Features all;
  for (int row = 0; row < photo.rows; row += kTile_px)
    for (int col = 0; col < photo.cols; col += kTile_px) {
      const cv::Rect tile(col, row, std::min(kTile_px, photo.cols - col),
                          std::min(kTile_px, photo.rows - row));
      std::vector<cv::KeyPoint> points;
      cv::Mat descriptors;
      sift.detectAndCompute(photo(tile), cv::noArray(), points, descriptors);
      for (const cv::KeyPoint& p : points)
        all.pixels.emplace_back(p.pt + cv::Point2f(cv::Point(col, row)));
      if (!points.empty()) all.descriptors.push_back(descriptors);
    }
  return all;
}

// Ground points of a chip's features, relative to `origin`.
void OfPatch(const patchdb::Patch& patch, const Eigen::Vector3d& origin, cv::SIFT& sift,
             std::vector<cv::Point3d>* ground, cv::Mat* descriptors) {
  std::vector<cv::KeyPoint> points;
  cv::Mat of_chip;
  sift.detectAndCompute(Grey(patch.chip), cv::noArray(), points, of_chip);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double east = (points[i].pt.x + 0.5 - patch.chip.width / 2.0) * patch.gsd_m;
    const double north = (patch.chip.height / 2.0 - points[i].pt.y - 0.5) * patch.gsd_m;
    const double height = patch.heights.At(east, north);
    if (std::isnan(height)) continue;
    const Eigen::Vector3d at = patch.ground_m + Eigen::Vector3d(east, north, 0) - origin;
    ground->emplace_back(at.x(), at.y(), height - origin.z());
    descriptors->push_back(of_chip.row(static_cast<int>(i)));
  }
}

void SiftPnp(const Data& data, const std::vector<patchdb::Patch>& patches) {
  const auto sift = cv::SIFT::create();
  const Features photo = OfPhoto(data.photo, *sift);
  const Eigen::Vector3d origin = patches.front().ground_m;
  std::vector<cv::Point3d> ground, found;
  cv::Mat descriptors;
  for (const patchdb::Patch& patch : patches) OfPatch(patch, origin, *sift, &ground, &descriptors);
  std::vector<std::vector<cv::DMatch>> matches;
  cv::FlannBasedMatcher().knnMatch(descriptors, photo.descriptors, matches, 2);
  const Camera& camera = data.camera.camera;
  const InteriorResult interior = ReadInteriorResult(
      InteriorResultPath(data.At("truth/interior"), data.truth.rows.front().photo));
  std::vector<cv::Point2d> seen;
  for (const auto& pair : matches) {
    if (pair.size() < 2 || pair[0].distance > kRatioTest * pair[1].distance) continue;
    const cv::Point2f& pixel = photo.pixels[static_cast<std::size_t>(pair[0].trainIdx)];
    const Eigen::Vector2d mm =
        *interior.photo_from_pixel * Eigen::Vector2d(pixel.x + 0.5, pixel.y + 0.5);
    const auto ideal = UndistortPoint(camera.lens, mm - camera.principal_point_mm);
    if (!ideal) continue;
    seen.emplace_back(ideal->x(), -ideal->y());
    found.push_back(ground[static_cast<std::size_t>(pair[0].queryIdx)]);
  }
  std::printf("  %zu features, %zu matches, ", photo.pixels.size(), seen.size());
  if (seen.size() < 4) {
    std::printf("no pose: ");
    return;
  }
  const double c = camera.principal_distance_mm;
  const cv::Matx33d K(c, 0, 0, 0, c, 0, 0, 0, 1);
  cv::Mat turn, shift, inliers;
  const bool solved = cv::solvePnPRansac(found, seen, K, cv::noArray(), turn, shift, false, 5000,
                                         static_cast<float>(kPnpReach_px * 0.025), 0.99, inliers);
  cv::Mat rotation;
  cv::Rodrigues(turn, rotation);
  const cv::Mat centre = -rotation.t() * shift;
  const Eigen::Vector3d at =
      origin + Eigen::Vector3d(centre.at<double>(0), centre.at<double>(1), centre.at<double>(2));
  std::printf("%d inliers, projection centre off by %.2f m: ", solved ? inliers.rows : 0,
              (at - data.truth.rows.front().pose.position_m).norm());
}

void Print(const Cost& cost) {
  std::printf("%.2f s, %.2f s on the clock, %.0f MB\n", cost.seconds, cost.on_the_clock_s,
              cost.megabytes);
}

void Run(const std::string& folder, int most_far) {
  const Data data = Open(folder);
  Cost ours;
  for (const int count : {30, 60, 120, 240}) {
    std::printf("orient exterior, %d patches\n", count);
    const Cost cost = Ours(data, Store(data, Spread(data, count), 0));
    Print(cost);
    if (count == kPatches) ours = cost;
  }
  for (const int count : {kPatches, 240}) {
    const std::string database = Store(data, Spread(data, count), 0);
    std::printf("orient exterior, %d patches, wide starts\n", count);
    for (unsigned draw = 1; draw <= 5; ++draw) Print(Ours(data, database, WideStart(data, draw)));
  }
  const std::vector<patchdb::Patch> patches = Spread(data, kPatches);
  for (int far = 1000; far <= most_far; far *= 10) {
    const std::string database = Store(data, patches, far);
    std::printf("orient exterior, %d patches and %d elsewhere\n", kPatches, far);
    Print(Ours(data, database));
  }
  std::printf("SIFT and RANSAC PnP, %d patches\n", kPatches);
  const Cost sift = Measure("SIFT", [&] { SiftPnp(data, patches); });
  Print(sift);
  std::printf("ratio: 1 / %.1f, on the clock 1 / %.1f\n", sift.seconds / ours.seconds,
              sift.on_the_clock_s / ours.on_the_clock_s);
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: exterior_speed DIR [FAR]\n");
    return 1;
  }
  try {
    orient::Run(argv[1], argc > 2 ? std::atoi(argv[2]) : 100000);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "exterior_speed: %s\n", error.what());
    return 2;
  }
  return 0;
}

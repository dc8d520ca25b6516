// Whether the covariance of the exterior orientation is realistic: normalised errors of the pose
// over many simulated photos.
//
//   exterior_honesty FOLDER [BLOCKS] [SUBSETS] [exchanged]
//
// Simulates BLOCKS small blocks of eight digital photos in FOLDER (kept: a second run is faster),
// flat to mountainous, with houses and trees, harvests their old photos, and orients each photo
// SUBSETS times: each time from a different start (10 m and 3 degrees), with 20, 40 or 80 patches
// drawn at random from the whole photo or from half of it, and with height errors of the size
// stated by the patches: half of the variance is common to all, half is a random field over the
// ground. Prints for each of the six elements the RMS of the normalised errors (1 if realistic),
// the same for the axes of the covariance ellipsoid from the best determined to the worst (of the
// correlation matrix of the elements), and how often the 95 % ellipsoid contains the truth. Then
// the precision of matches: deviations of the matches used from the true image positions of their
// patches, normalised by the sigma from matching together with that of effects it cannot detect
// (kMatchModelSigma_px).
//
// With `exchanged`, every patch is placed where another one belongs: no photo may be ok or weak.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/matching/least_squares_matching.h"
#include "core/terrain/photo_view.h"
#include "exterior/orient_photo.h"
#include "exterior/steps/error_model.h"
#include "patchdb/store/patch_database.h"
#include "tools/commands/commands.h"
#include "tools/simulate/simulate.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr double kChi2Of95 = 12.59;  // six degrees of freedom

void Run(const std::vector<std::string>& arguments) {
  if (RunProgram(MakeCommands(), arguments, std::cout, std::cerr) != 0)
    throw InputError("orient " + arguments[0] + " failed");
}

// Makes the block if it does not exist yet.
void MakeBlock(const std::string& folder, std::uint32_t seed) {
  if (fs::exists(folder + "/patches.gpkg")) return;
  SimulationOptions options;
  options.camera = CameraPreset::kDigital;
  options.seed = seed;
  options.gsd_m = 0.5;
  options.pixel_size_um = 40;
  constexpr std::array kRelief = {30.0, 100.0, 180.0, 250.0};
  options.photos = 8;
  options.relief_m = kRelief[seed % kRelief.size()];
  options.old_gsd_ratio = 1;
  options.change = 0.3;
  options.overwrite = true;
  Simulate(options, folder);
  Run({"patchdb", "create", folder + "/patches.part.gpkg", "--crs", options.crs});
  Run({"patchdb", "harvest", folder + "/patches.part.gpkg", "--camera", folder + "/old/camera.toml",
       "--orientation", folder + "/old/orientation.csv", "--dem", folder + "/dem.tif",
       "--max-per-photo", "600", folder + "/old/photos/*.tif"});
  fs::rename(folder + "/patches.part.gpkg", folder + "/patches.gpkg");
}

struct Tally {
  Vector6d squares = Vector6d::Zero(), along_axes = Vector6d::Zero();
  int ok = 0, weak = 0, failed = 0, inside = 0;

  void Add(const ExteriorResult& result, const Pose& truth) {
    if (result.status == Status::kFailed) ++failed;
    if (result.status == Status::kWeak) ++weak;
    if (result.status != Status::kOk) return;
    ++ok;
    const Vector6d sigma = result.covariance->diagonal().cwiseSqrt();
    const Vector6d error = PoseDifference(*result.pose, truth).cwiseQuotient(sigma);
    squares += error.cwiseAbs2();
    const Eigen::SelfAdjointEigenSolver<Matrix6d> axes(
        sigma.cwiseInverse().asDiagonal() * *result.covariance * sigma.cwiseInverse().asDiagonal());
    const Vector6d along =
        (axes.eigenvectors().transpose() * error).cwiseAbs2().cwiseQuotient(axes.eigenvalues());
    along_axes += along;
    inside += along.sum() < kChi2Of95 ? 1 : 0;
  }
  void Add(const Tally& other) {
    squares += other.squares;
    along_axes += other.along_axes;
    ok += other.ok;
    weak += other.weak;
    failed += other.failed;
    inside += other.inside;
  }
  void Print(const std::string& name) const {
    std::printf("%-22s %4d ok %3d weak %3d failed |", name.c_str(), ok, weak, failed);
    for (const Vector6d& sum : {squares, along_axes}) {
      for (const double square : sum) std::printf(" %.2f", std::sqrt(square / std::max(ok, 1)));
      std::printf(" |");
    }
    std::printf(" %.1f %%\n", 100.0 * inside / std::max(ok, 1));
    std::fflush(stdout);
  }
};

// Height errors shared by all patches of a trial: a random field over the ground, drawn as a sum of
// plane waves, with half of its variance the same everywhere. The wave numbers are those of an
// exponentially decreasing correlation (Cauchy distribution in the plane).
class HeightError {
 public:
  HeightError(double length_m, std::mt19937& random) {
    std::normal_distribution<double> normal;
    common_ = std::sqrt(0.5) * normal(random);
    for (Wave& wave : waves_) {
      wave.number = Eigen::Vector2d(normal(random), normal(random)) / (normal(random) * length_m);
      wave.phase = 2 * std::numbers::pi * static_cast<double>(random()) / 4294967296.0;
    }
  }
  // The height error for a standard deviation of 1.
  double At(const Eigen::Vector3d& ground_m) const {
    double sum = 0;
    for (const Wave& wave : waves_)
      sum += std::cos(wave.number.dot(ground_m.head<2>()) + wave.phase);
    return common_ + sum / std::sqrt(static_cast<double>(waves_.size()));
  }

 private:
  struct Wave {
    Eigen::Vector2d number = Eigen::Vector2d::Zero();
    double phase = 0;
  };
  double common_ = 0;
  std::array<Wave, 40> waves_;
};

// Errors of one coordinate, in scan pixels and normalised. Medians, because patches beside trees
// and houses have additional errors.
class MatchTally {
 public:
  // `patches`: their true positions.
  void Add(const ExteriorResult& result, const PhotoView& truth,
           const std::map<std::int64_t, Eigen::Vector3d>& patches) {
    if (result.status != Status::kOk) return;
    for (const PatchResult& match : result.patches) {
      if (match.state != PatchState::kMatched || !match.pixel || !match.sigma_px) continue;
      const auto pixel = truth.PixelFromGround(patches.at(match.id));
      if (!pixel) continue;
      for (int i = 0; i < 2; ++i) {
        const double error = std::abs((*match.pixel - *pixel)[i]);
        errors_.push_back(error);
        normalised_.push_back(error / std::hypot((*match.sigma_px)[i], kMatchModelSigma_px));
        sigmas_.push_back((*match.sigma_px)[i]);
      }
    }
  }
  void Print() {
    constexpr double kMedianOfNormal = 0.6745;
    if (errors_.empty()) return;
    std::printf(
        "%zu matches: a coordinate's error %.3f px, stated by matching %.3f, normalised %.2f (by "
        "medians)\n",
        errors_.size() / 2, UpperMedian(errors_) / kMedianOfNormal, UpperMedian(sigmas_),
        UpperMedian(normalised_) / kMedianOfNormal);
  }

 private:
  std::vector<double> errors_, normalised_, sigmas_;
};

class Block {
 public:
  Block(const std::string& folder, bool exchanged)
      : folder_(folder),
        camera_(ReadCameraFile(folder + "/camera.toml").camera),
        truth_(ReadOrientationTable(folder + "/truth/orientation.csv")),
        patches_(patchdb::PatchDatabase::Open(folder + "/patches.gpkg",
                                              patchdb::PatchDatabase::Mode::kRead)
                     .ListPatches(0, std::numeric_limits<int>::max())) {
    for (const patchdb::Patch& patch : patches_) places_[patch.id] = patch.ground_m;
    if (exchanged) Exchange();
  }

  // Orients every photo of the block `subsets` times; a tally for each number of patches.
  void Orient(int subsets, std::mt19937& random, std::map<std::string, Tally>* tallies,
              MatchTally* matches) const {
    constexpr std::array<std::size_t, 3> kPatches = {20, 40, 80};
    for (const OrientationRow& row : truth_.rows) {
      const Raster raster = Raster::Open(folder_ + "/scans/" + row.photo + ".tif");
      const exterior::PhotoImage image(raster, false);
      for (int i = 0; i < subsets; ++i) {
        const std::size_t count = kPatches[random() % kPatches.size()];
        const bool half = random() % 3 == 0;
        const auto patches = Some(row.pose, half, count, random);
        const ExteriorResult result = exterior::OrientPhoto(Start(row, random), image, patches);
        (*tallies)[std::to_string(count) + (half ? " in a half" : " all over")].Add(result,
                                                                                    row.pose);
        matches->Add(result, ViewAt(row.pose), places_);
      }
    }
  }

 private:
  // Moves each chip and its heights to the position of a patch far from it in the list.
  void Exchange() {
    const std::vector<patchdb::Patch> all = patches_;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const patchdb::Patch& from = all[(i + all.size() / 3) % all.size()];
      patches_[i].chip = from.chip;
      patches_[i].heights = from.heights;
      const auto lift = static_cast<float>(patches_[i].ground_m.z() - from.ground_m.z());
      for (float& height : patches_[i].heights.heights_m) height += lift;
    }
  }

  exterior::PhotoToOrient Start(const OrientationRow& row, std::mt19937& random) const {
    std::normal_distribution<double> normal;
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(10), Eigen::Vector3d::Constant(RadFromDeg(3));
    Vector6d start = row.pose.AsVector();
    for (int i = 0; i < 6; ++i) start[i] += sigma[i] * normal(random);
    exterior::FilmPosition position;
    position.photo_from_pixel = DigitalPhotoFromPixel(camera_);
    return {
        row.photo, camera_, {position}, {Pose::FromVector(start), sigma.cwiseAbs2().asDiagonal()}};
  }

  PhotoView ViewAt(const Pose& pose) const {
    return {camera_, DigitalPhotoFromPixel(camera_), pose};
  }

  // Random patches visible in the photo, with their own draw of height errors.
  std::vector<patchdb::Patch> Some(const Pose& pose, bool half, std::size_t count,
                                   std::mt19937& random) const {
    const PhotoView view = ViewAt(pose);
    std::vector<patchdb::Patch> some;
    for (const patchdb::Patch& patch : patches_) {
      const auto pixel = view.PixelFromGround(patch.ground_m);
      if (!pixel || !camera_.InFrame(view.PhotoFromPixel(*pixel))) continue;
      if (half && 2 * pixel->x() > camera_.image_px->x()) continue;
      some.push_back(patch);
    }
    std::shuffle(some.begin(), some.end(), random);
    if (some.size() > count) some.resize(count);
    const HeightError error(exterior::kHeightCorrelationPerHeight *
                                (pose.position_m.z() - patches_.front().ground_m.z()),
                            random);
    for (patchdb::Patch& patch : some) {
      const Eigen::Vector3d move =
          error.At(patch.ground_m) * patch.height_sigma_m.value() * patch.height_effect.value();
      patch.ground_m += move;
      for (float& height : patch.heights.heights_m) height += static_cast<float>(move.z());
    }
    return some;
  }

  std::string folder_;
  Camera camera_;
  OrientationTable truth_;
  std::vector<patchdb::Patch> patches_;
  std::map<std::int64_t, Eigen::Vector3d> places_;
};

int Main(const std::string& folder, int blocks, int subsets, bool exchanged) {
  std::printf(
      "RMS of normalised errors: x y z omega phi kappa | best .. worst axis | in the 95 %% "
      "ellipsoid\n");
  std::map<std::string, Tally> tallies;
  MatchTally matches;
  std::mt19937 random(1);
  for (int b = 1; b <= blocks; ++b) {
    const std::string name = folder + "/block_" + std::to_string(b);
    MakeBlock(name, static_cast<std::uint32_t>(100 + b));
    std::map<std::string, Tally> of_block;
    Block(name, exchanged).Orient(subsets, random, &of_block, &matches);
    Tally sum;
    for (const auto& [kind, tally] : of_block) {
      sum.Add(tally);
      tallies[kind].Add(tally);
    }
    sum.Print("block " + std::to_string(b));
  }
  Tally all;
  for (const auto& [kind, tally] : tallies) {
    tally.Print(kind);
    all.Add(tally);
  }
  all.Print("all");
  matches.Print();
  return 0;
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  const auto number = [&](int i, int otherwise) {
    return argc > i ? std::atoi(argv[i]) : otherwise;
  };
  if (argc < 2) {
    std::fprintf(stderr, "usage: exterior_honesty FOLDER [BLOCKS] [SUBSETS] [exchanged]\n");
    return 1;
  }
  try {
    return orient::Main(argv[1], number(2, 8), number(3, 4),
                        argc > 4 && std::string(argv[4]) == "exchanged");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "exterior_honesty: %s\n", error.what());
    return 2;
  }
}

// Jaw & Wu's two experiments and a harder one with simulated photos: how many patches are matched,
// and the errors of ground points from a single photo and from a stereo pair.
//
//   exterior_jaw_wu FOLDER fine|coarse|hard|mountains [WORLDS] [rc10]
//
// Simulates WORLDS worlds in FOLDER (kept: a second run is faster) at two dates: different hour and
// season, some of the parcels and houses changed, the old photos digital and from another direction
// and height, the new ones scanned film of 25 um at 1:10 000 (GSD 0.25 m).
//   fine    old photos of 7.5 cm, a fifth of the parcels changed (half of them inverted)
//   coarse  old photos of 25 cm, 0.3 of the parcels changed
//   hard    50 um and 2 m, 1200 m of relief, half of the parcels changed (inverted in a third of
//           all), approximations off by 100 m, 10 degrees and any kappa; with all patches and with
//           the best 30 of each photo
//   mountains  the same with a fifth of the parcels changed
// The film has a frame of 6 cm, or of 23 cm with rc10. `fine` and `coarse`: 30 patches per photo of
// a stereo pair, interior orientation with `orient interior`, three starts with errors and stated
// accuracies of 10 m and 3 degrees, 5 m and 1 degree, 1 m and 1 minute. Once with the best patches
// of the harvest, which are trees and houses, because it has no surface model; once with the best
// that show nothing that stands, leans or casts a shadow. A patch is unchanged if the chip shows
// neither a change of the ground nor such an object (shadows have moved). It is matched if the pose
// uses it, and a false match if it is then more than a pixel from the true position of its ground
// point.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "block/stages/exterior_stage.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"
#include "core/geometry/intersection.h"
#include "exterior/steps/predict.h"
#include "patchdb/store/patch_database.h"
#include "tools/bench/jaw_wu_world.h"

namespace orient::jaw_wu {
namespace {

constexpr int kPatchesPerPhoto = 30;
constexpr double kFalseMatch_px = 1, kFalsePose_px = 3;

// Half the side of a chip's matching window on the ground.
double HalfSide(const World& world) { return 0.5 * 61 * world.of.simulation.gsd_m; }

// Stores the best patches of each photo, spread over it, until it has 30.
void StoreSome(World* of, const std::string& patches_of) {
  of->patches_of = patches_of;
  const World& world = *of;
  const GroundMask standing(world.folder + "/truth/standing.tif");
  std::vector<patchdb::Patch> eligible;
  for (const patchdb::Patch& patch : world.patches)
    if (patches_of == "any" || !standing.Touches(patch.ground_m, HalfSide(world)))
      eligible.push_back(patch);
  std::set<std::size_t> chosen;
  for (const OrientationRow& row : world.truth.rows) {
    const InteriorResult interior =
        ReadInteriorResult(InteriorResultPath(world.folder + "/truth/interior", row.photo));
    exterior::PredictionOptions options;
    options.width_px = interior.width;
    options.height_px = interior.height;
    options.border_px = 60;
    auto seen = exterior::Predict(world.TrueView(row.photo), Matrix6d::Zero(), eligible, options);
    const auto first_new = std::partition(
        seen.begin(), seen.end(),
        [&](const exterior::PatchPrediction& p) { return chosen.find(p.patch) != chosen.end(); });
    const auto wanted = kPatchesPerPhoto - static_cast<int>(first_new - seen.begin());
    seen.erase(seen.begin(), first_new);
    if (wanted <= 0) continue;
    for (const exterior::PatchPrediction& p :
         exterior::SelectSpread(seen, eligible, wanted, options))
      chosen.insert(p.patch);
  }
  std::vector<patchdb::Patch> some;
  for (const std::size_t i : chosen) {
    some.push_back(eligible[i]);
    some.back().id = some.back().source_id = 0;
  }
  const std::string path = world.folder + "/" + patches_of + ".gpkg";
  std::filesystem::remove(path);
  patchdb::PatchSource source;
  source.name = "chosen";
  source.gsd_m = some.front().gsd_m;
  patchdb::PatchDatabase::Create(path, *world.truth.crs).AddSource(source, some);
}

void WriteStart(const World& world, const std::string& name, double position_m, double angle_deg,
                bool any_kappa, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  OrientationTable table = world.truth;
  for (OrientationRow& row : table.rows) {
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(position_m),
        Eigen::Vector3d::Constant(RadFromDeg(angle_deg));
    Vector6d pose = row.pose.AsVector();
    for (int i = 0; i < 6; ++i) pose[i] += sigma[i] * normal(random);
    if (any_kappa) {
      pose[5] += std::numbers::pi * std::uniform_real_distribution<double>(-1, 1)(random);
      sigma[5] = std::numbers::pi;
    }
    row.pose = Pose::FromVector(pose);
    row.pose.opk_rad.z() = NormalizeAngle(row.pose.opk_rad.z());
    row.sigma = sigma;
  }
  WriteOrientationTable(world.folder + "/start_" + name + ".csv", table);
}

struct Tally {
  int unchanged = 0, unchanged_matched = 0, changed = 0, changed_matched = 0, false_matches = 0;
  int ok = 0, weak = 0, failed = 0, wrong = 0;
  double ground2 = 0, pair_plane2 = 0, pair_height2 = 0, pixels2 = 0;
  int ground_points = 0, pair_points = 0, pixels = 0;
  std::map<std::string, int> why_not;

  void Print(const std::string& name) const {
    std::printf("%-24s %3d ok %2d weak %2d failed, wrong %d |", name.c_str(), ok, weak, failed,
                wrong);
    if (unchanged + changed > 0)
      std::printf(" unchanged %d of %d (%.1f %%), changed %d of %d, false %d |", unchanged_matched,
                  unchanged, 100.0 * unchanged_matched / std::max(unchanged, 1), changed_matched,
                  changed, false_matches);
    std::printf(" %.3f px", std::sqrt(pixels2 / std::max(pixels, 1)));
    std::printf(" | photo %.1f cm", 100 * std::sqrt(ground2 / std::max(ground_points, 1)));
    if (pair_points > 0)
      std::printf(" | pair %.1f cm, height %.1f cm", 100 * std::sqrt(pair_plane2 / pair_points),
                  100 * std::sqrt(pair_height2 / pair_points));
    std::printf("\n");
    for (const auto& [reason, count] : why_not)
      std::printf("    unchanged, %d: %s\n", count, reason.c_str());
    std::fflush(stdout);
  }
};

void CountPatches(const World& world, const GroundMask& change, const GroundMask& standing,
                  const ExteriorResult& result, Tally* tally) {
  const PhotoView truth = world.TrueView(result.photo);
  const double half_m = HalfSide(world);
  for (const PatchResult& patch : result.patches) {
    if (patch.state == PatchState::kNotVisible) continue;
    const bool matched = patch.state == PatchState::kMatched;
    const bool changed =
        change.Touches(*patch.ground_m, half_m) || standing.Touches(*patch.ground_m, half_m);
    (changed ? tally->changed : tally->unchanged) += 1;
    (changed ? tally->changed_matched : tally->unchanged_matched) += matched ? 1 : 0;
    if (!changed && !matched) tally->why_not[JoinedSentences(patch.findings)] += 1;
    if (matched && (*patch.pixel - *truth.PixelFromGround(*patch.ground_m)).norm() > kFalseMatch_px)
      tally->false_matches += 1;
  }
}

// Ground positions from the photo at the true image positions of the points.
void CountGround(const World& world, const ExteriorResult& result, Tally* tally) {
  const PhotoView view = world.FoundView(result);
  double sum = 0;
  int count = 0;
  for (const auto& [number, check] : world.checks.at(result.photo)) {
    const auto ground = view.GroundFromPixel(check.pixel, world.surface);
    const auto pixel = view.PixelFromGround(check.ground_m);
    if (!ground || !pixel) continue;
    tally->ground2 += (*ground - check.ground_m).head<2>().squaredNorm();
    ++tally->ground_points;
    sum += (*pixel - check.pixel).squaredNorm();
    ++count;
  }
  tally->pixels2 += sum;
  tally->pixels += count;
  if (result.status == Status::kOk && !(std::sqrt(sum / count) <= kFalsePose_px)) ++tally->wrong;
}

void CountPair(const World& world, const ExteriorResult& left, const ExteriorResult& right,
               Tally* tally) {
  const PhotoView one = world.FoundView(left), other = world.FoundView(right);
  const auto ray = [](const PhotoView& view, const Eigen::Vector2d& pixel) {
    return *GroundRayFromPhoto(view.camera, view.pose, view.PhotoFromPixel(pixel));
  };
  const auto& seen_by_other = world.checks.at(right.photo);
  for (const auto& [number, check] : world.checks.at(left.photo)) {
    const auto same = seen_by_other.find(number);
    if (same == seen_by_other.end()) continue;
    const auto ground = IntersectRays({ray(one, check.pixel), ray(other, same->second.pixel)});
    if (!ground) continue;
    const Eigen::Vector3d error = *ground - check.ground_m;
    tally->pair_plane2 += error.head<2>().squaredNorm();
    tally->pair_height2 += error.z() * error.z();
    ++tally->pair_points;
  }
}

std::vector<ExteriorResult> OrientFrom(const World& world, const std::string& start, Tally* tally) {
  const GroundMask change(world.folder + "/change.tif");
  const GroundMask standing(world.folder + "/truth/standing.tif");
  const std::vector<ExteriorResult> results = block::RunExterior(world.Run(start));
  for (const ExteriorResult& result : results) {
    tally->ok += result.status == Status::kOk ? 1 : 0;
    tally->weak += result.status == Status::kWeak ? 1 : 0;
    tally->failed += result.status == Status::kFailed ? 1 : 0;
    if (result.status != Status::kOk)
      std::printf("  %s, %s: %s\n", world.folder.c_str(), result.photo.c_str(),
                  result.findings.empty() ? "" : Sentence(result.findings.back()).c_str());
    if (!result.pose) continue;
    if (!world.of.hard) CountPatches(world, change, standing, result, tally);
    CountGround(world, result, tally);
  }
  if (!world.of.hard && results.size() == 2 && results[0].pose && results[1].pose)
    CountPair(world, results[0], results[1], tally);
  return results;
}

// The largest difference of a pose element, in its sigmas.
double LargestDifference(const std::vector<ExteriorResult>& some,
                         const std::vector<ExteriorResult>& others) {
  double largest = 0;
  for (std::size_t i = 0; i < some.size(); ++i) {
    if (!some[i].pose || !others[i].pose) return std::nan("");
    const Vector6d sigma = some[i].covariance->diagonal().cwiseSqrt();
    largest = std::max(
        largest,
        PoseDifference(*others[i].pose, *some[i].pose).cwiseQuotient(sigma).cwiseAbs().maxCoeff());
  }
  return largest;
}

struct Start {
  const char* name;
  double position_m, angle_deg;
};
constexpr std::array<Start, 3> kStarts = {
    {{"10m_3deg", 10, 3}, {"5m_1deg", 5, 1}, {"1m_1min", 1, 1.0 / 60}}};

void Main(const std::string& folder, const std::string& name, int worlds, bool rc10) {
  const Case c = CaseOf(name, rc10);
  std::map<std::string, Tally> tallies;
  double largest = 0;
  for (int w = 1; w <= worlds; ++w) {
    std::string at = folder;
    at += "/" + name + (rc10 ? "_rc10_" : "_") + std::to_string(w);
    try {
      MakeWorld(c, at, static_cast<std::uint32_t>(200 + w));
    } catch (const UsageError& error) {  // mountains too steep to be visible from above
      std::printf("%s cannot be made: %s\n", at.c_str(), error.what());
      continue;
    }
    World world(c, at);
    const auto seed = static_cast<unsigned>(w);
    if (c.hard) {
      WriteStart(world, "hard", 100, 10, true, seed);
      for (const char* patches_of : {"all", "any"}) {
        world.patches_of = patches_of;
        if (world.patches_of != "all") StoreSome(&world, patches_of);
        OrientFrom(world, "hard", &tallies[world.patches_of + " 100m_10deg"]);
      }
      continue;
    }
    for (const char* patches_of : {"any", "open"}) {
      StoreSome(&world, patches_of);
      std::vector<ExteriorResult> first;
      for (const Start& start : kStarts) {
        WriteStart(world, start.name, start.position_m, start.angle_deg, false, seed);
        const auto results =
            OrientFrom(world, start.name, &tallies[world.patches_of + " " + start.name]);
        if (first.empty()) first = results;
        largest = std::max(largest, LargestDifference(first, results));
      }
    }
  }
  for (const auto& [start, tally] : tallies) tally.Print(start);
  if (!c.hard) std::printf("poses from the three starts differ by at most %.2f sigma\n", largest);
}

}  // namespace
}  // namespace orient::jaw_wu

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr,
                 "usage: exterior_jaw_wu FOLDER fine|coarse|hard|mountains [WORLDS] [rc10]\n");
    return 1;
  }
  try {
    orient::jaw_wu::Main(argv[1], argv[2], argc > 3 ? std::atoi(argv[3]) : 3,
                         argc > 4 && std::string(argv[4]) == "rc10");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "exterior_jaw_wu: %s\n", error.what());
    return 2;
  }
  return 0;
}

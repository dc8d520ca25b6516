// How many of the patches visible in a photo are matched, by their correlation at the true
// position, and why the others are not.
//
//   exterior_matches --photos P... --camera C --interior IO --truth T --dem D --patchdb DB
//                    --results EX
//
// The truth (a table of true poses) gives the position and appearance of each patch in the photo:
// the best correlation within 0.75 px of that position is its true correlation. EX is the folder of
// the photos' results from any start; matched patches more than 1 px plus three of their own sigmas
// from their true positions are false. Only patches whose centre is visible in the photo are
// counted.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "block/inputs/photo_interior.h"
#include "core/base/side_by_side.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/matching/correlation.h"
#include "core/terrain/ground_surface.h"
#include "exterior/steps/align.h"
#include "exterior/steps/photo_image.h"
#include "exterior/steps/photo_to_orient.h"
#include "exterior/steps/predict.h"
#include "patchdb/store/patch_database.h"

namespace orient {
namespace {
using exterior::PhotoImage;

constexpr double kNear_px = 0.75;
constexpr double kFalse_px = 1;
constexpr int kClasses = 10;  // of the true correlation, a tenth each

struct Files {
  std::vector<std::string> photos;
  std::string camera, interior, truth, dem, patchdb, results;
};

// Patches of one class of true correlation.
struct Counts {
  int shown = 0, searched = 0, matched = 0, rejected = 0, wrong = 0;
  std::map<std::string, int> why_not;
};

// The best correlation of the patch near its true position; none if it cannot be rendered.
std::optional<double> TrueCorrelation(const PhotoView& view, const patchdb::Patch& patch,
                                      const PhotoImage& image) {
  const auto drawn =
      exterior::AlignPatch(view, patch, 1, exterior::kMinSide_px, exterior::kMaxSide_px);
  if (!drawn) return std::nullopt;
  const Eigen::Vector2d half = drawn->Centre() + Eigen::Vector2d::Constant(kNear_px);
  const ImageWindow window = image.Around(drawn->predicted_px, half, 1);
  const Image scores = Correlate(drawn->image, window.image);
  double best = -1;
  for (const float score : scores.values)
    if (std::isfinite(score)) best = std::max(best, static_cast<double>(score));
  return best;
}

void Count(const patchdb::Patch& patch, const PhotoView& view, const PatchResult* result,
           Counts* counts) {
  ++counts->shown;
  if (result == nullptr || result->state == PatchState::kNotVisible) return;
  ++counts->searched;
  counts->rejected += result->state == PatchState::kRejected ? 1 : 0;
  if (result->state != PatchState::kMatched) {
    for (const Finding& finding : result->findings)
      ++counts->why_not[std::string(Code(finding.reason))];
    return;
  }
  ++counts->matched;
  const auto pixel = view.PixelFromGround(patch.ground_m);
  const double off_px = (*result->pixel - *pixel).norm();
  counts->wrong += off_px > kFalse_px + 3 * result->sigma_px->norm() ? 1 : 0;
}

void Print(const std::string& photo, const std::array<Counts, kClasses>& classes) {
  std::printf("%s\n  correlation   shown  searched  matched  rejected  wrong\n", photo.c_str());
  for (int i = kClasses; i-- > 0;) {
    const Counts& counts = classes[static_cast<std::size_t>(i)];
    if (counts.shown == 0) continue;
    std::printf("  %.1f to %.1f %8d %9d %8d %9d %6d ", i / 10.0, (i + 1) / 10.0, counts.shown,
                counts.searched, counts.matched, counts.rejected, counts.wrong);
    for (const auto& [code, times] : counts.why_not) std::printf(" %s %d", code.c_str(), times);
    std::printf("\n");
  }
}

void Run(const Files& in) {
  const Camera camera = ReadCameraFile(in.camera).camera;
  const OrientationTable truth = ReadOrientationTable(in.truth);
  const GroundSurface surface = GroundSurface::FromFile(in.dem, *truth.crs);
  const auto db = patchdb::PatchDatabase::Open(in.patchdb, patchdb::PatchDatabase::Mode::kRead);
  int good = 0, found = 0;
  for (const std::string& path : in.photos) {
    const std::string name = std::filesystem::path(path).stem().string();
    const Raster raster = Raster::Open(path);
    const block::PhotoInterior interior = block::PhotoInteriorOf(raster, camera, in.interior);
    const OrientationRow* row = truth.Find(name);
    if (row == nullptr) throw std::runtime_error(in.truth + " has no row '" + name + "'");
    const PosePrior pose{row->pose, Matrix6d(1e-12 * Matrix6d::Identity())};
    const PhotoView view{camera, interior.photo_from_pixel, pose.pose, interior.film_correction};
    const std::vector<patchdb::Patch> patches = db.FindPatchesIn(
        exterior::UncertainFootprint(camera, pose, surface.MinHeight(), surface.MaxHeight()));
    const auto shown = exterior::Predict(
        view, pose.covariance, patches,
        {raster.Width(), raster.Height(), exterior::kMaxSide_px / 2.0, {}, &surface});
    const PhotoImage image(raster, false);
    std::vector<std::optional<double>> correlations(shown.size());
    SideBySide(shown.size(), [&](std::size_t i) {
      correlations[i] = TrueCorrelation(view, patches[shown[i].patch], image);
    });
    const ExteriorResult result = ReadExteriorResult(ExteriorResultPath(in.results, name));
    std::map<std::int64_t, const PatchResult*> of;
    for (const PatchResult& patch : result.patches) of[patch.id] = &patch;
    std::array<Counts, kClasses> classes;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      if (!correlations[i]) continue;
      const int place = std::clamp(static_cast<int>(*correlations[i] * kClasses), 0, kClasses - 1);
      const patchdb::Patch& patch = patches[shown[i].patch];
      const auto known = of.find(patch.id);
      Count(patch, view, known == of.end() ? nullptr : known->second,
            &classes[static_cast<std::size_t>(place)]);
    }
    Print(name + ", " + std::string(Name(result.status)), classes);
    for (std::size_t i = 7; i < kClasses; ++i) {
      good += classes[i].searched;
      found += classes[i].matched;
    }
  }
  std::printf("of those above 0.7 that were searched for, %d of %d were matched: %.1f %%\n", found,
              good, 100.0 * found / std::max(good, 1));
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) try {
  orient::Files in;
  CLI::App app("Counts the matched patches by their true correlation");
  app.add_option("--photos", in.photos)->required();
  app.add_option("--camera", in.camera)->required();
  app.add_option("--interior", in.interior)->required();
  app.add_option("--truth", in.truth)->required();
  app.add_option("--dem", in.dem)->required();
  app.add_option("--patchdb", in.patchdb)->required();
  app.add_option("--results", in.results)->required();
  CLI11_PARSE(app, argc, argv);
  orient::Run(in);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "exterior_matches: %s\n", error.what());
  return 2;
}

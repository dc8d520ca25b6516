#include "exterior/search/sought_patches.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/side_by_side.h"
#include "exterior/search/whole_photo_search.h"
#include "exterior/steps/align.h"

namespace orient::exterior {
namespace {

constexpr std::size_t kPatches = 60;
constexpr double kCells = 8;        // along the photo's longer side, with about one patch in each
constexpr std::size_t kFewest = 4;  // least number of patches
constexpr double kMostTurned_rad = 1.2;  // beyond, patches may lie anywhere in the photo
// Least side of a drawn patch, pixels of the level: a smaller one resembles too much.
constexpr int kLeastSide = 13;
constexpr int kMostSide = 19;
constexpr double kMaxPixels = 6e6;  // of a level that is searched whole
constexpr int kMaxCandidates = 4;   // of a patch
constexpr double kMinScore = 0.3;   // of a candidate

// The lens' inverse need not exist as far outside the frame as patches may be drawn.
PhotoView WithoutLens(PhotoView view) {
  view.camera.lens = {};
  view.film_correction = nullptr;
  return view;
}

struct AroundPhoto {
  std::size_t patch = 0;  // index into the patches
  Eigen::Vector2d pixel;  // scan
  double width_px = 0;
};

// Patches that the photo may show, whatever its kappa.
std::vector<AroundPhoto> PatchesAround(const PhotoTask& task, const PhotoView& view) {
  std::vector<AroundPhoto> around;
  const Camera& camera = view.camera;
  for (std::size_t i = 0; i < task.patches.size(); ++i) {
    const auto photo = PhotoFromGround(camera, view.pose, task.patches[i].ground_m);
    if (!photo || (*photo - camera.frame_centre_mm).norm() > camera.FrameRadius()) continue;
    if (const auto width_px = PatchWidth(view, task.patches[i]))
      around.push_back({i, view.PixelFromPhoto(*photo), *width_px});
  }
  return around;
}

// How well an image's place is determined by its own gradients: det N / tr N (Foerstner).
double Structure(const Image& image) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int row = 1; row + 1 < image.height; ++row)
    for (int col = 1; col + 1 < image.width; ++col) {
      const Eigen::Vector2d gradient(image.At(col + 1, row) - image.At(col - 1, row),
                                     image.At(col, row + 1) - image.At(col, row - 1));
      if (gradient.allFinite()) sum += gradient * gradient.transpose();
    }
  return sum.trace() > 0 ? sum.determinant() / sum.trace() : 0;
}

// Of the patches wide enough, those with most structure at that level, evenly distributed: what
// makes a good patch at full resolution may be lost there.
std::vector<std::size_t> Conspicuous(const PhotoTask& task, const PhotoView& view,
                                     const std::vector<AroundPhoto>& around, int reduction,
                                     int side) {
  std::vector<double> structure(around.size(), 0);
  SideBySide(around.size(), [&](std::size_t i) {
    if (around[i].width_px < 0.95 * side * reduction) return;
    const auto drawn = AlignWholePatch(view, task.patches[around[i].patch], reduction, side);
    if (drawn) structure[i] = Structure(drawn->image);
  });
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < around.size(); ++i)
    if (structure[i] > 0) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return structure[a] > structure[b]; });
  // The best of every cell, then the second best of every cell, until there are enough.
  const double cell_px = std::max(task.image.Width(), task.image.Height()) / kCells;
  std::map<std::pair<long, long>, int> ranked;
  std::vector<int> rank(around.size(), 0);
  for (const std::size_t i : order) {
    const Eigen::Vector2d cell = around[i].pixel / cell_px;
    rank[i] = ranked[{std::lround(cell.x()), std::lround(cell.y())}]++;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rank[a] < rank[b]; });
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::min(order.size(), kPatches); ++k)
    chosen.push_back(around[order[k]].patch);
  return chosen;
}

}  // namespace

std::optional<SoughtPatches> SoughtPatches::Of(const PhotoTask& task, double ground_m,
                                               const Pose& approximate,
                                               std::shared_ptr<const PhotoLevel>* level) {
  const PhotoView view = WithoutLens(task.View(task.photo.positions.front(), approximate));
  const std::vector<AroundPhoto> around = PatchesAround(task, view);
  if (around.empty()) return std::nullopt;
  std::vector<double> widths;
  for (const AroundPhoto& patch : around) widths.push_back(patch.width_px);
  // The first quartile, so that most patches fit; the smallest are too small.
  const auto small = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 4);
  std::nth_element(widths.begin(), small, widths.end());
  const int reduction =
      std::max(FinestReduction(task.image, kMaxPixels), static_cast<int>(*small / kMostSide));
  const int fitting = static_cast<int>(*small / reduction);
  const int side = std::clamp(fitting - (fitting % 2 == 0 ? 1 : 0), kLeastSide, kMostSide);
  std::vector<std::size_t> patches = Conspicuous(task, view, around, reduction, side);
  const int shorter = std::min(task.image.Width(), task.image.Height());
  if (patches.size() < kFewest || shorter < 2 * side * reduction) return std::nullopt;
  if (!*level || (*level)->Reduction() != reduction || (*level)->Side() != side) {
    level->reset();  // before the next one takes as much memory
    *level = std::make_shared<const PhotoLevel>(task.image, reduction, side);
  }
  return SoughtPatches(task, ground_m, std::move(patches), *level);
}

std::vector<VotingPatch> SoughtPatches::Seek(const PhotoView& drawn_under,
                                             const PosePrior& prior) const {
  const PhotoView view = WithoutLens(drawn_under);
  const double height = view.pose.position_m.z() - ground_m_;
  const Vector6d sigma = prior.covariance.diagonal().cwiseSqrt();
  const double turned = kWindowSigmas * std::hypot(sigma.segment<2>(3).maxCoeff(),
                                                   sigma.head<2>().maxCoeff() / height);
  const double stretched = kKappaStep_rad / 2 + kWindowSigmas * sigma[2] / height;
  const double distance_px = view.camera.principal_distance_mm / view.PixelSize();
  const Eigen::Vector2d middle_px = view.PixelFromPhoto(view.camera.frame_centre_mm);
  std::vector<VotingPatch> voting(patches_.size());
  SideBySide(voting.size(), [&](std::size_t i) {
    const patchdb::Patch& patch = task_.patches[patches_[i]];
    voting[i].ground_m = patch.ground_m;
    const auto drawn = AlignWholePatch(view, patch, level_->Reduction(), level_->Side());
    if (!drawn) return;
    const double off_px = (drawn->predicted_px - middle_px).norm();
    // The same tilt displaces points farther out by more.
    const double oblique = 1 + std::pow(off_px / distance_px, 2);
    auto places = level_->Find(
        drawn->image, drawn->predicted_px,
        oblique * std::tan(std::min(turned, kMostTurned_rad)) * distance_px + stretched * off_px,
        kMaxCandidates, kMinScore);
    voting[i].candidates = std::move(places.best);
    voting[i].window_px2 = places.area_px2;
  });
  return voting;
}

}  // namespace orient::exterior

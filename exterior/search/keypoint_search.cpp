#include "exterior/search/keypoint_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "core/geometry/collinearity.h"
#include "core/matching/keypoints.h"
#include "exterior/search/first_pose.h"
#include "exterior/search/keypoint_pose.h"
#include "exterior/search/search_prior.h"

namespace orient::exterior {
namespace {

// Levels that are searched, the coarser first: most photos are found there at a quarter of the
// cost.
constexpr std::array kMostPixels = {3e6, 12e6};
constexpr double kLeastChip_px = 24;  // of the level: half of it is border
constexpr int kPhotoKeypoints = 20000;
constexpr std::size_t kPatches = 900;
constexpr int kChipKeypoints = 40, kKeptOfChip = 20;
// Keypoints are looked for in tiles of the level: OpenCV's scale space takes 180 bytes a pixel.
constexpr int kTile_px = 640, kOverlap_px = 32;
// The smallest that SIFT finds, diameter in pixels.
constexpr double kSmallest_px = 3;
constexpr double kRatio = 0.9;  // of the nearest descriptor's distance to the second's
// Or so many of the nearest, where two of a chip agree on its middle: pixels of the level.
constexpr std::size_t kNearest = 4;
constexpr double kAgree_px = 6;
// Matches of one pose turn and scale alike: of so many turns, each so wide, the fullest are tried.
constexpr int kTurns = 36;
constexpr double kTurnReach_rad = 20 * std::numbers::pi / 180;
constexpr int kTried = 5;
constexpr double kScaleReach = 1.5;  // factor
constexpr double kUsualTilt_rad = 5 * std::numbers::pi / 180;
constexpr int kFewest = 5;  // places that agree: patches will prove it or not

int ReductionFor(const PhotoImage& photo, double most_pixels) {
  const double pixels = static_cast<double>(photo.Width()) * photo.Height();
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / most_pixels))));
}

// Keypoints, scan pixels, sizes and all.
Keypoints OfPhoto(const PhotoImage& photo, int reduction) {
  const int width = photo.Width() / reduction, height = photo.Height() / reduction;
  const double pixels = static_cast<double>(width) * height;
  Keypoints all;
  all.descriptors.resize(0, kDescriptorSize);
  const int step = kTile_px - 2 * kOverlap_px;
  for (int row = 0; row < height; row += step)
    for (int col = 0; col < width; col += step) {
      const Eigen::Vector2d first(col, row);
      const Eigen::Vector2d last =
          (first + Eigen::Vector2d::Constant(step)).cwiseMin(Eigen::Vector2d(width, height));
      const ImageWindow window = photo.Around(
          reduction * (first + last) / 2,
          reduction * ((last - first) / 2 + Eigen::Vector2d::Constant(kOverlap_px)), reduction);
      const double share = (last - first).prod() / pixels;
      Keypoints found = FindKeypoints(
          window.image, static_cast<int>(std::ceil(kPhotoKeypoints * std::min(1.2 * share, 1.0))));
      std::vector<std::size_t> inside;
      for (std::size_t i = 0; i < found.Size(); ++i) {
        found.pixels[i] = window.RasterFromImage(found.pixels[i]);
        found.sizes_px[i] *= reduction;
        const Eigen::Array2d at = found.pixels[i] / reduction;
        if ((at >= first.array()).all() && (at < last.array()).all()) inside.push_back(i);
      }
      all.Append(found.Of(inside));
    }
  return all;
}

// Keypoints of the patches' chips, at least so large on the ground; sizes in metres.
struct ChipKeypoints {
  Keypoints keypoints;  // chip by chip
  std::vector<std::size_t> chip;
  std::vector<Eigen::Vector2d> offset_m;  // from the chip's middle, to the right and down
  std::vector<Eigen::Vector3d> ground_m;
};

double ChipWidth(const patchdb::Patch& patch) {
  return std::min(patch.chip.width, patch.chip.height) * patch.gsd_m;
}

// At most kPatches, spread over the region.
std::vector<std::size_t> PatchesToShow(const std::vector<patchdb::Patch>& patches,
                                       double least_width_m) {
  Bounds region = Bounds::OfNothing();
  for (const patchdb::Patch& patch : patches)
    region.Include(patch.ground_m.x(), patch.ground_m.y());
  PredictionOptions options;
  options.width_px = static_cast<int>(std::ceil(region.max_x - region.min_x)) + 1;
  options.height_px = static_cast<int>(std::ceil(region.max_y - region.min_y)) + 1;
  std::vector<PatchPrediction> places;
  for (std::size_t i = 0; i < patches.size(); ++i)
    if (ChipWidth(patches[i]) >= least_width_m)
      places.push_back(
          {i,
           {patches[i].ground_m.x() - region.min_x, patches[i].ground_m.y() - region.min_y},
           Eigen::Matrix2d::Zero()});
  std::vector<std::size_t> chosen;
  for (const PatchPrediction& place :
       SelectSpread(places, patches, static_cast<int>(kPatches), options))
    chosen.push_back(place.patch);
  return chosen;
}

Image Mirrored(Image image) {
  for (int row = 0; row < image.height; ++row)
    std::reverse(image.Row(row), image.Row(row) + image.width);
  return image;
}

// `mirrored`: as a photo shows them that was scanned through its back.
ChipKeypoints OfPatches(const std::vector<patchdb::Patch>& patches,
                        const std::vector<std::size_t>& which, double least_size_m, bool mirrored) {
  std::vector<Keypoints> found(which.size());
  SideBySide(which.size(), [&](std::size_t k) {
    const patchdb::Patch& patch = patches[which[k]];
    const Keypoints all =
        FindKeypoints(mirrored ? Mirrored(patch.chip) : patch.chip, kChipKeypoints);
    std::vector<std::size_t> large;
    for (std::size_t i = 0; i < all.Size() && large.size() < kKeptOfChip; ++i)
      if (all.sizes_px[i] * patch.gsd_m >= least_size_m) large.push_back(i);
    found[k] = all.Of(large);
  });
  ChipKeypoints of;
  of.keypoints.descriptors.resize(0, kDescriptorSize);
  for (std::size_t k = 0; k < which.size(); ++k) {
    const patchdb::Patch& patch = patches[which[k]];
    for (std::size_t i = 0; i < found[k].Size(); ++i) {
      const Eigen::Vector2d offset_m =
          patch.gsd_m *
          (found[k].pixels[i] - Eigen::Vector2d(patch.chip.width, patch.chip.height) / 2);
      const double east = mirrored ? -offset_m.x() : offset_m.x(), north = -offset_m.y();
      of.chip.push_back(k);
      of.offset_m.push_back(offset_m);
      const double height = patch.heights.At(east, north);
      of.ground_m.emplace_back(patch.ground_m.x() + east, patch.ground_m.y() + north,
                               std::isnan(height) ? patch.ground_m.z() : height);
      found[k].sizes_px[i] *= patch.gsd_m;
    }
    of.keypoints.Append(found[k]);
  }
  return of;
}

// A pair that looks alike: what it says of how the photo lies.
struct Pair {
  KeypointMatch match;
  double turn_rad = 0;        // from chip to scan
  double gsd_m = 0;           // of a scan pixel
  Eigen::Vector2d middle_px;  // of the chip in the scan
};

std::vector<Pair> Pairs(const Keypoints& photo, const ChipKeypoints& chips,
                        const std::vector<KeypointMatch>& matches) {
  std::vector<Pair> pairs;
  for (const KeypointMatch& match : matches) {
    Pair pair{match,
              photo.angles_rad[match.second] - chips.keypoints.angles_rad[match.first],
              chips.keypoints.sizes_px[match.first] / photo.sizes_px[match.second],
              {}};
    pair.middle_px = photo.pixels[match.second] -
                     Eigen::Rotation2Dd(pair.turn_rad) * chips.offset_m[match.first] / pair.gsd_m;
    pairs.push_back(pair);
  }
  return pairs;
}

// Whether two keypoints of a chip say the same of where it lies, and how.
bool Agree(const Pair& a, const Pair& b, double reach_px) {
  return a.match.first != b.match.first && a.match.second != b.match.second &&
         (a.middle_px - b.middle_px).norm() <= reach_px &&
         std::abs(NormalizeAngle(a.turn_rad - b.turn_rad)) <= kTurnReach_rad &&
         std::abs(std::log(a.gsd_m / b.gsd_m)) <= std::log(kScaleReach);
}

// Those with which another one of their chip agrees. A descriptor's nearest ones are seldom right
// where years lie between, two that agree seldom wrong.
std::vector<Pair> Agreeing(const std::vector<Pair>& pairs, const ChipKeypoints& chips,
                           double reach_px) {
  std::vector<Pair> agreeing;
  for (auto first = pairs.begin(); first != pairs.end();) {
    const std::size_t chip = chips.chip[first->match.first];
    const auto end = std::find_if(
        first, pairs.end(), [&](const Pair& pair) { return chips.chip[pair.match.first] != chip; });
    std::copy_if(first, end, std::back_inserter(agreeing), [&](const Pair& pair) {
      return std::any_of(first, end,
                         [&](const Pair& other) { return Agree(pair, other, reach_px); });
    });
    first = end;
  }
  return agreeing;
}

// Those of the turns that most agree on, the fullest turn first.
std::vector<std::vector<Pair>> ByTurn(std::vector<Pair> pairs) {
  std::vector<std::vector<Pair>> tried;
  for (int i = 0; i < kTried; ++i) {
    std::vector<Pair> fullest;
    for (int turn = 0; turn < kTurns; ++turn) {
      std::vector<Pair> near;
      const double middle = 2 * std::numbers::pi * turn / kTurns;
      std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(near), [&](const Pair& pair) {
        return std::abs(NormalizeAngle(pair.turn_rad - middle)) <= kTurnReach_rad;
      });
      if (near.size() > fullest.size()) fullest = std::move(near);
    }
    if (fullest.size() < kFewest) break;
    std::erase_if(pairs, [&](const Pair& pair) {
      return std::any_of(fullest.begin(), fullest.end(),
                         [&](const Pair& taken) { return taken.match.first == pair.match.first; });
    });
    tried.push_back(std::move(fullest));
  }
  return tried;
}

class KeypointSearch {
 public:
  KeypointSearch(const PhotoTask& task, double ground_m, double trials)
      : task_(task), trials_(trials), ground_m_(ground_m) {}

  WholePhotoSearch Run() {
    WholePhotoSearch search;
    int before = 0;
    for (const double most_pixels : kMostPixels) {
      const int reduction = ReductionFor(task_.image, most_pixels);
      if (reduction == before) break;
      before = reduction;
      SearchLevel(reduction, &search);
      if (search.track && Convinces(*search.track)) break;
    }
    return search;
  }

 private:
  void SearchLevel(int reduction, WholePhotoSearch* search) const;
  void Try(const Keypoints& photo, const ChipKeypoints& chips, int reduction, bool mirrored,
           WholePhotoSearch* search) const;
  std::optional<PoseTrack> Follow(const std::vector<SharedKeypoint>& shared,
                                  const std::vector<FilmPosition>& positions, int reduction) const;
  bool MayBe(const Pair& pair, const Keypoints& photo, const ChipKeypoints& chips,
             const FilmPosition& position) const;
  bool Convinces(const PoseTrack& track) const {
    return track.log10_false_alarms < task_.options.max_log10_false_alarms;
  }
  double Height() const { return task_.photo.prior.pose.position_m.z() - ground_m_; }
  double Gsd() const {
    return task_.View(task_.photo.positions.front(), {}).PixelSize() * Height() /
           task_.photo.camera.principal_distance_mm;
  }

  const PhotoTask& task_;
  double trials_;
  double ground_m_;
};

bool IsMirrored(const FilmPosition& position) {
  // Scans have rows downwards, the photo's y upwards.
  return position.photo_from_pixel.A.determinant() > 0;
}

void KeypointSearch::SearchLevel(int reduction, WholePhotoSearch* search) const {
  const double gsd_m = Gsd() * reduction;
  const auto which = PatchesToShow(task_.patches, kLeastChip_px * gsd_m);
  if (which.empty()) return;
  search->searched = true;
  const Keypoints photo = OfPhoto(task_.image, reduction);
  for (const bool mirrored : {false, true}) {
    const auto& positions = task_.photo.positions;
    if (std::none_of(positions.begin(), positions.end(),
                     [&](const FilmPosition& p) { return IsMirrored(p) == mirrored; }))
      continue;
    const ChipKeypoints chips =
        OfPatches(task_.patches, which, kSmallest_px * gsd_m / kScaleReach, mirrored);
    Try(photo, chips, reduction, mirrored, search);
    if (search->track && Convinces(*search->track)) return;
  }
}

// Kappa of a photo that turns what lies on the ground so.
double KappaOf(double turn_rad, const FilmPosition& position) {
  // Chips have rows downwards, the ground's y upwards; a mirrored photo's chips are mirrored.
  const Eigen::Vector2d chip_from_ground(IsMirrored(position) ? -1 : 1, -1);
  const Eigen::Matrix2d photo_from_ground = position.photo_from_pixel.A *
                                            Eigen::Rotation2Dd(turn_rad).toRotationMatrix() *
                                            chip_from_ground.asDiagonal();
  return -std::atan2(photo_from_ground(1, 0) - photo_from_ground(0, 1), photo_from_ground.trace());
}

// Whether a pair lies where the stated accuracy lets it, given the kappa that it says.
bool KeypointSearch::MayBe(const Pair& pair, const Keypoints& photo, const ChipKeypoints& chips,
                           const FilmPosition& position) const {
  const PosePrior& prior = task_.photo.prior;
  Pose pose = prior.pose;
  pose.opk_rad.z() = KappaOf(pair.turn_rad, position);
  const PhotoView view = task_.View(position, pose);
  const auto photo_mm = PhotoFromGround(view.camera, pose, chips.ground_m[pair.match.first]);
  if (!photo_mm) return false;
  const Vector6d sigma = prior.covariance.diagonal().cwiseSqrt();
  const double tilt = std::min(sigma.segment<2>(3).maxCoeff(), kUsualTilt_rad);
  const double off_axis_mm = (*photo_mm - view.camera.principal_point_mm).norm();
  const double reach_mm = kWindowSigmas * std::hypot(tilt, sigma.head<2>().maxCoeff() / Height()) *
                              view.camera.principal_distance_mm +
                          (kTurnReach_rad + kWindowSigmas * sigma[2] / Height()) * off_axis_mm;
  return (*photo_mm - view.PhotoFromPixel(photo.pixels[pair.match.second])).norm() <= reach_mm;
}

void KeypointSearch::Try(const Keypoints& photo, const ChipKeypoints& chips, int reduction,
                         bool mirrored, WholePhotoSearch* search) const {
  std::vector<FilmPosition> positions;
  for (const FilmPosition& position : task_.photo.positions)
    if (IsMirrored(position) == mirrored) positions.push_back(position);
  const double sigma = std::sqrt(task_.photo.prior.covariance(2, 2)) / Height();
  const double reach = std::log(kScaleReach) + std::log1p(2 * std::min(sigma, 0.5));
  std::vector<Pair> pairs = Pairs(photo, chips, MatchKeypoints(chips.keypoints, photo, kRatio));
  for (const Pair& pair :
       Agreeing(Pairs(photo, chips, NearestKeypoints(chips.keypoints, photo, kNearest)), chips,
                kAgree_px * reduction))
    pairs.push_back(pair);
  const auto may_be = [&](const Pair& pair) {
    return task_.options.prior_failed ||
           std::any_of(positions.begin(), positions.end(), [&](const FilmPosition& position) {
             return MayBe(pair, photo, chips, position);
           });
  };
  std::erase_if(pairs, [&](const Pair& pair) {
    return std::abs(std::log(pair.gsd_m / Gsd())) > reach || !may_be(pair);
  });
  for (const std::vector<Pair>& turned : ByTurn(std::move(pairs))) {
    std::vector<SharedKeypoint> shared;
    for (const Pair& pair : turned)
      shared.push_back({photo.pixels[pair.match.second], chips.ground_m[pair.match.first], {}});
    auto track = Follow(shared, positions, reduction);
    if (!track || (search->track && search->track->log10_false_alarms <= track->log10_false_alarms))
      continue;
    search->track = std::move(track);
    if (Convinces(*search->track)) return;
  }
}

// The pose that the keypoints agree on, if patches around it agree, too.
std::optional<PoseTrack> KeypointSearch::Follow(const std::vector<SharedKeypoint>& shared,
                                                const std::vector<FilmPosition>& positions,
                                                int reduction) const {
  KeypointPoseOptions options;
  options.sigma_px = 1.5 * reduction;
  options.min_supporters = kFewest;
  options.max_log10_false_alarms = 0;
  options.rival_share = 1;
  options.samples = 10000;
  options.searches = static_cast<int>(kMostPixels.size()) * kTried;
  const Eigen::Vector2i scan_px(task_.image.Width(), task_.image.Height());
  const auto found = PoseFromKeypoints(task_.photo.camera, positions, scan_px, shared, options);
  if (!found) return std::nullopt;
  const PoseTrack rough{.position = positions[found->position],
                        .pose = found->pose,
                        .covariance = 4 * found->covariance,
                        .log10_false_alarms = found->log10_false_alarms,
                        .reduction = reduction,
                        .rounds = {},
                        .trials = trials_};
  return Confirmed(task_, rough);
}

}  // namespace

double KeypointTrials(const PhotoTask& task) {
  return static_cast<double>(kMostPixels.size() * kTried * task.photo.positions.size());
}

WholePhotoSearch SearchByKeypoints(const PhotoTask& task, double ground_height_m, double trials) {
  return KeypointSearch(task, ground_height_m, trials).Run();
}

}  // namespace orient::exterior

#include "exterior/search/keypoint_pairs.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "core/base/side_by_side.h"
#include "core/geometry/bounds.h"
#include "core/geometry/rotation.h"
#include "core/raster/resample.h"
#include "exterior/steps/predict.h"

namespace orient::exterior {
namespace {

constexpr int kPhotoKeypoints = 20000;
constexpr int kChipKeypoints = 40, kKeptOfChip = 20;
// Keypoints are looked for in tiles of the level: OpenCV's scale space takes 180 bytes a pixel.
constexpr int kTile_px = 640, kOverlap_px = 32;
constexpr double kRatio = 0.9;  // largest ratio of the nearest descriptor's distance to the next
// Or this many nearest ones, if two of a chip agree on its middle to within kAgree_px of the level.
constexpr std::size_t kNearest = 1;
constexpr double kAgree_px = 6;
constexpr int kTurns = 36;
// Pairs back one another if their rotations differ by at most half of what pairs of one pose may
// differ by, and if one lies off the place that the other implies by at most this share of their
// distance: keypoints' angles and sizes are rough, and tilt and relief change the scale.
constexpr double kBackingTurn_rad = kTurnReach_rad / 2, kBackingReach = 0.25;

// Converts an offset (east, north) to a chip's (right, down), and back.
Eigen::Vector2d Flipped(const Eigen::Vector2d& offset, bool mirrored) {
  return {mirrored ? -offset.x() : offset.x(), -offset.y()};
}

double ChipWidth(const patchdb::Patch& patch) {
  return std::min(patch.chip.width, patch.chip.height) * patch.gsd_m;
}

std::vector<Pair> PairsOf(const Keypoints& photo, const ChipKeypoints& chips,
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

// Whether two pairs of one chip imply nearly the same position, rotation and scale of it.
bool Agree(const Pair& a, const Pair& b, double reach_px) {
  return a.match.first != b.match.first && a.match.second != b.match.second &&
         (a.middle_px - b.middle_px).norm() <= reach_px &&
         std::abs(NormalizeAngle(a.turn_rad - b.turn_rad)) <= kTurnReach_rad &&
         std::abs(std::log(a.gsd_m / b.gsd_m)) <= std::log(kScaleReach);
}

// The pairs with which another pair of the same chip agrees.
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

}  // namespace

bool IsMirrored(const FilmPosition& position) {
  // Scans have rows downwards, the photo's y upwards.
  return position.photo_from_pixel.A.determinant() > 0;
}

double KappaOf(double turn_rad, const FilmPosition& position) {
  // Chips have rows downwards, the ground's y upwards; a mirrored photo's chips are mirrored.
  const Eigen::Vector2d chip_from_ground = Flipped({1, 1}, IsMirrored(position));
  const Eigen::Matrix2d photo_from_ground = position.photo_from_pixel.A *
                                            Eigen::Rotation2Dd(turn_rad).toRotationMatrix() *
                                            chip_from_ground.asDiagonal();
  return -std::atan2(photo_from_ground(1, 0) - photo_from_ground(0, 1), photo_from_ground.trace());
}

Keypoints KeypointsOf(const PhotoImage& photo, int reduction) {
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
  std::vector<std::size_t> by_size(all.Size());
  std::iota(by_size.begin(), by_size.end(), std::size_t{0});
  std::stable_sort(by_size.begin(), by_size.end(),
                   [&](std::size_t a, std::size_t b) { return all.sizes_px[a] < all.sizes_px[b]; });
  return all.Of(by_size);
}

std::vector<std::size_t> PatchesToShow(const std::vector<patchdb::Patch>& patches,
                                       const std::vector<std::size_t>& which, double least_width_m,
                                       int most) {
  Bounds region = Bounds::OfNothing();
  for (const std::size_t i : which)
    region.Include(patches[i].ground_m.x(), patches[i].ground_m.y());
  std::vector<PatchPrediction> places;
  for (const std::size_t i : which)
    if (ChipWidth(patches[i]) >= least_width_m)
      places.push_back(
          {i,
           {patches[i].ground_m.x() - region.min_x, patches[i].ground_m.y() - region.min_y},
           Eigen::Matrix2d::Zero()});
  if (places.empty()) return {};
  PredictionOptions options;
  options.width_px = static_cast<int>(std::ceil(region.max_x - region.min_x)) + 1;
  options.height_px = static_cast<int>(std::ceil(region.max_y - region.min_y)) + 1;
  std::vector<std::size_t> chosen;
  for (const PatchPrediction& place : SelectSpread(places, patches, most, options))
    chosen.push_back(place.patch);
  return chosen;
}

ChipKeypoints KeypointsOf(const std::vector<patchdb::Patch>& patches,
                          const std::vector<std::size_t>& which, double least_size_m, bool mirrored,
                          KeypointsByPatch* of_chips) {
  std::vector<std::size_t> fresh;
  for (const std::size_t i : which)
    if (of_chips->try_emplace(i).second) fresh.push_back(i);
  SideBySide(fresh.size(), [&](std::size_t k) {
    const Image& chip = patches[fresh[k]].chip;
    of_chips->at(fresh[k]) = FindKeypoints(mirrored ? Mirrored(chip) : chip, kChipKeypoints);
  });
  std::vector<Keypoints> found;
  for (const std::size_t i : which) {
    const Keypoints& all = of_chips->at(i);
    std::vector<std::size_t> large;
    for (std::size_t k = 0; k < all.Size() && large.size() < kKeptOfChip; ++k)
      if (all.sizes_px[k] * patches[i].gsd_m >= least_size_m) large.push_back(k);
    found.push_back(all.Of(large));
  }
  ChipKeypoints of;
  of.keypoints.descriptors.resize(0, kDescriptorSize);
  for (std::size_t k = 0; k < which.size(); ++k) {
    const patchdb::Patch& patch = patches[which[k]];
    of.middles_m.push_back(patch.ground_m);
    for (std::size_t i = 0; i < found[k].Size(); ++i) {
      const Eigen::Vector2d offset_m =
          patch.gsd_m *
          (found[k].pixels[i] - Eigen::Vector2d(patch.chip.width, patch.chip.height) / 2);
      const Eigen::Vector2d off_m = Flipped(offset_m, mirrored);  // from the patch's point
      of.chip.push_back(k);
      of.offset_m.push_back(offset_m);
      const double height = patch.heights.At(off_m.x(), off_m.y());
      of.ground_m.emplace_back(patch.ground_m.x() + off_m.x(), patch.ground_m.y() + off_m.y(),
                               std::isnan(height) ? patch.ground_m.z() : height);
      found[k].sizes_px[i] *= patch.gsd_m;
    }
    of.keypoints.Append(found[k]);
  }
  return of;
}

std::vector<Pair> AlikePairs(const Keypoints& photo, const ChipKeypoints& chips,
                             const Comparable& comparable, int reduction) {
  const AlikeKeypoints alike =
      CompareKeypoints(chips.keypoints, photo, comparable, kRatio, kNearest);
  std::vector<Pair> pairs = PairsOf(photo, chips, alike.distinct);
  std::set<std::pair<std::size_t, std::size_t>> known;
  for (const KeypointMatch& match : alike.distinct) known.insert({match.first, match.second});
  const auto nearest = PairsOf(photo, chips, alike.nearest);
  for (const Pair& pair : Agreeing(nearest, chips, kAgree_px * reduction))
    if (known.insert({pair.match.first, pair.match.second}).second) pairs.push_back(pair);
  return pairs;
}

std::vector<int> SupportCounts(const std::vector<Pair>& pairs, const Keypoints& photo,
                               const ChipKeypoints& chips, bool mirrored, double apart_px) {
  const auto backs = [&](const Pair& a, const Pair& b) {
    const double turned = NormalizeAngle(b.turn_rad - a.turn_rad);
    if (std::abs(turned) > kBackingTurn_rad) return false;
    const Eigen::Vector2d ground_m =
        (chips.ground_m[b.match.first] - chips.ground_m[a.match.first]).head<2>();
    const Eigen::Vector2d expected_px = Eigen::Rotation2Dd(a.turn_rad + turned / 2) *
                                        Flipped(ground_m, mirrored) / std::sqrt(a.gsd_m * b.gsd_m);
    const Eigen::Vector2d seen_px = photo.pixels[b.match.second] - photo.pixels[a.match.second];
    return expected_px.norm() >= apart_px &&
           (seen_px - expected_px).norm() <= kBackingReach * expected_px.norm();
  };
  std::vector<int> backing(pairs.size(), 0);
  SideBySide(pairs.size(), [&](std::size_t i) {
    std::vector<bool> counted(chips.middles_m.size(), false);
    counted[chips.chip[pairs[i].match.first]] = true;  // its own chip does not count
    for (const Pair& other : pairs) {
      const std::size_t chip = chips.chip[other.match.first];
      if (counted[chip] || !backs(pairs[i], other)) continue;
      counted[chip] = true;
      ++backing[i];
    }
  });
  return backing;
}

std::vector<std::vector<Pair>> ByTurn(std::vector<Pair> pairs, int turns, std::size_t fewest) {
  std::vector<std::vector<Pair>> tried;
  for (int i = 0; i < turns; ++i) {
    std::vector<Pair> fullest;
    for (int turn = 0; turn < kTurns; ++turn) {
      std::vector<Pair> near;
      const double middle = 2 * std::numbers::pi * turn / kTurns;
      std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(near), [&](const Pair& pair) {
        return std::abs(NormalizeAngle(pair.turn_rad - middle)) <= kTurnReach_rad;
      });
      if (near.size() > fullest.size()) fullest = std::move(near);
    }
    if (fullest.size() < fewest) break;
    std::erase_if(pairs, [&](const Pair& pair) {
      return std::any_of(fullest.begin(), fullest.end(), [&](const Pair& taken) {
        return taken.match.first == pair.match.first && taken.match.second == pair.match.second;
      });
    });
    tried.push_back(std::move(fullest));
  }
  return tried;
}

}  // namespace orient::exterior

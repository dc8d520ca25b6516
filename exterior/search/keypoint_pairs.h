// Which parts of chips resemble which parts of a photo: pairs of SIFT keypoints, each implying how
// the photo is rotated and scaled, and where in it the chip lies. Private to exterior.
#pragma once

#include <Eigen/Core>
#include <map>
#include <numbers>
#include <vector>

#include "core/matching/keypoints.h"
#include "exterior/steps/photo_image.h"
#include "exterior/steps/photo_to_orient.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

// How much pairs of one pose may differ: in rotation, and in scale as a factor.
inline constexpr double kTurnReach_rad = 20 * std::numbers::pi / 180;
inline constexpr double kScaleReach = 1.5;

struct ChipKeypoints {
  Keypoints keypoints;                     // chip by chip; sizes in metres
  std::vector<Eigen::Vector3d> middles_m;  // of the chips, on the ground
  std::vector<std::size_t> chip;           // of each keypoint, the index of its chip
  std::vector<Eigen::Vector2d> offset_m;   // from the chip's middle, to the right and down
  std::vector<Eigen::Vector3d> ground_m;
};

struct Pair {
  KeypointMatch match;        // chip's, photo's
  double turn_rad = 0;        // rotation from chip to scan
  double gsd_m = 0;           // of a scan pixel
  Eigen::Vector2d middle_px;  // of the chip in the scan
};

// Whether the film was scanned through its back, so that its scan shows chips mirrored.
bool IsMirrored(const FilmPosition& position);

// Kappa of a photo in this film position for which chips appear in the scan rotated by `turn_rad`.
double KappaOf(double turn_rad, const FilmPosition& position);

// Keypoints of the whole photo at a reduction, smallest first; positions and sizes in scan pixels.
Keypoints KeypointsOf(const PhotoImage& photo, int reduction);

// At most `most` of `which`, spread over the region, with chips at least `least_width_m` wide.
std::vector<std::size_t> PatchesToShow(const std::vector<patchdb::Patch>& patches,
                                       const std::vector<std::size_t>& which, double least_width_m,
                                       int most);

// Keypoints of each chip, whatever their size, by the patch's index.
using KeypointsByPatch = std::map<std::size_t, Keypoints>;

// Keypoints of these patches' chips, of at least `least_size_m`. `mirrored`: see IsMirrored.
// `found`: keypoints of chips searched before, to which those found now are added.
ChipKeypoints KeypointsOf(const std::vector<patchdb::Patch>& patches,
                          const std::vector<std::size_t>& which, double least_size_m, bool mirrored,
                          KeypointsByPatch* found);

// Pairs whose descriptors are nearer to one another than to others (ratio test, Lowe 2004), and
// nearest neighbours that agree with another of the same chip on its position: after years, one
// nearest neighbour is seldom right, but two that agree are seldom wrong.
// A chip's keypoint is compared only with the photo's keypoints that are `comparable` with it.
std::vector<Pair> AlikePairs(const Keypoints& photo, const ChipKeypoints& chips,
                             const Comparable& comparable, int reduction);

// For each pair, how many other chips have a pair at the offset that the rotations and scales of
// both imply; wrong pairs have few of these, by chance. Pairs nearer than `apart_px` (scan pixels)
// do not count: they may show the same ground and be wrong together. `mirrored`: see IsMirrored.
std::vector<int> SupportCounts(const std::vector<Pair>& pairs, const Keypoints& photo,
                               const ChipKeypoints& chips, bool mirrored, double apart_px);

// The pairs of the `turns` most frequent rotations, largest group first, each of >= `fewest` pairs.
std::vector<std::vector<Pair>> ByTurn(std::vector<Pair> pairs, int turns, std::size_t fewest);

}  // namespace orient::exterior

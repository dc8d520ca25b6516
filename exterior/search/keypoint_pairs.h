// What of patches' chips looks like what of a photo: pairs of keypoints (SIFT), each of which says
// how the photo would be turned and scaled, and where the chip would lie. Private to exterior.
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

// What pairs of one pose may differ by, in turn and as a factor in scale.
inline constexpr double kTurnReach_rad = 20 * std::numbers::pi / 180;
inline constexpr double kScaleReach = 1.5;

struct ChipKeypoints {
  Keypoints keypoints;                     // chip by chip; sizes in metres
  std::vector<Eigen::Vector3d> middles_m;  // of the chips, on the ground
  std::vector<std::size_t> chip;           // of each keypoint, its index
  std::vector<Eigen::Vector2d> offset_m;   // from the chip's middle, to the right and down
  std::vector<Eigen::Vector3d> ground_m;
};

struct Pair {
  KeypointMatch match;        // chip's, photo's
  double turn_rad = 0;        // from chip to scan
  double gsd_m = 0;           // of a scan pixel
  Eigen::Vector2d middle_px;  // of the chip in the scan
};

// Scanned through its back: its scan, as it is, shows chips mirrored.
bool IsMirrored(const FilmPosition& position);

// Kappa of a photo, its film lying so, that turns what lies on the ground so.
double KappaOf(double turn_rad, const FilmPosition& position);

// Of the whole photo at a reduction, the smallest first; pixels and sizes in scan pixels.
Keypoints KeypointsOf(const PhotoImage& photo, int reduction);

// Of these, those whose chips are at least so wide, at most `most`, spread over the region.
std::vector<std::size_t> PatchesToShow(const std::vector<patchdb::Patch>& patches,
                                       const std::vector<std::size_t>& which, double least_width_m,
                                       int most);

// Those of each chip, whatever their size; by the patch's index.
using KeypointsByPatch = std::map<std::size_t, Keypoints>;

// Of these patches' chips, at least so large on the ground. `mirrored`: as IsMirrored. `found`:
// those of the patches that are there already, and those found now.
ChipKeypoints KeypointsOf(const std::vector<patchdb::Patch>& patches,
                          const std::vector<std::size_t>& which, double least_size_m, bool mirrored,
                          KeypointsByPatch* found);

// Pairs whose descriptors are nearer to one another than to others (Lowe 2004), and nearest
// ones with which another one of their chip agrees on where it lies: where years lie between the
// nearest one is seldom right, two that agree are seldom wrong.
// Only what is `comparable` is compared, photo's keypoints with one of the chips'.
std::vector<Pair> AlikePairs(const Keypoints& photo, const ChipKeypoints& chips,
                             const Comparable& comparable, int reduction);

// Of each pair, how many other chips have one that lies from it where both their turns and scales
// say that it should: of wrong pairs few do, by chance. Not those nearer than `apart_px` of the
// scan, which may show the same ground and be wrong together. `mirrored`: as IsMirrored.
std::vector<int> Backing(const std::vector<Pair>& pairs, const Keypoints& photo,
                         const ChipKeypoints& chips, bool mirrored, double apart_px);

// The pairs of the `turns` turns with most of them, the fullest first, each with `fewest` at least.
std::vector<std::vector<Pair>> ByTurn(std::vector<Pair> pairs, int turns, std::size_t fewest);

}  // namespace orient::exterior

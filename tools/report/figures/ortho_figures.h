// The orthophotos that lie in a block's folder, as their own metadata describe them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/pose.h"
#include "core/terrain/ground_accuracy.h"
#include "tools/report/figures/mosaic_sources.h"

namespace orient {

// Share of a frame with heights from which on it counts as whole.
inline constexpr double kWholeFrame = 0.99;

struct OrthoFigures {
  std::string photo, file;    // `file` relative to the block's folder, "ortho/4711.ortho.tif"
  int width = 0, height = 0;  // px
  std::optional<double> gsd_m = {};         // what a pixel shows
  std::optional<GroundAccuracy> ce90 = {};  // empty where the pose has no covariance
  std::string dem = {};                     // file name
  std::optional<Pose> pose = {};            // that it was made with; older ones do not say
  std::string made_from = {};               // kMadeFrom
  std::optional<double> with_heights = {};  // share of the frame under which the DEM has some
};

struct MosaicFigures {
  std::string file;
  int width = 0, height = 0;                // px
  std::optional<GroundAccuracy> ce90 = {};  // of its photos: median, and the worst place of all
  bool says_sources = false;                // older ones do not say what they were made from
  MosaicChanges changes = {};               // of the orthophotos since
};

struct OrthoFolder {
  std::string folder;                // within the block's, "ortho"; empty: that itself
  std::vector<OrthoFigures> photos;  // by name
  std::optional<MosaicFigures> mosaic = {};
  std::string seamlines = {}, tones = {};  // files; empty where there is none
  // Photos whose orthophoto was made with a pose other than that of orientation.csv, and those
  // that have none there.
  std::vector<std::string> of_other_poses = {}, without_pose = {};
  std::vector<std::string> unreadable = {};
};

// Of <directory>/ortho, where `orient ortho` and a block file's [ortho] put them, or of the
// directory itself. Empty where neither holds an orthophoto or a mosaic. What cannot be read is
// named and left out.
std::optional<OrthoFolder> ReadOrthoFolder(const std::string& directory);

// Of this folder itself.
OrthoFolder ReadOrthophotosIn(const std::string& folder);

// Median of the photos' medians, and the worst place of all; empty where no photo has a CE90.
std::optional<GroundAccuracy> AccuracyOfAll(const std::vector<OrthoFigures>& photos);

}  // namespace orient

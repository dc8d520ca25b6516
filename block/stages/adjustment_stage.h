// The block adjustment between files: what goes in from the photos' results, ties and the patch
// database, and what each photo's final result is.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "block/bundle/adjustment.h"
#include "block/inputs/block_photos.h"
#include "block/inputs/pose_observations.h"
#include "block/stages/measured_points.h"
#include "block/ties/tie_file.h"
#include "core/files/results.h"
#include "core/measurements/measurements.h"
#include "core/terrain/ground_surface.h"

namespace orient::block {

// Prior sigma of a strip's shift, large enough for a geoid height that was not subtracted.
inline constexpr double kGnssShift_m = 100;

// Ties that hold a photo without control enough of its own: so many, and of this redundancy
// together; below, no error is detectable.
inline constexpr int kLeastTies = 6;
inline constexpr double kLeastTieRedundancy = 6;

// What is known of the photo's pose beside what it shows.
void AddKnown(const PoseObservations& known, BlockPhoto* photo);

struct AdjustmentInputs {
  const std::vector<BlockPhotoFile>& photos;
  const std::vector<TieRecord>& ties;
  const Camera& camera;
  const GroundSurface& surface;
  std::string patchdb;
  BlockAdjustmentChoice choice;
  PoseObservations known = {};
  // What people measured: surveyed points, and ties seen in two photos or more. Null: nothing.
  const Measurements* measured = nullptr;
};

// What was adjusted and what came out; indices of `block` go through `photo_of` to those of the
// inputs' photos.
struct AdjustedBlock {
  BlockToAdjust block;
  BlockResult result;
  std::vector<std::size_t> photo_of;
  bool by_measurements = false;               // alone: photos have no poses but these
  std::size_t ties = 0;                       // the first so many points are ties
  std::vector<SurveyedPoint> surveyed;        // of those that people measured
  std::map<std::int64_t, std::size_t> patch;  // point of a control patch
  // Sightings of check patches that their photo's own orientation had rejected as gross errors, so
  // that they are not among the checks.
  int checks_rejected_alone = 0;
};

// An adjusted block with the result of each photo.
struct JudgedBlock {
  AdjustedBlock adjusted;
  std::vector<ExteriorResult> results;
  Findings findings;  // of the block as a whole
};

// Adds to the covariances of film photos' poses the effect of film bending between its marks, which
// neighbouring observations share. `height_under_m`: of the ground below an adjusted photo.
void AddFilmBends(const std::function<double(std::size_t photo)>& height_under_m,
                  AdjustedBlock* adjusted);

// Throws InputError where the patch database cannot be read.
AdjustedBlock AdjustPhotos(const AdjustmentInputs& inputs);

}  // namespace orient::block

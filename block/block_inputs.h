// What a block's run starts from, read and checked before the work: block file, camera, approximate
// orientations, and what all photos' results are made from.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "block/inputs/block_approximations.h"
#include "block/stages/exterior_stage.h"
#include "block/stages/interior_stage.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/measurements/measurements.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {

struct BlockRunOptions {
  BlockFile block;  // its camera is the path of a file
  bool resume = false;
  bool learn = false;  // record in the patch database what matched
  int jobs = 0;
};

// For a block with [control] the run makes the patch database, which takes long: all is checked
// before, by inputs that lack the database and from which nothing is oriented.
enum class Patches { kThere, kToBeMade };

class BlockInputs {
 public:
  // Throws InputError for what concerns all photos: tables, strips, camera, DEM, patch database.
  explicit BlockInputs(BlockRunOptions options, Patches patches = Patches::kThere);
  // Not copied: the approximations refer to the block.
  BlockInputs(const BlockInputs&) = delete;
  BlockInputs& operator=(const BlockInputs&) = delete;

  const BlockFile& Block() const { return options_.block; }
  const BlockRunOptions& Options() const { return options_; }
  const std::string& OutputDirectory() const { return options_.block.output_directory; }
  // With the earth's curvature and refraction in its lens, where they matter.
  const CameraFile& Camera() const { return camera_; }
  const interior::MarkShapes& Marks() const { return marks_; }  // empty for a digital camera
  bool IsFilm() const { return camera_.camera.kind == CameraKind::kFilm; }
  // What people measured and decided.
  const Measurements& ManualMeasurements() const { return measurements_; }
  // Updated as photos are oriented.
  BlockApproximations& Approximations() const { return *approximations_; }
  // What all photos' results are made from: camera with the earth in its lens, DEM, CRS, flight ...
  const Inputs& Shared() const { return shared_; }

  // Of the block's interior and exterior stage; the latter's results in `directory`.
  InteriorRunOptions Interior() const;
  ExteriorRunOptions Exterior(const std::string& directory) const;

 private:
  void DecideOnTheEarth();

  BlockRunOptions options_;
  Measurements measurements_;
  CameraFile camera_;
  interior::MarkShapes marks_;
  std::optional<double> earth_k1_;  // in camera_ since it is decided
  std::unique_ptr<BlockApproximations> approximations_;
  Inputs shared_;
  std::string patches_;  // digest
};

// Which of the block's photos (indices) to orient next, after those of `so_far` that have a photo's
// name; what is known of the others may follow from these.
std::vector<std::size_t> NextPhotos(const BlockInputs& inputs,
                                    const std::vector<ExteriorResult>& so_far);

}  // namespace orient::block

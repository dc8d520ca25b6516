// A part of a block's work, so that several runs, on several machines, share one output folder.
//
// Every photo's result is a file of its own that is written whole and says what it was made from:
// correctness rests on that and on rename, not on locks. What a part leaves is what the run of the
// whole block would have made, byte for byte, and that run takes it over.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "block/block_folder.h"
#include "block/block_inputs.h"
#include "core/base/progress.h"

namespace orient::block {

enum class BlockStage { kInterior, kExterior };
inline constexpr std::array kBlockStages = {BlockStage::kInterior, BlockStage::kExterior};
std::string Name(BlockStage stage);  // "interior", "exterior"
// Where the stage leaves a photo's result, below the block's output folder.
std::string ResultPathOf(BlockStage stage, const std::string& directory, const std::string& photo);

// Every `of`-th photo of the block, beginning with the `number`-th.
struct PhotosOfPart {
  std::size_t number = 1, of = 1;

  bool Has(std::size_t photo) const { return photo % of == number - 1; }
  bool IsAll() const { return of == 1; }
};

// From "17/200". Empty if the text has another form, or the number is out of range.
std::optional<PhotosOfPart> PhotosOfPartFromText(const std::string& text);

struct PartOutcome {
  std::size_t done = 0;  // photos of the part that have a result now
  std::size_t left = 0;  // that wait for results of photos of other parts
  std::size_t failed = 0;
};

// The part's photos in one stage. The interior stage as a whole (PhotosOfPart::IsAll) also compares
// the photos with each other, which may change results: it is to end before exterior orientation
// begins. Throws InputError for what concerns all photos, UsageError where the exterior orientation
// of film lacks interior results.
PartOutcome RunPart(const BlockInputs& inputs, const BlockFolder& folder, BlockStage stage,
                    const PhotosOfPart& part, ProgressListener* listener);

// The results of one stage that exist, whichever run made them.
struct StageStatus {
  BlockStage stage = BlockStage::kInterior;
  std::size_t photos = 0, ok = 0, weak = 0, failed = 0, unreadable = 0;
  std::optional<double> per_hour;  // results of the last hour, or since the first one
  std::size_t Left() const { return photos - ok - weak - failed - unreadable; }
};
// By the files in the folder: results of changed inputs count until they are made anew.
std::vector<StageStatus> StatusOf(const std::vector<std::string>& photos,
                                  const std::string& directory, bool film);

}  // namespace orient::block

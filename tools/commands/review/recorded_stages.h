// Doing again what run.json says that an output folder was made by.
#pragma once

#include <optional>
#include <string>

#include "block/stages/exterior_setting.h"
#include "block/stages/interior_stage.h"
#include "core/base/progress.h"

namespace orient {

// The runs of `orient interior` and `orient exterior` that a folder holds the results of.
struct RecordedStages {
  std::optional<block::InteriorRunOptions> interior;
  std::optional<block::ExteriorRunOptions> exterior;
  std::string measurements;  // the folder that they read; empty: none
  std::string why_not;       // they cannot be repeated; empty: they can
};

// Never throws: what cannot be repeated is said by `why_not`.
RecordedStages ReadRecordedStages(const std::string& directory);

// As the same commands with --resume do, with these measurements. Throws what they throw, before
// anything is changed where the stages do not fit what is there.
void DoAgain(const RecordedStages& stages, const Measurements& measurements, bool learn, int jobs,
             ProgressListener* listener);

}  // namespace orient

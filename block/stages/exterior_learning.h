// What a run of exterior orientation tells the patch database.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "patchdb/regions/control_patches.h"

namespace orient::block {

// Parts of a block (block/part.h) tell nothing; by this note in the folder of their results the run
// of the whole tells what they found.
void LeaveToLearn(const std::string& directory);

// The patch database learns when all photos are done: what one photo teaches must not change how
// the next one is searched for, or results would depend on their order and on interruptions. The
// same note outlives a killed run; the next one tells what that one found, too.
class Learning {
 public:
  // `directory`: of the results; `resume`: what an interrupted run found there is told, too. Throws
  // InputError where the database cannot be written: before hours of work, not after the first
  // photo.
  Learning(const std::string& patchdb, const std::string& directory, bool resume);

  // `photos`: their scans' paths, in the order of the results, `dates` of their exposures where
  // these are known. `fresh`: results of this run. What cannot be told does not take a photo's
  // orientation away; then the note stays, and the next run tells all again.
  void Tell(const std::vector<std::string>& photos,
            const std::vector<std::optional<std::string>>& dates, const std::vector<char>& fresh,
            std::vector<ExteriorResult>* results);

 private:
  std::string directory_;
  patchdb::ControlPatches database_;
  std::string note_;
  bool interrupted_ = false;  // an earlier run, before it told anything
};

}  // namespace orient::block

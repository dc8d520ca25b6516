// What a run of exterior orientation records in the patch database.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "patchdb/regions/control_patches.h"

namespace orient::block {

// Parts of a block (block/part.h) record nothing; from this note in their results' folder the run
// of the whole block knows that it is to record what they found.
void LeaveToLearn(const std::string& directory);

// Attempts are recorded when all photos are done: those of one photo must not change how
// the next one is searched for, or results would depend on their order and on interruptions. The
// same note outlives a killed run; the next run then records what that run found, too.
class Learning {
 public:
  // `directory`: of the results; `resume`: also record what an interrupted run found there. Throws
  // InputError where the database cannot be written: before hours of work, not after the first
  // photo.
  Learning(const std::string& patchdb, const std::string& directory, bool resume);

  // `photos`: their scans' paths, in the order of the results, `dates` of their exposures where
  // these are known. `fresh`: results of this run. If recording fails, the photos keep their
  // orientation; the note then stays, and the next run records everything again.
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

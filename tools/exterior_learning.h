// What a run of exterior orientation tells the patch database.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/geometry/camera.h"
#include "patchdb/patch_database.h"
#include "tools/exterior_run.h"

namespace orient {

// A file of an older program that will be told is brought up to date before anything is read of it;
// `out` hears of it. Throws InputError where it cannot be written.
void BringUpToDateForFeedback(const std::string& patchdb, std::ostream& out);

// The patch database learns when all photos are done: what one photo teaches must not change how
// the next one is sought, or results would depend on their order and on interruptions. A note in
// the folder outlives a killed run; the next one tells what that one found, too.
class Learning {
 public:
  explicit Learning(const ExteriorRunOptions& options);

  // `fresh`: results of this run. What cannot be told does not take a photo's orientation away.
  void Tell(const std::vector<char>& fresh, CameraKind kind, std::vector<ExteriorResult>* results);

 private:
  const ExteriorRunOptions& options_;
  std::optional<PatchDatabase> database_;
  std::string note_;
  bool interrupted_ = false;  // an earlier run, before it told anything
};

}  // namespace orient

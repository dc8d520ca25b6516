// Patches of another database taken over: merged, copied in part, or as a newer epoch.
#pragma once

#include <cstdint>
#include <functional>

#include "patchdb/store/patch_database.h"
#include "patchdb/store/selection.h"

namespace orient::patchdb {

enum class MergePolicy {
  kMerge,    // duplicates by place and look become one patch with both histories
  kReplace,  // what is newer than all patches of its place supersedes them
  kAdd,      // what is newer than all patches of its place is added, or joined if it looks the same
  kCopy      // everything is added as it is: into an empty database
};

struct MergeOptions {
  MergePolicy policy = MergePolicy::kMerge;
  PatchFilter filter;  // of the other database
};

struct MergeResult {
  std::int64_t sources = 0;     // that were not there before
  std::int64_t added = 0;       // patches
  std::int64_t duplicates = 0;  // patches that were there; what the other one knew is joined
  std::int64_t improved = 0;    // duplicates whose view there was the worse one
  std::int64_t superseded = 0;  // patches retired for a newer one
  std::int64_t not_newer = 0;   // left out: there is a view as new
  std::int64_t attempts = 0;    // taken over
  std::int64_t elsewhere = 0;   // left out: no coordinates in this CRS
};

// Told of sources done and in all, after each one's transaction.
using MergeProgress = std::function<void(int done, int total)>;

// Every source of the other database with its patches, attempts and evidence is one transaction: an
// interrupted merge is simply started again, and does nothing twice; nor does a second merge of the
// same database. A source of which nothing is taken leaves no trace. The other database may have
// another CRS. Throws InputError: a damaged patch (nothing of its source is taken then), and like
// the members of PatchDatabase.
MergeResult MergeDatabase(PatchDatabase& target, const PatchDatabase& other,
                          const MergeOptions& options, const MergeProgress& progress = {});

}  // namespace orient::patchdb

// Harvests several sources into a patch database, one after another: every source with the others
// that show the same ground as witnesses.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "block/inputs/harvest_sources.h"
#include "core/base/progress.h"
#include "patchdb/harvest/harvest.h"
#include "patchdb/store/patch_database.h"

namespace orient::block {

struct HarvestRun {
  std::string dem;
  std::string dsm;             // empty: none
  patchdb::PatchSource about;  // date, provenance and licence of every source
  patchdb::HarvestOptions options;
};

// The outcome for one source.
struct HarvestedSource {
  std::string name;
  bool known = false;  // in the database already: left alone
  std::ptrdiff_t patches = 0, good = 0, seen_twice = 0;
  std::array<int, patchdb::kAllRefusals.size()> refused = {};  // candidates, by reason
  double gsd_m = 0;
};

// How the database distinguishes this file from others: by kind, name and content.
patchdb::PatchSource SourceOfFile(patchdb::SourceKind kind, const std::string& path,
                                  const patchdb::PatchSource& about);

// Which of these sources are harvested already: a run leaves them alone.
std::vector<bool> AreHarvested(const patchdb::PatchDatabase& database, patchdb::SourceKind kind,
                               const std::vector<std::string>& paths,
                               const patchdb::PatchSource& about);

// Every source is one transaction; those in the database already are left alone, but give evidence.
// `listener` may be null. Throw InputError where an input is wrong: before anything is stored where
// that can be known.
std::vector<HarvestedSource> HarvestPhotos(patchdb::PatchDatabase& database, const HarvestRun& run,
                                           const PhotosToHarvest& photos,
                                           ProgressListener* listener = nullptr);
std::vector<HarvestedSource> HarvestOrthophotos(patchdb::PatchDatabase& database,
                                                const HarvestRun& run,
                                                const std::vector<std::string>& paths,
                                                ProgressListener* listener = nullptr);

}  // namespace orient::block

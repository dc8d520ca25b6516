// What a run uses of patches: those of one database, or of a folder of regions
// (patchdb/regions/region_index.h), of which only those are opened that a photo needs.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "patchdb/regions/region_index.h"
#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

// Use it from one thread at a time. Of a folder, ids are the set's: a patch's is its region's
// number times 10^9 and its id there, a source's that of the index. The members throw InputError as
// those of PatchDatabase.
class ControlPatches {
 public:
  using Mode = PatchDatabase::Mode;
  // Throws InputError as PatchDatabase::Open and ReadRegionIndex; with kWrite of a folder, too,
  // where a database in it may not be written.
  static ControlPatches Open(const std::string& path, Mode mode = Mode::kRead);
  // The same for another thread: the list of regions is read once.
  ControlPatches Another() const;

  // Throws InputError where the index of a folder is out of date. Looks at every file: for the
  // beginning of a run, not for every photo.
  void RequireCurrentIndex() const;

  Crs GroundCrs() const;
  // As PatchDatabase::FindPatchesIn. What several regions hold of the same source at the same
  // place comes once.
  std::vector<Patch> FindPatchesIn(const Bounds& bounds, int max_count = 10000) const;
  std::optional<Patch> ReadPatch(std::int64_t id) const;
  std::vector<PatchSource> Sources() const;
  // As ContentOf, of the regions that touch one of `areas`; of all of a single database.
  std::string ContentWithin(const std::vector<Bounds>& areas) const;
  // One transaction per region. If one of them fails, the others are recorded nevertheless, and
  // the first error is thrown then. Returns what PatchDatabase::RecordAttempts does, of all.
  int RecordAttempts(const std::vector<MatchAttempt>& attempts);

 private:
  ControlPatches(std::string path, Mode mode) : path_(std::move(path)), mode_(mode) {}
  bool IsFolder() const { return static_cast<bool>(index_); }
  const Region* RegionOf(std::int64_t id) const;
  PatchDatabase& OpenedRegion(const Region& region) const;
  Patch AsOfSet(Patch patch, const Region& region) const;
  std::vector<const Region*> RegionsTouching(const std::vector<Bounds>& areas) const;
  using AttemptsByRegion = std::map<int, std::vector<MatchAttempt>>;
  AttemptsByRegion Divided(const std::vector<MatchAttempt>& attempts) const;
  std::vector<SoughtElsewhere> Sought(const Region& region,
                                      const std::vector<MatchAttempt>& own) const;

  std::string path_;
  Mode mode_;
  std::shared_ptr<const RegionIndex> index_;     // of a folder
  mutable std::map<int, PatchDatabase> opened_;  // by the region's number; 0: the one database
};

}  // namespace orient::patchdb

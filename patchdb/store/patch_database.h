// The patch database: one SQLite file that is a valid GeoPackage. Callers use records, not SQL.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/terrain/crs.h"
#include "core/terrain/ground_surface.h"
#include "patchdb/store/match_attempt.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

class Connection;

// A source in the database: of the same kind and name, and of the same content; where the content
// of one is unknown, of the same date.
struct KnownSource {
  std::optional<std::int64_t> id;  // empty: not there
  bool harvested = false;          // not only named as showing patches of others
  std::string name;  // there, or free for it: "4711.tif (2)" where another has its name
};

struct PatchDatabaseInfo {
  std::string crs_name;
  int schema_version = 0;
  std::int64_t patches = 0, retired = 0, sources = 0, attempts = 0;
  Bounds extent;
};

// One connection; use it from one thread at a time. Several programs may read while one writes.
// Every member throws InputError naming the file where it is damaged, full, or busy for too long.
class PatchDatabase {
 public:
  enum class Mode { kRead, kWrite };
  // Throws InputError: exists already, folder not writable.
  static PatchDatabase Create(const std::string& path, const Crs& crs);
  // The same with what `fill` puts into it: until that is through there is no file of this name.
  static PatchDatabase Create(const std::string& path, const Crs& crs,
                              const std::function<void(PatchDatabase&)>& fill);
  // Never creates a file; kRead opens it read-only. Throws InputError: missing, not a patch
  // database, a newer schema than this program's, an older one that kRead may not bring up to date.
  // A writer waits up to wait_s for another one's transaction, then the error says who holds it.
  static PatchDatabase Open(const std::string& path, Mode mode, double wait_s = 30);
  PatchDatabase(PatchDatabase&&) noexcept;
  PatchDatabase& operator=(PatchDatabase&&) noexcept;
  ~PatchDatabase();

  const Crs& GroundCrs() const;
  PatchDatabaseInfo Info() const;

  // One transaction: the source and its patches are stored together or not at all. Ids are set.
  // Grey values are stored rounded to whole numbers, heights to a
  // quarter of their sigma, at least gsd_m / 64 and at most gsd_m / 8. The source's name gets a
  // number where another one has it. Throws InputError: the source is harvested already;
  // std::invalid_argument: a patch without chip, size or position.
  void AddSource(PatchSource& source, std::vector<Patch>& patches);
  // The same with evidence that names its source by its place in `witnesses` (as
  // PatchEvidence::source_id does until then). Those that are named and not there yet are made in
  // the same transaction, as not harvested.
  void AddSource(PatchSource& source, std::vector<Patch>& patches,
                 const std::vector<PatchSource>& witnesses);
  // Active ones, ordered by id. Of more than `max_count` about so many, spread evenly over their
  // sources, so that an absurd region does not fill the memory; the same ones every time.
  std::vector<Patch> FindPatchesIn(const Bounds& bounds, int max_count = 10000) const;
  // How many there are of them; near the border of the region a few more.
  std::int64_t CountPatchesIn(const Bounds& bounds) const;
  // Active and retired.
  std::vector<Patch> ListPatches(std::int64_t after_id, int count) const;
  // With colour and evidence; empty where there is none of this id.
  std::optional<Patch> ReadPatch(std::int64_t id) const;
  // Where an attempt's patch was sought; empty where neither the attempt nor the database says.
  std::optional<Eigen::Vector2d> PlaceSought(const MatchAttempt& attempt) const;
  std::vector<PatchSource> Sources() const;
  KnownSource FindSource(const PatchSource& source) const;
  // One transaction. A later attempt of the same patch in the same photo replaces the earlier one;
  // patches that were deleted meanwhile are left out, and attempts of which the database has
  // another patch of that number by now (it was made anew); returns how many of these. What the
  // patches' histories say then is noted with them, and those that keep failing where their
  // neighbours succeed are retired: patchdb/store/learning.h. `elsewhere`: neighbours that other
  // databases hold.
  int RecordAttempts(const std::vector<MatchAttempt>& attempts,
                     const std::vector<SoughtElsewhere>& elsewhere = {});

  // For the other files of patchdb: the file, its SQL, and one transaction around `work`, which
  // answers how many rows it changed.
  const std::string& Path() const;
  int Write(const char* doing, const std::function<int(Connection&)>& work);
  Connection& Sql() const;
  int SrsId() const;
  // The caller holds the transaction.
  void GrowExtent(const Eigen::Vector2d& place_m);
  // The source with its id and name here; made where it is not there. One that was only named
  // becomes a harvested one, not the other way round.
  PatchSource StoreSource(const PatchSource& source, bool harvested);

 private:
  void StoreHarvest(PatchSource& source, std::vector<Patch>& patches,
                    const std::function<std::int64_t(std::int64_t)>& witness_id);
  struct Impl;
  explicit PatchDatabase(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace orient::patchdb

// The patch database: one SQLite file that is a valid GeoPackage. Verbs on records, no SQL outside.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/crs.h"
#include "core/geometry/ground_surface.h"
#include "patchdb/patch.h"

namespace orient {

// One patch sought in one photo: what a photo's orientation reports back.
struct MatchAttempt {
  std::int64_t patch_id = 0;
  std::string photo;
  std::string state;  // PatchState's name
  std::optional<double> ncc;
  std::optional<Eigen::Vector2d> residual_px;
  std::string reason;
};

struct PatchDatabaseInfo {
  std::string crs_name;
  int schema_version = 0;
  std::int64_t patches = 0, sources = 0, attempts = 0;
  Bounds extent;
};

// One connection; use it from one thread at a time. Several programs may read while one writes.
// Every member throws InputError naming the file where it is damaged, full, or busy for too long.
class PatchDatabase {
 public:
  enum class Mode { kRead, kWrite };
  // Throws InputError: exists already, folder not writable.
  static PatchDatabase Create(const std::string& path, const Crs& crs);
  // Never creates a file; kRead opens it read-only. Throws InputError: missing, not a patch
  // database, a newer schema than this program's, an older one that kRead may not bring up to date.
  static PatchDatabase Open(const std::string& path, Mode mode);
  PatchDatabase(PatchDatabase&&) noexcept;
  PatchDatabase& operator=(PatchDatabase&&) noexcept;
  ~PatchDatabase();

  const Crs& GroundCrs() const;
  PatchDatabaseInfo Info() const;

  // One transaction: the source and its patches are stored together or not at all. Ids are set.
  // Grey values are stored rounded to whole numbers. Throws InputError: a source of this kind and
  // name is there already; std::invalid_argument: a patch without chip, size or position.
  void AddSource(PatchSource& source, std::vector<Patch>& patches);
  // Ordered by id. Of more than `max_count` about so many, spread evenly over their sources, so
  // that an absurd region does not fill the memory; the same ones every time.
  std::vector<Patch> FindPatchesIn(const Bounds& bounds, int max_count = 10000) const;
  std::vector<Patch> ListPatches(std::int64_t after_id, int count) const;
  std::vector<PatchSource> Sources() const;
  bool HasSource(SourceKind kind, const std::string& name) const;
  // One transaction. A later attempt of the same patch in the same photo replaces the earlier one.
  void RecordAttempts(const std::vector<MatchAttempt>& attempts);

 private:
  struct Impl;
  explicit PatchDatabase(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace orient

// Records as rows: binding a patch to its INSERT, reading it from its SELECT. Private to patchdb.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "patchdb/store/match_attempt.h"
#include "patchdb/store/patch.h"
#include "patchdb/store/patch_blobs.h"

namespace orient::patchdb {

// Throws std::invalid_argument: no chip, bits other than 8 or 16, no position, heights of a wrong
// shape.
void CheckPatch(const Patch& patch);

// The values of sql::kAddPatch and kChangePatch: the first kPatchValues parameters.
inline constexpr int kPatchValues = 24;
void BindPatch(const Patch& patch, int srs_id, SQLite::Statement& statement);

// A patch whose pictures are still packed: rows come one by one, but many can be unpacked at once.
struct StoredHeights {
  std::optional<Bytes> bytes = {};  // empty: no heights
  int size = 0;
  double step_m = 0;
  std::optional<double> base_m = {}, quantum_m = {};
};
struct PackedPatch {
  Patch patch;  // but chip, colour and heights
  Bytes chip;
  std::optional<Bytes> mask;
  StoredHeights heights;
};
// Of sql::kPatchesIn, kPatchesAfter and kPatch. Both throw InputError naming the patch where a
// value is damaged.
PackedPatch ReadPatchRow(const SQLite::Statement& row);
Patch Unpack(PackedPatch packed, bool with_colour);

PatchEvidence ReadEvidenceRow(const SQLite::Statement& row);  // of sql::kEvidenceOf

PatchSource ReadSourceRow(const SQLite::Statement& row);  // of sql::kSources
// The values of sql::kAddSource and kChangeSource: the first kSourceValues parameters.
inline constexpr int kSourceValues = 9;
void BindSource(const PatchSource& source, bool harvested, SQLite::Statement& statement);
void BindEvidence(std::int64_t patch_id, std::int64_t source_id, const PatchEvidence& evidence,
                  SQLite::Statement& insert);  // of sql::kAddEvidence
// Of sql::kRecordAttempt, but the last two.
void BindAttempt(const MatchAttempt& attempt, SQLite::Statement& insert);

}  // namespace orient::patchdb

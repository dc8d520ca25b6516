// Records as rows: binding a patch to its INSERT, reading it from its SELECT. Private to patchdb.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "patchdb/patch.h"
#include "patchdb/patch_database.h"

namespace orient {

// Throws std::invalid_argument: no chip, bits other than 8 or 16, no position, heights of a wrong
// shape.
void CheckPatch(const Patch& patch);

// The values of sql::kAddPatch and kChangePatch: the first kPatchValues parameters.
inline constexpr int kPatchValues = 24;
void BindPatch(const Patch& patch, int srs_id, SQLite::Statement& statement);
// Of sql::kPatchesIn, kPatchesAfter and kPatch. Throws InputError naming the patch where a value is
// damaged.
Patch ReadPatchRow(const SQLite::Statement& row, bool with_colour = false);
PatchEvidence ReadEvidenceRow(const SQLite::Statement& row);  // of sql::kEvidenceOf

PatchSource ReadSourceRow(const SQLite::Statement& row);  // of sql::kSources
// The values of sql::kAddSource and kChangeSource: the first kSourceValues parameters.
inline constexpr int kSourceValues = 9;
void BindSource(const PatchSource& source, bool harvested, SQLite::Statement& statement);
void BindEvidence(std::int64_t patch_id, std::int64_t source_id, const PatchEvidence& evidence,
                  SQLite::Statement& insert);  // of sql::kAddEvidence
// Of sql::kRecordAttempt, but the last two.
void BindAttempt(const MatchAttempt& attempt, SQLite::Statement& insert);

}  // namespace orient

// Records as rows: binding a patch to its INSERT, reading it from its SELECT. Private to patchdb.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include "patchdb/patch.h"
#include "patchdb/patch_database.h"

namespace orient {

// Throws std::invalid_argument: no chip, bits other than 8 or 16, no position, heights of a wrong
// shape.
void CheckPatch(const Patch& patch);

// For sql::kAddPatch, without its source_id taken from the patch.
void BindPatch(const Patch& patch, std::int64_t source_id, int srs_id, SQLite::Statement& insert);
// Of sql::kPatchesIn and kPatchesAfter. Throws InputError naming the patch where a value is
// damaged.
Patch ReadPatchRow(const SQLite::Statement& row);

PatchSource ReadSourceRow(const SQLite::Statement& row);  // of sql::kSources
void BindAttempt(const MatchAttempt& attempt, SQLite::Statement& insert);

const char* Name(SourceKind kind);  // "photo", "orthophoto"

}  // namespace orient

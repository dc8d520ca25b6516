// Schema version 3: sources are distinguished by their content, and may be known before they are
// harvested; attempts by the photo's content. The table `attempts` is written anew for its key.

#include "patchdb/store/schema.h"

namespace orient::patchdb {
namespace {

constexpr const char* kSql = R"sql(
ALTER TABLE sources ADD COLUMN digest TEXT;                   -- of its content; NULL: unknown
ALTER TABLE sources ADD COLUMN harvested BOOLEAN NOT NULL DEFAULT 1;  -- 0: only shows patches

CREATE TABLE attempts_3 (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  patch_id INTEGER NOT NULL REFERENCES patches(id),
  photo TEXT NOT NULL,
  photo_digest TEXT NOT NULL DEFAULT '',  -- of the photo's content; empty: unknown
  state TEXT NOT NULL,                   -- matched, not_found, rejected, not_visible
  ncc DOUBLE,
  residual_col_px DOUBLE,
  residual_row_px DOUBLE,
  reason TEXT NOT NULL,
  photo_date TEXT,                       -- ISO 8601, of the exposure
  photo_status TEXT,                     -- ok, weak, failed: of the whole photo
  recorded DATETIME,                     -- UTC
  epoch INTEGER NOT NULL DEFAULT 1,      -- of the patch at that time
  predicted_col_px DOUBLE,               -- pixel of the photo
  predicted_row_px DOUBLE,
  found_col_px DOUBLE,                   -- NULL: not found
  found_row_px DOUBLE,
  neighbours_sought INTEGER,             -- nearest patches of the same photo,
  neighbours_matched INTEGER,            -- and how many of them matched
  UNIQUE (patch_id, photo, photo_digest));
INSERT INTO attempts_3 (id, patch_id, photo, state, ncc, residual_col_px, residual_row_px, reason,
    photo_date, photo_status, recorded, epoch, predicted_col_px, predicted_row_px, found_col_px,
    found_row_px, neighbours_sought, neighbours_matched)
  SELECT id, patch_id, photo, state, ncc, residual_col_px, residual_row_px, reason, photo_date,
    photo_status, recorded, epoch, predicted_col_px, predicted_row_px, found_col_px, found_row_px,
    neighbours_sought, neighbours_matched FROM attempts;
DROP TABLE attempts;
ALTER TABLE attempts_3 RENAME TO attempts;
)sql";

}  // namespace

const SchemaStep kSchemaStep3 = {3, "sources and photos told apart by their content", kSql};

}  // namespace orient::patchdb

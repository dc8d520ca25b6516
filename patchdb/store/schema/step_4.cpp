// Schema version 4: a token that changes with everything new photos are oriented from, so that one
// query tells whether earlier results are still current. Triggers maintain it, since other programs
// change patches, too. What is learnt from attempts (weights, retirement by learning) does not
// change it: every oriented photo adds attempts, and would make all other results out of date.
// Packed heights may have 8 bits since this version (255 unknown): a program that knows only those
// of 16 must not read them.

#include "patchdb/store/schema.h"

namespace orient::patchdb {
namespace {

constexpr const char* kSql = R"sql(
CREATE TABLE orient_content (
  id INTEGER PRIMARY KEY NOT NULL CHECK (id = 1),
  token BLOB NOT NULL);                  -- 16 random bytes, new with every change
INSERT INTO orient_content VALUES (1, randomblob(16));
CREATE TRIGGER orient_content_insert AFTER INSERT ON patches
  BEGIN UPDATE orient_content SET token = randomblob(16); END;
CREATE TRIGGER orient_content_delete AFTER DELETE ON patches
  BEGIN UPDATE orient_content SET token = randomblob(16); END;
CREATE TRIGGER orient_content_update AFTER UPDATE OF id, geom, gsd_m, bits, bands, covariance,
    height_effect, height_sigma_m, roundness, distinctness, second_peak_px, persistence, relief_px,
    lean_px, energy_xx, energy_xy, energy_yy, quality, heights_size, heights_step_m, heights_base_m,
    heights_quantum_m, heights, chip_mask, chip ON patches
  BEGIN UPDATE orient_content SET token = randomblob(16); END;
CREATE TRIGGER orient_content_state AFTER UPDATE OF state ON patches
  WHEN OLD.state <> NEW.state AND NOT (NEW.state = 'retired' AND coalesce(NEW.retired_reason, '')
    LIKE 'failed in % photos where its neighbours matched%')
  BEGIN UPDATE orient_content SET token = randomblob(16); END;
INSERT INTO gpkg_contents (table_name, data_type, identifier, description) VALUES
  ('orient_content', 'attributes', 'orient_content', 'Token of what the patches are');
)sql";

}  // namespace

const SchemaStep kSchemaStep4 = {4, "a token that changes with the patches", kSql, true};

}  // namespace orient::patchdb

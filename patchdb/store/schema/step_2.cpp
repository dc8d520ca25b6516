// Schema version 2: adds state, quality and learnt weights of patches, further views, provenance of
// sources, and where attempts searched for the patch. The tables `patches` and
// `sources` are written anew: short columns first and the BLOBs last, so that reading the former
// does not touch the pages of the latter. Run with foreign keys off (SQLite, "Making Other Kinds Of
// Table Schema Changes").

#include "patchdb/store/schema.h"

namespace orient::patchdb {
namespace {

constexpr const char* kSql = R"sql(
CREATE TABLE sources_2 (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('photo', 'orthophoto', 'gcp')),
  name TEXT NOT NULL,                    -- file name without folder; of a table for ground control
  date TEXT,                             -- ISO 8601, NULL here and below: unknown
  gsd_m DOUBLE NOT NULL,                 -- typical pixel on the ground
  crs TEXT,                              -- its own CRS where it has one
  provenance TEXT,                       -- who made it, from what
  licence TEXT,
  added DATETIME,                        -- when it came into the database, UTC
  UNIQUE (kind, name));
INSERT INTO sources_2 (id, kind, name, date, gsd_m) SELECT id, kind, name, date, gsd_m FROM sources;
DROP TABLE sources;
ALTER TABLE sources_2 RENAME TO sources;

CREATE TABLE patches_2 (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  geom POINT,                            -- POINT Z: ground position of the chip's centre
  source_id INTEGER NOT NULL REFERENCES sources(id),
  state TEXT NOT NULL DEFAULT 'active' CHECK (state IN ('active', 'retired')),
  retired_reason TEXT,                   -- NULL: active
  retired_on DATE,                       -- UTC; NULL: active
  superseded_by INTEGER REFERENCES patches(id),
  epoch INTEGER NOT NULL DEFAULT 1,      -- counts up with each restore; what happened before an
                                         -- epoch counts less
  created DATE,                          -- when it came into the database, UTC
  gsd_m DOUBLE NOT NULL,                 -- chip pixel in metres
  bits INTEGER NOT NULL CHECK (bits IN (8, 16)),
  bands INTEGER NOT NULL DEFAULT 1 CHECK (bands IN (1, 3)),
  covariance BLOB NOT NULL,              -- of geom, m^2: 6 float64, little-endian:
                                         -- xx xy xz yy yz zz
  height_effect BLOB,                    -- d geom / d height under the source: 3 float64,
                                         -- little-endian, x y z; NULL: unknown
  height_sigma_m DOUBLE,                 -- one sigma of those heights; NULL: unknown
  roundness DOUBLE,                      -- NULL here and below: not measured
  distinctness DOUBLE,                   -- 1 - height of the second autocorrelation peak
  second_peak_px DOUBLE,                 -- how far off that peak is, chip pixels
  persistence DOUBLE,                    -- pyramid levels the texture survives
  relief_px DOUBLE,                      -- spread of the heights under the chip, chip pixels
  lean_px DOUBLE,                        -- how far the surface departs from the chip's heights: lean
                                         -- in chip pixels at 45 degrees
  energy_xx DOUBLE,                      -- mean squared grey gradient by direction: east, ...
  energy_xy DOUBLE,
  energy_yy DOUBLE,                      -- ... north
  quality DOUBLE,                        -- 0 .. 1, of all of these
  views INTEGER NOT NULL DEFAULT 1,      -- sources that show it: its own and those in `evidence`
  success_weight DOUBLE NOT NULL DEFAULT 0,  -- attempts that succeeded and that failed, each
  failure_weight DOUBLE NOT NULL DEFAULT 0,  -- weighted by what it says about the patch of today
  heights_size INTEGER,                  -- nodes a side, odd; NULL: no heights
  heights_step_m DOUBLE,                 -- between nodes; the middle node lies at geom
  heights_base_m DOUBLE,                 -- NULL: heights is heights_size^2 float32, little-endian,
  heights_quantum_m DOUBLE,              -- m, NaN unknown; else a grey 16-bit PNG of that size:
                                         -- base + quantum * value, 65535 unknown
  heights BLOB,                          -- row by row from the north-west
  chip_mask BLOB,                        -- PNG, grey, 8 bit, size of the chip: 255 valid, 0 no
                                         -- data; NULL: every pixel is valid
  chip BLOB NOT NULL);                   -- PNG, grey or RGB (`bands`), 8 or 16 bit, north up
INSERT INTO patches_2 (id, geom, source_id, gsd_m, bits, covariance, height_effect, height_sigma_m,
    roundness, distinctness, persistence, relief_px, heights_size, heights_step_m, heights,
    chip_mask, chip)
  SELECT id, geom, source_id, gsd_m, bits, covariance, height_effect, height_sigma_m,
    roundness, distinctness, persistence, relief_px, heights_size, heights_step_m, heights,
    chip_mask, chip FROM patches;
DROP TABLE patches;
ALTER TABLE patches_2 RENAME TO patches;
CREATE INDEX patches_by_source ON patches(source_id);
CREATE INDEX patches_superseded ON patches(superseded_by) WHERE superseded_by IS NOT NULL;
CREATE INDEX patches_retired ON patches(retired_reason) WHERE state = 'retired';

CREATE TRIGGER rtree_patches_geom_insert AFTER INSERT ON patches
  WHEN (NEW.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
  BEGIN INSERT OR REPLACE INTO rtree_patches_geom VALUES (NEW.id,
    ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom)); END;
CREATE TRIGGER rtree_patches_geom_update1 AFTER UPDATE OF geom ON patches
  WHEN OLD.id = NEW.id AND (NEW.geom NOTNULL AND NOT ST_IsEmpty(NEW.geom))
  BEGIN INSERT OR REPLACE INTO rtree_patches_geom VALUES (NEW.id,
    ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom)); END;
CREATE TRIGGER rtree_patches_geom_update2 AFTER UPDATE OF geom ON patches
  WHEN OLD.id = NEW.id AND (NEW.geom ISNULL OR ST_IsEmpty(NEW.geom))
  BEGIN DELETE FROM rtree_patches_geom WHERE id = OLD.id; END;
CREATE TRIGGER rtree_patches_geom_update3 AFTER UPDATE ON patches
  WHEN OLD.id != NEW.id AND (NEW.geom NOTNULL AND NOT ST_IsEmpty(NEW.geom))
  BEGIN DELETE FROM rtree_patches_geom WHERE id = OLD.id;
    INSERT OR REPLACE INTO rtree_patches_geom VALUES (NEW.id,
    ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom)); END;
CREATE TRIGGER rtree_patches_geom_update4 AFTER UPDATE ON patches
  WHEN OLD.id != NEW.id AND (NEW.geom ISNULL OR ST_IsEmpty(NEW.geom))
  BEGIN DELETE FROM rtree_patches_geom WHERE id IN (OLD.id, NEW.id); END;
CREATE TRIGGER rtree_patches_geom_delete AFTER DELETE ON patches
  WHEN OLD.geom NOT NULL
  BEGIN DELETE FROM rtree_patches_geom WHERE id = OLD.id; END;

ALTER TABLE attempts ADD COLUMN photo_date TEXT;              -- ISO 8601, of the exposure
ALTER TABLE attempts ADD COLUMN photo_status TEXT;            -- ok, weak, failed: of the whole photo
ALTER TABLE attempts ADD COLUMN recorded DATETIME;            -- UTC
ALTER TABLE attempts ADD COLUMN epoch INTEGER NOT NULL DEFAULT 1;  -- of the patch at that time
ALTER TABLE attempts ADD COLUMN predicted_col_px DOUBLE;      -- pixel of the photo
ALTER TABLE attempts ADD COLUMN predicted_row_px DOUBLE;
ALTER TABLE attempts ADD COLUMN found_col_px DOUBLE;          -- NULL: not found
ALTER TABLE attempts ADD COLUMN found_row_px DOUBLE;
ALTER TABLE attempts ADD COLUMN neighbours_sought INTEGER;    -- nearest patches of the same photo,
ALTER TABLE attempts ADD COLUMN neighbours_matched INTEGER;   -- and how many of them matched

-- Further sources that show a patch, where they show it.
CREATE TABLE evidence (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  patch_id INTEGER NOT NULL REFERENCES patches(id),
  source_id INTEGER NOT NULL REFERENCES sources(id),
  col_px DOUBLE,                         -- measured, pixel of the source
  row_px DOUBLE,
  residual_col_px DOUBLE,                -- measured - computed from the patch's ground position
  residual_row_px DOUBLE,
  UNIQUE (patch_id, source_id));
INSERT INTO gpkg_contents (table_name, data_type, identifier, description) VALUES
  ('evidence', 'attributes', 'evidence', 'Further sources that show a patch');
)sql";

}  // namespace

const SchemaStep kSchemaStep2 = {2, "state, quality, learning, evidence, provenance", kSql};

}  // namespace orient::patchdb

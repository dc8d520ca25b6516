// Schema version 1: the GeoPackage's own tables, patches with their R-tree, sources, attempts.
// The BLOBs' layouts stand beside their columns, and in docs/patchdb.md for SQL users.

#include "patchdb/store/schema.h"

namespace orient::patchdb {
namespace {

constexpr const char* kSql = R"sql(
CREATE TABLE gpkg_spatial_ref_sys (
  srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL,
  organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);

CREATE TABLE gpkg_contents (
  table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE,
  description TEXT DEFAULT '',
  last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')),
  min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));

CREATE TABLE gpkg_geometry_columns (
  table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL,
  srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL,
  CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
  CONSTRAINT uk_gc_table_name UNIQUE (table_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));

CREATE TABLE gpkg_extensions (
  table_name TEXT, column_name TEXT, extension_name TEXT NOT NULL, definition TEXT NOT NULL,
  scope TEXT NOT NULL, CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name));

INSERT INTO gpkg_spatial_ref_sys VALUES
  ('Undefined Cartesian SRS', -1, 'NONE', -1, 'undefined',
   'undefined Cartesian coordinate reference system'),
  ('Undefined geographic SRS', 0, 'NONE', 0, 'undefined',
   'undefined geographic coordinate reference system'),
  ('WGS 84 geodetic', 4326, 'EPSG', 4326,
   'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AXIS["Latitude",NORTH],AXIS["Longitude",EAST],AUTHORITY["EPSG","4326"]]',
   'longitude/latitude coordinates in decimal degrees on the WGS 84 spheroid');

CREATE TABLE orient_schema (
  version INTEGER PRIMARY KEY NOT NULL,  -- of the schema after this step
  description TEXT NOT NULL);

CREATE TABLE sources (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('photo', 'orthophoto')),
  name TEXT NOT NULL,                    -- file name without folder
  date TEXT,                             -- ISO 8601, NULL: unknown
  gsd_m DOUBLE NOT NULL,                 -- typical pixel on the ground
  UNIQUE (kind, name));

CREATE TABLE patches (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  geom POINT,                            -- POINT Z: ground position of the chip's centre
  source_id INTEGER NOT NULL REFERENCES sources(id),
  gsd_m DOUBLE NOT NULL,                 -- chip pixel in metres
  bits INTEGER NOT NULL CHECK (bits IN (8, 16)),
  chip BLOB NOT NULL,                    -- PNG, grey, 8 or 16 bit, north up
  chip_mask BLOB,                        -- PNG, grey, 8 bit, size of the chip: 255 valid, 0 no
                                         -- data; NULL: every pixel is valid
  heights BLOB,                          -- heights_size^2 float32, little-endian, m, row by row
                                         -- from the north-west; NaN: unknown. NULL: none at all
  heights_size INTEGER,
  heights_step_m DOUBLE,                 -- between nodes; the middle node lies at geom
  covariance BLOB NOT NULL,              -- of geom, m^2: 6 float64, little-endian:
                                         -- xx xy xz yy yz zz
  height_effect BLOB,                    -- d geom / d height under the source: 3 float64,
                                         -- little-endian, x y z; NULL: unknown
  height_sigma_m DOUBLE,                 -- one sigma of those heights; NULL: unknown
  roundness DOUBLE,                      -- NULL here and below: not measured
  distinctness DOUBLE,
  persistence DOUBLE,
  relief_px DOUBLE);
CREATE INDEX patches_by_source ON patches(source_id);

-- The last outcome of seeking a patch in a photo: a photo oriented twice is one witness, not two.
CREATE TABLE attempts (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  patch_id INTEGER NOT NULL REFERENCES patches(id),
  photo TEXT NOT NULL,
  state TEXT NOT NULL,                   -- matched, not_found, rejected, not_visible
  ncc DOUBLE,
  residual_col_px DOUBLE,
  residual_row_px DOUBLE,
  reason TEXT NOT NULL,
  UNIQUE (patch_id, photo));

CREATE VIRTUAL TABLE rtree_patches_geom USING rtree(id, minx, maxx, miny, maxy);
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

INSERT INTO gpkg_extensions VALUES ('patches', 'geom', 'gpkg_rtree_index',
  'http://www.geopackage.org/spec120/#extension_rtree', 'write-only');
)sql";

}  // namespace

const SchemaStep kSchemaStep1 = {1, "patches, sources, attempts", kSql};

}  // namespace orient::patchdb

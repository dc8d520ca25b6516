// SQL statements of the patch database itself and of those that several files ask, named after
// their question; others stand in the file that asks them. The tables' own text is in
// patchdb/schema/.
#pragma once

namespace orient::sql {

inline constexpr const char* kHasSchemaTable =
    "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'orient_schema'";
inline constexpr const char* kSchemaVersion = "SELECT max(version) FROM orient_schema";
inline constexpr const char* kAddSchemaStep =
    "INSERT INTO orient_schema (version, description) VALUES (?1, ?2)";

inline constexpr const char* kAddCrs =
    "INSERT OR IGNORE INTO gpkg_spatial_ref_sys VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
inline constexpr const char* kRegisterPatches =
    "INSERT INTO gpkg_contents (table_name, data_type, identifier, description, srs_id) "
    "VALUES ('patches', 'features', 'patches', 'Control patches of known ground position', ?1)";
inline constexpr const char* kRegisterPatchGeometry =
    "INSERT INTO gpkg_geometry_columns VALUES ('patches', 'geom', 'POINT', ?1, 1, 0)";
inline constexpr const char* kRegisterAttributes =
    "INSERT INTO gpkg_contents (table_name, data_type, identifier, description) VALUES "
    "('sources', 'attributes', 'sources', 'What the patches were cut from'), "
    "('attempts', 'attributes', 'attempts', 'Patches sought in photos, and what came of it'), "
    "('orient_schema', 'attributes', 'orient_schema', 'Schema versions of the patch database')";

inline constexpr const char* kGroundCrs =
    "SELECT s.srs_id, s.definition FROM gpkg_geometry_columns AS g JOIN gpkg_spatial_ref_sys AS s "
    "ON s.srs_id = g.srs_id WHERE g.table_name = 'patches'";
inline constexpr const char* kCounts =
    "SELECT (SELECT count(*) FROM patches), (SELECT count(*) FROM sources WHERE harvested), "
    "(SELECT count(*) FROM attempts), (SELECT count(*) FROM patches WHERE state = 'retired')";
inline constexpr const char* kExtent =
    "SELECT min_x, min_y, max_x, max_y FROM gpkg_contents WHERE table_name = 'patches'";
// min() and max() with several arguments are NULL as soon as one of them is.
inline constexpr const char* kGrowExtent =
    "UPDATE gpkg_contents SET min_x = min(coalesce(min_x, ?1), ?1), "
    "min_y = min(coalesce(min_y, ?2), ?2), max_x = max(coalesce(max_x, ?3), ?3), "
    "max_y = max(coalesce(max_y, ?4), ?4), "
    "last_change = strftime('%Y-%m-%dT%H:%M:%fZ','now') WHERE table_name = 'patches'";

inline constexpr const char* kSourceNamed =
    "SELECT id, date, digest, harvested FROM sources WHERE kind = ?1 AND name = ?2";
#define ORIENT_SOURCE_VALUES \
  "kind, name, date, gsd_m, crs, provenance, licence, digest, harvested, added"
#define ORIENT_SOURCE_BINDINGS \
  "?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, strftime('%Y-%m-%dT%H:%M:%fZ','now')"
inline constexpr const char* kAddSource =
    "INSERT INTO sources (" ORIENT_SOURCE_VALUES ") VALUES (" ORIENT_SOURCE_BINDINGS ")";
inline constexpr const char* kChangeSource =
    "UPDATE sources SET (" ORIENT_SOURCE_VALUES ") = (" ORIENT_SOURCE_BINDINGS ") WHERE id = ?10";
#undef ORIENT_SOURCE_VALUES
#undef ORIENT_SOURCE_BINDINGS
inline constexpr const char* kSources =
    "SELECT id, kind, name, date, gsd_m, crs, provenance, licence, digest FROM sources ORDER BY id";

// The columns that a patch brings along, in the order of patch_rows.cpp; not what the database
// knows about it (state, epoch, history).
#define ORIENT_PATCH_VALUES                                                               \
  "geom, gsd_m, bits, bands, covariance, height_effect, height_sigma_m, roundness, "      \
  "distinctness, second_peak_px, persistence, relief_px, lean_px, energy_xx, energy_xy, " \
  "energy_yy, quality, heights_size, heights_step_m, heights_base_m, heights_quantum_m, " \
  "heights, chip_mask, chip"
inline constexpr const char* kAddPatch =
    "INSERT INTO patches (" ORIENT_PATCH_VALUES
    ", source_id, created) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, "
    "?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22, ?23, ?24, ?25, date('now'))";
inline constexpr const char* kChangePatch =
    "UPDATE patches SET (" ORIENT_PATCH_VALUES
    ") = (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, "
    "?20, ?21, ?22, ?23, ?24) WHERE id = ?25";
inline constexpr const char* kAddEvidence =
    "INSERT OR REPLACE INTO evidence (patch_id, source_id, col_px, row_px, residual_col_px, "
    "residual_row_px) VALUES (?1, ?2, ?3, ?4, ?5, ?6)";
inline constexpr const char* kCountViews =
    "UPDATE patches SET views = 1 + (SELECT count(*) FROM evidence WHERE patch_id = ?1 AND "
    "source_id <> patches.source_id) WHERE id = ?1";
inline constexpr const char* kEvidenceOf =
    "SELECT source_id, col_px, row_px, residual_col_px, residual_row_px FROM evidence "
    "WHERE patch_id = ?1 ORDER BY source_id";
#define ORIENT_PATCH_COLUMNS                                                         \
  ORIENT_PATCH_VALUES                                                                \
  ", p.id, source_id, state, retired_reason, superseded_by, epoch, created, views, " \
  "success_weight, failure_weight, retired_on FROM patches AS p "
inline constexpr const char* kCountPatchesIn =
    "SELECT count(*) FROM rtree_patches_geom WHERE maxx >= ?1 AND minx <= ?2 AND maxy >= ?3 AND "
    "miny <= ?4";
inline constexpr const char* kCountActivePatchesIn =
    "SELECT count(*) FROM rtree_patches_geom AS r JOIN patches AS p ON p.id = r.id WHERE r.maxx >= "
    "?1 AND r.minx <= ?2 AND r.maxy >= ?3 AND r.miny <= ?4 AND p.state = 'active'";
// Multiples of the golden section of 65536 fall evenly between 0 and 65535 for ids in sequence:
// below ?5 lies that share of the patches, taken from everywhere and in step with no grid.
inline constexpr const char* kPatchesIn =
    "SELECT " ORIENT_PATCH_COLUMNS
    "JOIN rtree_patches_geom AS r ON r.id = p.id WHERE r.maxx >= ?1 AND r.minx <= ?2 "
    "AND r.maxy >= ?3 AND r.miny <= ?4 AND (p.id * 40503) % 65536 < ?5 AND p.state = 'active' "
    "ORDER BY p.id";
inline constexpr const char* kPatchesAfter =
    "SELECT " ORIENT_PATCH_COLUMNS "WHERE p.id > ?1 ORDER BY p.id LIMIT ?2";
inline constexpr const char* kPatch = "SELECT " ORIENT_PATCH_COLUMNS "WHERE p.id = ?1";
#undef ORIENT_PATCH_COLUMNS
#undef ORIENT_PATCH_VALUES

inline constexpr const char* kRecordAttempt =
    "INSERT OR REPLACE INTO attempts (patch_id, photo, state, ncc, residual_col_px, "
    "residual_row_px, reason, photo_date, photo_status, predicted_col_px, predicted_row_px, "
    "found_col_px, found_row_px, photo_digest, neighbours_sought, neighbours_matched, recorded, "
    "epoch) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, "
    "strftime('%Y-%m-%dT%H:%M:%fZ','now'), "
    "coalesce((SELECT epoch FROM patches WHERE id = ?1), 1))";
// Recorded before the content of photos was.
inline constexpr const char* kForgetUnknownPhoto =
    "DELETE FROM attempts WHERE patch_id = ?1 AND photo = ?2 AND photo_digest = ''";

inline constexpr const char* kPlaceOf = "SELECT minx, miny FROM rtree_patches_geom WHERE id = ?1";
inline constexpr const char* kEpochOf = "SELECT epoch FROM patches WHERE id = ?1";
// One image is one photo, whatever its names: its last attempt counts.
inline constexpr const char* kAttemptsOf =
    "SELECT state, photo_status, photo_date, epoch, neighbours_sought, neighbours_matched "
    "FROM attempts AS a WHERE patch_id = ?1 AND (photo_digest = '' OR NOT EXISTS "
    "(SELECT 1 FROM attempts AS b WHERE b.patch_id = a.patch_id "
    "AND b.photo_digest = a.photo_digest AND b.id > a.id)) ORDER BY id";
inline constexpr const char* kSetWeights =
    "UPDATE patches SET success_weight = ?2, failure_weight = ?3 WHERE id = ?1 AND "
    "(success_weight <> ?2 OR failure_weight <> ?3)";
inline constexpr const char* kContentToken = "SELECT token FROM orient_content";
inline constexpr const char* kSetContentToken = "UPDATE orient_content SET token = ?1";
inline constexpr const char* kRetire =
    "UPDATE patches SET state = 'retired', retired_reason = ?2, retired_on = date('now') "
    "WHERE id = ?1 AND state = 'active'";

}  // namespace orient::sql

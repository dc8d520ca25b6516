#include "patchdb/store/selection.h"

#include "core/base/error.h"
#include "patchdb/store/connection.h"
#include "patchdb/store/geopackage_geometry.h"
#include "patchdb/store/patch_blobs.h"
#include "patchdb/store/row_values.h"

namespace orient::patchdb {
namespace {

// The PNG's header says how wide the chip is, so its pixels stay unread.
#define ORIENT_SUMMARY_COLUMNS                                                                 \
  "SELECT p.id, p.source_id, p.geom, p.covariance, p.gsd_m, substr(p.chip, 17, 4), p.bits, "   \
  "p.bands, p.state, p.retired_reason, p.superseded_by, p.epoch, p.views, p.created, s.date, " \
  "s.kind, s.name, p.roundness, p.distinctness, p.persistence, p.relief_px, p.lean_px, "       \
  "p.quality, p.success_weight, p.failure_weight FROM patches AS p JOIN sources AS s "         \
  "ON s.id = p.source_id "
#define ORIENT_SUMMARY_RULES                                                                    \
  "(?1 IS NULL OR p.state = ?1) AND (?2 IS NULL OR s.name = ?2) AND (?3 IS NULL OR "            \
  "p.quality < ?3) AND (?4 IS NULL OR p.failure_weight >= ?4) AND (?5 IS NULL OR s.date < ?5) " \
  "AND (?6 IS NULL OR p.retired_on < ?6) "
constexpr const char* kAll = ORIENT_SUMMARY_COLUMNS "WHERE " ORIENT_SUMMARY_RULES "ORDER BY p.id";
constexpr const char* kInside = ORIENT_SUMMARY_COLUMNS
    "JOIN rtree_patches_geom AS r ON r.id = p.id WHERE r.maxx >= ?7 AND r.minx <= ?8 AND "
    "r.maxy >= ?9 AND r.miny <= ?10 AND " ORIENT_SUMMARY_RULES "ORDER BY p.id";
constexpr const char* kOne = ORIENT_SUMMARY_COLUMNS "WHERE p.id = ?7 AND " ORIENT_SUMMARY_RULES;
#undef ORIENT_SUMMARY_COLUMNS
#undef ORIENT_SUMMARY_RULES

template <typename T>
void BindIf(SQLite::Statement& statement, int index, const std::optional<T>& value) {
  if (value) statement.bind(index, *value);
}

void BindRules(const PatchFilter& filter, SQLite::Statement& rows) {
  if (filter.life) rows.bind(1, Name(*filter.life));
  BindIf(rows, 2, filter.source);
  BindIf(rows, 3, filter.quality_below);
  BindIf(rows, 4, filter.min_failures);
  BindIf(rows, 5, filter.older_than);
  BindIf(rows, 6, filter.retired_before);
}

// A damaged position counts as unknown, so that the rest can be listed; 'check' reports it.
void ReadPlace(const SQLite::Statement& row, PatchSummary& patch) {
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const Bytes geometry = BytesOf(row.getColumn(2));
  patch.ground_m =
      DecodePointZ(geometry.data(), geometry.size()).value_or(Eigen::Vector3d::Constant(unknown));
  try {
    patch.sigma_m = DecodeCovariance(BytesOf(row.getColumn(3))).diagonal().cwiseMax(0).cwiseSqrt();
  } catch (const InputError&) {
    patch.sigma_m.setConstant(unknown);
  }
}

PatchSummary ReadSummary(const SQLite::Statement& row) {
  PatchSummary patch;
  patch.id = row.getColumn(0).getInt64();
  patch.source_id = row.getColumn(1).getInt64();
  ReadPlace(row, patch);
  patch.gsd_m = row.getColumn(4).getDouble();
  patch.chip_px = PngWidth(row.getColumn(5));
  patch.bits = row.getColumn(6).getInt();
  patch.bands = row.getColumn(7).getInt();
  patch.life = row.getColumn(8).getString() == "retired" ? PatchLife::kRetired : PatchLife::kActive;
  patch.retired_reason = row.getColumn(9).getString();
  patch.superseded_by = row.getColumn(10).getInt64();
  patch.epoch = row.getColumn(11).getInt();
  patch.views = row.getColumn(12).getInt();
  patch.created = TextOf(row.getColumn(13));
  patch.source_date = TextOf(row.getColumn(14));
  patch.source_kind = row.getColumn(15).getString();
  patch.source_name = row.getColumn(16).getString();
  patch.roundness = NumberOf(row.getColumn(17));
  patch.distinctness = NumberOf(row.getColumn(18));
  patch.persistence = NumberOf(row.getColumn(19));
  patch.relief_px = NumberOf(row.getColumn(20));
  patch.lean_px = NumberOf(row.getColumn(21));
  patch.quality = NumberOf(row.getColumn(22));
  patch.weights = {row.getColumn(23).getDouble(), row.getColumn(24).getDouble()};
  return patch;
}

Bounds BoundsOf(const std::vector<std::vector<Eigen::Vector2d>>& rings) {
  Bounds bounds = Bounds::OfNothing();
  for (const auto& ring : rings)
    for (const Eigen::Vector2d& point : ring) bounds.Include(point.x(), point.y());
  return bounds;
}

// The conditions that the SQL statements do not test.
bool Holds(const PatchFilter& filter, const PatchSummary& patch) {
  const Eigen::Vector2d place = patch.ground_m.head<2>();
  if (filter.bounds && !filter.bounds->Contains(place.x(), place.y())) return false;
  if (!filter.polygon.empty() && !InsideRings(filter.polygon, place)) return false;
  if (!filter.success_below) return true;
  // The belief in a patch never searched for follows from its quality, for which there is a rule of
  // its own.
  return patch.weights.success + patch.weights.failure > 0 &&
         patch.Belief().Mean() < *filter.success_below;
}

void VisitRows(SQLite::Statement& rows, const PatchFilter& filter,
               const std::function<void(const PatchSummary&)>& visit) {
  while (rows.executeStep()) {
    const PatchSummary patch = ReadSummary(rows);
    if (Holds(filter, patch)) visit(patch);
  }
}

}  // namespace

bool PatchFilter::HasRule() const {
  return bounds || !polygon.empty() || !ids.empty() || source || quality_below || success_below ||
         min_failures || older_than || retired_before;
}

bool InsideRings(const std::vector<std::vector<Eigen::Vector2d>>& rings,
                 const Eigen::Vector2d& point) {
  bool inside = false;
  for (const auto& ring : rings)
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      const Eigen::Vector2d &a = ring[i], &b = ring[j];
      if ((a.y() > point.y()) != (b.y() > point.y()) &&
          point.x() < a.x() + (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y()))
        inside = !inside;
    }
  return inside;
}

void VisitPatches(const PatchDatabase& database, const PatchFilter& filter,
                  const std::function<void(const PatchSummary&)>& visit) {
  Connection& connection = database.Sql();
  WithFile(database.Sql(), "choosing patches", [&] {
    if (!filter.ids.empty()) {
      for (const std::int64_t id : filter.ids) {
        SQLite::Statement row(connection.Database(), kOne);
        BindRules(filter, row);
        row.bind(7, id);
        VisitRows(row, filter, visit);
      }
      return;
    }
    std::optional<Bounds> bounds = filter.bounds;
    if (!bounds && !filter.polygon.empty()) bounds = BoundsOf(filter.polygon);
    // Not one of the connection's prepared statements: `visit` may run further queries.
    SQLite::Statement rows(connection.Database(), bounds ? kInside : kAll);
    BindRules(filter, rows);
    if (bounds) {
      rows.bind(7, bounds->min_x);
      rows.bind(8, bounds->max_x);
      rows.bind(9, bounds->min_y);
      rows.bind(10, bounds->max_y);
    }
    VisitRows(rows, filter, visit);
  });
}

std::vector<std::int64_t> ChooseIds(const PatchDatabase& database, const PatchFilter& filter) {
  std::vector<std::int64_t> ids;
  VisitPatches(database, filter, [&](const PatchSummary& patch) { ids.push_back(patch.id); });
  return ids;
}

}  // namespace orient::patchdb

#include "patchdb/maintenance/statistics.h"

#include "core/base/error.h"
#include "patchdb/store/connection.h"

namespace orient::patchdb {
namespace {

constexpr const char* kSources =
    "SELECT kind, name, coalesce(date, ''), (SELECT count(*) FROM patches WHERE source_id = "
    "sources.id), (SELECT count(*) FROM patches WHERE source_id = sources.id AND state = "
    "'retired') FROM sources ORDER BY sources.id";
#define ORIENT_TRIED \
  "a.state IN ('matched', 'not_found', 'rejected') AND a.photo_status IS NOT 'failed' "
constexpr const char* kByAge =
    "SELECT (abs(CAST(substr(a.photo_date, 1, 4) AS INTEGER) - CAST(substr(s.date, 1, 4) AS "
    "INTEGER)) / 10) * 10 AS decade, count(*), sum(a.state = 'matched') FROM attempts AS a "
    "JOIN patches AS p ON p.id = a.patch_id JOIN sources AS s ON s.id = p.source_id "
    "WHERE " ORIENT_TRIED
    "AND a.photo_date GLOB '[0-9][0-9][0-9][0-9]*' AND s.date GLOB '[0-9][0-9][0-9][0-9]*' "
    "GROUP BY decade ORDER BY decade";
constexpr const char* kByMonth =
    "SELECT substr(a.photo_date, 6, 2) AS month, count(*), sum(a.state = 'matched') FROM attempts "
    "AS a WHERE " ORIENT_TRIED
    "AND a.photo_date GLOB '[0-9][0-9][0-9][0-9]-[0-9][0-9]*' GROUP BY month ORDER BY month";
#undef ORIENT_TRIED
constexpr const char* kReasons =
    "SELECT coalesce(retired_reason, ''), count(*) FROM patches WHERE state = 'retired' GROUP BY "
    "retired_reason ORDER BY count(*) DESC LIMIT 20";
constexpr const char* kExtent =
    "SELECT min(minx), max(maxx), min(miny), max(maxy) FROM rtree_patches_geom";
constexpr const char* kActivePlaces =
    "SELECT minx, maxx, miny, maxy FROM rtree_patches_geom WHERE id NOT IN (SELECT id FROM patches "
    "WHERE state = 'retired')";

std::vector<SuccessCount> Groups(Connection& connection, const char* sql, const char* suffix) {
  std::vector<SuccessCount> groups;
  const Query rows = connection.Prepare(sql);
  while (rows->executeStep()) {
    SuccessCount group{rows->getColumn(0).getString() + suffix, rows->getColumn(1).getInt64(), 0};
    if (rows->getColumnCount() > 2) group.matched = rows->getColumn(2).getInt64();
    groups.push_back(group);
  }
  return groups;
}

DensityGrid EmptyGrid(const Bounds& bounds, double cell_m, const std::string& path) {
  constexpr double kMaxCells = 1e8;
  DensityGrid grid;
  grid.cell_m = cell_m;
  grid.west_m = std::floor(bounds.min_x / cell_m) * cell_m;
  grid.north_m = std::ceil(bounds.max_y / cell_m) * cell_m;
  const double width = std::floor((bounds.max_x - grid.west_m) / cell_m) + 1;
  const double height = std::floor((grid.north_m - bounds.min_y) / cell_m) + 1;
  if (!(width * height <= kMaxCells))
    throw InputError(path +
                     ": the density map would have more than 100 million cells; give a "
                     "larger cell");
  grid.width = static_cast<int>(width);
  grid.height = static_cast<int>(height);
  grid.counts.resize(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  return grid;
}

}  // namespace

PatchStatistics CountEverything(const PatchDatabase& database) {
  return WithFile(database.Sql(), "counting", [&] {
    Connection& connection = database.Sql();
    PatchStatistics statistics;
    const Query sources = connection.Prepare(kSources);
    while (sources->executeStep())
      statistics.sources.push_back(
          {sources->getColumn(0).getString(), sources->getColumn(1).getString(),
           sources->getColumn(2).getString(), sources->getColumn(3).getInt64(),
           sources->getColumn(4).getInt64()});
    statistics.by_age = Groups(connection, kByAge, " years");
    statistics.by_season = Groups(connection, kByMonth, "");
    statistics.retired = Groups(connection, kReasons, "");
    return statistics;
  });
}

DensityGrid CountDensity(const PatchDatabase& database, double cell_m) {
  return WithFile(database.Sql(), "counting", [&]() -> DensityGrid {
    Connection& connection = database.Sql();
    const Query extent = connection.Prepare(kExtent);
    if (!extent->executeStep() || extent->getColumn(0).isNull()) return {};
    const Bounds bounds{extent->getColumn(0).getDouble(), extent->getColumn(2).getDouble(),
                        extent->getColumn(1).getDouble(), extent->getColumn(3).getDouble()};
    DensityGrid grid = EmptyGrid(bounds, cell_m, database.Path());
    const Query rows = connection.Prepare(kActivePlaces);
    while (rows->executeStep()) {
      const double x = 0.5 * (rows->getColumn(0).getDouble() + rows->getColumn(1).getDouble());
      const double y = 0.5 * (rows->getColumn(2).getDouble() + rows->getColumn(3).getDouble());
      const int col = std::clamp(static_cast<int>((x - grid.west_m) / cell_m), 0, grid.width - 1);
      const int row = std::clamp(static_cast<int>((grid.north_m - y) / cell_m), 0, grid.height - 1);
      ++grid.counts[static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.width) +
                    static_cast<std::size_t>(col)];
    }
    return grid;
  });
}

}  // namespace orient::patchdb

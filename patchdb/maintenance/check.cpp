#include "patchdb/maintenance/check.h"

#include <fmt/format.h>

#include <unordered_map>

#include "core/base/error.h"
#include "patchdb/maintenance/schema_check.h"
#include "patchdb/store/connection.h"
#include "patchdb/store/learn.h"
#include "patchdb/store/learning.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {
namespace {

// What can be checked and repaired in SQL. The order matters: references before counts that depend
// on them.
struct Rule {
  const char* what;
  const char* count;
  const char* repair_text;
  const char* repair;
};
constexpr Rule kRules[] = {
    {"patches whose source is missing",
     "SELECT count(*) FROM patches WHERE source_id NOT IN (SELECT id FROM sources)",
     "a source named 'lost <number>' is added",
     "INSERT INTO sources (id, kind, name, gsd_m) SELECT DISTINCT source_id, 'photo', 'lost ' || "
     "source_id, coalesce(min(gsd_m), 0) FROM patches WHERE source_id NOT IN (SELECT id FROM "
     "sources) GROUP BY source_id"},
    {"attempts whose patch is missing",
     "SELECT count(*) FROM attempts WHERE patch_id NOT IN (SELECT id FROM patches)",
     "they are deleted", "DELETE FROM attempts WHERE patch_id NOT IN (SELECT id FROM patches)"},
    {"evidence whose patch or source is missing",
     "SELECT count(*) FROM evidence WHERE patch_id NOT IN (SELECT id FROM patches) OR source_id "
     "NOT "
     "IN (SELECT id FROM sources)",
     "it is deleted",
     "DELETE FROM evidence WHERE patch_id NOT IN (SELECT id FROM patches) OR source_id NOT IN "
     "(SELECT id FROM sources)"},
    {"successors that are missing, or of active patches",
     "SELECT count(*) FROM patches WHERE superseded_by IS NOT NULL AND (superseded_by NOT IN "
     "(SELECT id FROM patches) OR state = 'active' OR superseded_by = id)",
     "they are cleared",
     "UPDATE patches SET superseded_by = NULL WHERE superseded_by IS NOT NULL AND (superseded_by "
     "NOT IN (SELECT id FROM patches) OR state = 'active' OR superseded_by = id)"},
    {"retired patches without a reason",
     "SELECT count(*) FROM patches WHERE state = 'retired' AND retired_reason IS NULL",
     "the reason is 'unknown'",
     "UPDATE patches SET retired_reason = 'unknown' WHERE state = 'retired' AND retired_reason IS "
     "NULL"},
    {"patches whose count of views is wrong",
     "SELECT count(*) FROM patches AS p WHERE views <> 1 + (SELECT count(*) FROM evidence AS e "
     "WHERE e.patch_id = p.id AND e.source_id <> p.source_id)",
     "they are recounted",
     "UPDATE patches SET views = 1 + (SELECT count(*) FROM evidence AS e WHERE e.patch_id = "
     "patches.id AND e.source_id <> patches.source_id)"},
    {"patches that the spatial index lacks or puts elsewhere",
     "SELECT count(*) FROM patches AS p LEFT JOIN rtree_patches_geom AS r ON r.id = p.id WHERE "
     "ST_MinX(p.geom) IS NOT NULL AND NOT ST_IsEmpty(p.geom) AND (r.id IS NULL OR NOT (r.minx <= "
     "ST_MinX(p.geom) AND r.maxx >= ST_MinX(p.geom) AND r.miny <= ST_MinY(p.geom) AND r.maxy >= "
     "ST_MinY(p.geom)))",
     "the index is rebuilt", nullptr},
    {"entries of the spatial index without a patch",
     "SELECT count(*) FROM rtree_patches_geom WHERE id NOT IN (SELECT id FROM patches)",
     "the index is rebuilt", nullptr},
    {"patches outside the extent that the file states",
     "SELECT count(*) FROM rtree_patches_geom AS r, gpkg_contents AS c WHERE c.table_name = "
     "'patches' AND (c.min_x IS NULL OR r.maxx < c.min_x OR r.minx > c.max_x OR r.maxy < c.min_y "
     "OR "
     "r.miny > c.max_y)",
     "the extent is recomputed",
     "UPDATE gpkg_contents SET (min_x, min_y, max_x, max_y) = (SELECT min(minx), min(miny), "
     "max(maxx), max(maxy) FROM rtree_patches_geom) WHERE table_name = 'patches'"},
};
constexpr const char* kForgetIndex = "DELETE FROM rtree_patches_geom";
constexpr const char* kMakeIndex =
    "INSERT INTO rtree_patches_geom SELECT id, ST_MinX(geom), ST_MaxX(geom), ST_MinY(geom), "
    "ST_MaxY(geom) FROM patches WHERE ST_MinX(geom) IS NOT NULL AND NOT ST_IsEmpty(geom)";
constexpr const char* kSuccessors =
    "SELECT id, superseded_by FROM patches WHERE superseded_by IS NOT NULL";
constexpr const char* kForgetSuccessor = "UPDATE patches SET superseded_by = NULL WHERE id = ?1";
constexpr const char* kWeights =
    "SELECT id, success_weight, failure_weight FROM patches WHERE success_weight <> 0 OR "
    "failure_weight <> 0 OR id IN (SELECT patch_id FROM attempts)";
constexpr const char* kIds =
    "SELECT id, state, coalesce(retired_reason, '') FROM patches WHERE id > ?1 ORDER BY id LIMIT "
    "500";
constexpr const char* kRetireDamaged =
    "UPDATE patches SET state = 'retired', retired_reason = ?2, retired_on = date('now') "
    "WHERE id = ?1";

constexpr const char* kDamaged = "damaged: ";

// The patches in a circle, not those leading into one. Every chain is followed once: to its end, or
// to a patch visited before; if that was in the same walk, it lies in a circle.
std::vector<std::int64_t> InCircles(
    const std::unordered_map<std::int64_t, std::int64_t>& successors) {
  std::unordered_map<std::int64_t, std::int64_t> walk_of;  // the patch it began with
  std::vector<std::int64_t> circles;
  for (const auto& [start, next] : successors) {
    std::int64_t here = start;
    while (successors.contains(here) && walk_of.emplace(here, start).second)
      here = successors.at(here);
    const auto met = walk_of.find(here);
    if (met == walk_of.end() || met->second != start) continue;
    for (std::int64_t id = here;;) {
      circles.push_back(id);
      id = successors.at(id);
      if (id == here) break;
    }
  }
  return circles;
}

class Check {
 public:
  Check(PatchDatabase& database, const CheckOptions& options)
      : database_(database), connection_(database.Sql()), options_(options) {}

  std::vector<CheckFinding> Run(const std::function<void(std::int64_t, std::int64_t)>& progress) {
    if (!Schema()) return findings_;
    Integrity();
    for (const Rule& rule : kRules) Apply(rule);
    Index();
    Loops();
    if (options_.chips) Chips(progress);
    Weights();
    return findings_;
  }

 private:
  void Find(const std::string& what, std::int64_t count, const std::string& repair) {
    if (count > 0) findings_.push_back({what, count, repair});
  }

  // False if missing objects prevent the remaining checks.
  bool Schema() {
    const int version = static_cast<int>(connection_.Number(sql::kSchemaVersion));
    const std::vector<SchemaObject> missing = MissingObjects(connection_, version);
    for (const SchemaObject& object : ForeignObjects(connection_, version))
      Find(fmt::format("the {} {} is none of a patch database's and is not run", object.type,
                       object.name),
           1, "");
    for (const SchemaObject& object : missing)
      Find(fmt::format("no {} {} as the schema requires", object.type, object.name), 1,
           IsBeyondRepair(object)   ? ""
           : object.type == "table" ? "it is created, empty"
                                    : "it is created");
    if (std::any_of(missing.begin(), missing.end(), IsBeyondRepair)) return false;
    if (options_.repair) MakeObjects(connection_, missing);
    if (!options_.repair && HasTable(missing)) return false;
    if (!LacksToken(connection_, version)) return true;
    Find("no content token", 1, "it is created");
    if (options_.repair) RenewToken(connection_);
    return true;
  }

  void Integrity() {
    for (const char* pragma :
         {"PRAGMA integrity_check(20)", "SELECT rtreecheck('rtree_patches_geom')"}) {
      SQLite::Statement rows(connection_.Database(), pragma);
      while (rows.executeStep()) {
        const std::string text = rows.getColumn(0).getString();
        if (text == "ok") continue;
        const bool index = std::string(pragma).starts_with("SELECT");
        Find("the file: " + text, 1, index ? "the index is rebuilt" : "");
        remake_index_ = remake_index_ || index;
      }
    }
    if (connection_.DeviceFailed()) throw SQLite::Exception("disk I/O error", SQLITE_IOERR);
  }

  void Apply(const Rule& rule) {
    const std::int64_t count = connection_.Number(rule.count);
    Find(rule.what, count, rule.repair_text);
    if (count == 0) return;
    if (rule.repair == nullptr) remake_index_ = true;
    if (!options_.repair) return;
    if (rule.repair == nullptr)
      Index();
    else
      connection_.Database().exec(rule.repair);
  }

  void Index() {
    if (!options_.repair || !remake_index_) return;
    connection_.Database().exec(kForgetIndex);
    connection_.Database().exec(kMakeIndex);
    remake_index_ = false;
  }

  void Loops() {
    std::unordered_map<std::int64_t, std::int64_t> successors;
    {
      const Query rows = connection_.Prepare(kSuccessors);
      while (rows->executeStep())
        successors[rows->getColumn(0).getInt64()] = rows->getColumn(1).getInt64();
    }
    const std::vector<std::int64_t> loops = InCircles(successors);
    Find("patches that supersede one another in a circle", static_cast<std::int64_t>(loops.size()),
         "the successors are cleared");
    if (!options_.repair) return;
    for (const std::int64_t id : loops) {
      const Query forget = connection_.Prepare(kForgetSuccessor);
      forget->bind(1, id);
      forget->exec();
    }
  }

  // Skips patches that an earlier repair retired as damaged: they are known, and out of use.
  void Chips(const std::function<void(std::int64_t, std::int64_t)>& progress) {
    struct Row {
      std::int64_t id;
      bool known;
    };
    const std::int64_t total = connection_.Number("SELECT count(*) FROM patches");
    std::int64_t last = std::numeric_limits<std::int64_t>::min(), done = 0;
    for (;;) {
      std::vector<Row> page;
      {
        const Query rows = connection_.Prepare(kIds);
        rows->bind(1, last);
        while (rows->executeStep())
          page.push_back({rows->getColumn(0).getInt64(),
                          rows->getColumn(1).getString() == "retired" &&
                              rows->getColumn(2).getString().starts_with(kDamaged)});
      }
      if (page.empty()) return;
      for (const Row& row : page)
        if (!row.known) Chip(row.id);
      last = page.back().id;
      done += static_cast<std::int64_t>(page.size());
      if (progress) progress(done, total);
    }
  }

  void Chip(std::int64_t id) {
    try {
      database_.ReadPatch(id);
    } catch (const InputError& error) {
      Find(error.what(), 1, "it is retired");
      if (!options_.repair) return;
      const Query retire = connection_.Prepare(kRetireDamaged);
      retire->bind(1, id);
      retire->bind(2, std::string(kDamaged) + error.what());
      retire->exec();
    }
  }

  void Weights() {
    std::vector<std::int64_t> wrong;
    {
      SQLite::Statement rows(connection_.Database(), kWeights);
      while (rows.executeStep()) {
        const std::int64_t id = rows.getColumn(0).getInt64();
        const SuccessWeights weights = WeightsOf(connection_, id);
        const double off = std::abs(weights.success - rows.getColumn(1).getDouble()) +
                           std::abs(weights.failure - rows.getColumn(2).getDouble());
        if (!(off < 1e-6)) wrong.push_back(id);
      }
    }
    Find("patches whose weights are not those of their attempts",
         static_cast<std::int64_t>(wrong.size()), "they are recomputed");
    if (!options_.repair) return;
    for (const std::int64_t id : wrong) LearnAnew(connection_, id, false);
  }

  PatchDatabase& database_;
  Connection& connection_;
  const CheckOptions& options_;
  std::vector<CheckFinding> findings_;
  bool remake_index_ = false;
};

}  // namespace

std::vector<CheckFinding> CheckDatabase(
    PatchDatabase& database, const CheckOptions& options,
    const std::function<void(std::int64_t, std::int64_t)>& progress) {
  std::vector<CheckFinding> findings;
  if (!options.repair)
    return WithFile(database.Sql(), "checking",
                    [&] { return Check(database, options).Run(progress); });
  database.Write("repairing", [&](Connection& connection) {
    // During a repair, rows have broken references until it is complete.
    connection.Database().exec("PRAGMA defer_foreign_keys = ON");
    findings = Check(database, options).Run(progress);
    return 0;
  });
  return findings;
}

}  // namespace orient::patchdb

// Reads the four files of manual measurements and decisions.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/base/table_text.h"
#include "core/geometry/sigma.h"
#include "core/measurements/measurements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string PathIn(const std::string& folder, const char* file) {
  return (fs::path(folder) / file).string();
}

Attribution AttributionIn(const NamedTable& table) {
  return {table.Text("by"), table.Text("when")};
}

double SigmaIn(const NamedTable& table, const std::string& column) {
  const double sigma = table.Number(column);
  if (const std::string why = SigmaProblem(sigma); !why.empty())
    table.Fail(column, fmt::format("{} is {}; {}", column, table.Text(column), why));
  return sigma;
}

// The keys read so far, so that none occurs twice.
class UniqueKeys {
 public:
  // Throws InputError at this cell if the key has occurred before.
  void Add(const NamedTable& table, const std::string& column, const std::string& key,
           const std::string& what) {
    if (!keys_.insert(key).second)
      table.Fail(column, what + " a second time; keep one of the lines");
  }

 private:
  std::set<std::string> keys_;
};

std::vector<MarkMeasurement> ReadMarks(const std::string& path) {
  NamedTable table(path, {"photo", "mark", "col", "row", "sigma"}, {"exact", "by", "when"});
  std::vector<MarkMeasurement> marks;
  UniqueKeys once;
  while (table.Next()) {
    MarkMeasurement mark;
    mark.photo = WithoutImageEnding(table.Name("photo"));
    mark.mark = table.Name("mark");
    once.Add(table, "mark", mark.photo + "\n" + mark.mark,
             fmt::format("mark {} of photo {} is measured", mark.mark, mark.photo));
    mark.pixel = {table.Number("col"), table.Number("row")};
    mark.sigma_px = SigmaIn(table, "sigma");
    const std::string exact = table.Text("exact");
    if (!exact.empty() && exact != "yes" && exact != "no")
      table.Fail("exact", fmt::format("exact is \"{}\"; it must be yes or no", exact));
    mark.exact = exact == "yes";
    mark.attribution = AttributionIn(table);
    marks.push_back(std::move(mark));
  }
  return marks;
}

std::vector<ImagePointMeasurement> ReadImagePoints(const std::string& path) {
  NamedTable table(path, {"photo", "point", "sigma"}, {"col", "row", "x_mm", "y_mm", "by", "when"});
  const bool in_pixels = table.Has("col") && table.Has("row");
  if (in_pixels == (table.Has("x_mm") && table.Has("y_mm")) ||
      table.Has("col") != table.Has("row") || table.Has("x_mm") != table.Has("y_mm"))
    throw InputError(path +
                     ", line 1: give either the columns col,row (pixels of the scan) or x_mm,y_mm "
                     "(photo system)");
  std::vector<ImagePointMeasurement> points;
  UniqueKeys once;
  while (table.Next()) {
    ImagePointMeasurement seen;
    seen.photo = WithoutImageEnding(table.Name("photo"));
    seen.point = table.Name("point");
    once.Add(table, "point", seen.photo + "\n" + seen.point,
             fmt::format("point {} of photo {} is measured", seen.point, seen.photo));
    if (in_pixels)
      seen.pixel = {table.Number("col"), table.Number("row")};
    else
      seen.photo_mm = {table.Number("x_mm"), table.Number("y_mm")};
    seen.sigma = SigmaIn(table, "sigma");
    seen.attribution = AttributionIn(table);
    points.push_back(std::move(seen));
  }
  return points;
}

std::vector<GroundPoint> ReadPoints(const std::string& path) {
  NamedTable table(path, {"point", "x", "y", "z", "sigma_x", "sigma_y", "sigma_z", "role"},
                   {"by", "when"});
  std::vector<GroundPoint> points;
  UniqueKeys once;
  while (table.Next()) {
    GroundPoint point;
    point.name = table.Name("point");
    once.Add(table, "point", point.name, fmt::format("point {} is given", point.name));
    point.ground_m = {table.Number("x"), table.Number("y"), table.Number("z")};
    point.sigma_m = {SigmaIn(table, "sigma_x"), SigmaIn(table, "sigma_y"),
                     SigmaIn(table, "sigma_z")};
    const std::string role = table.Text("role");
    if (role != "control" && role != "check")
      table.Fail("role", fmt::format("role is \"{}\"; it must be control or check", role));
    point.role = role == "check" ? PointRole::kCheck : PointRole::kControl;
    point.attribution = AttributionIn(table);
    points.push_back(std::move(point));
  }
  return points;
}

DecisionKind KindIn(const NamedTable& table) {
  const std::string name = table.Text("decision");
  if (const auto kind = DecisionKindFromName(name)) return *kind;
  table.Fail("decision", fmt::format("the decision is \"{}\"; it must be accept, reject, "
                                     "orientation, polarity, camera, pixel_size or position",
                                     name));
}

std::vector<Decision> ReadDecisions(const std::string& path) {
  NamedTable table(path, {"photo", "decision", "value", "reason"}, {"by", "when"});
  std::vector<Decision> decisions;
  UniqueKeys once;
  while (table.Next()) {
    Decision decision;
    decision.photo = WithoutImageEnding(table.Name("photo"));
    decision.kind = KindIn(table);
    decision.value = table.Text("value");
    decision.reason = table.Text("reason");
    decision.attribution = AttributionIn(table);
    if (const std::string why = DecisionProblem(decision.kind, decision.value); !why.empty())
      table.Fail("value", fmt::format("the value \"{}\" {}", decision.value, why));
    const bool verdict =
        decision.kind == DecisionKind::kAccept || decision.kind == DecisionKind::kReject;
    once.Add(table, "decision",
             decision.photo + "\n" + (verdict ? "verdict" : std::string(Name(decision.kind))),
             fmt::format("{} is decided on photo {}",
                         verdict ? "accept or reject" : std::string(Name(decision.kind)),
                         decision.photo));
    decisions.push_back(std::move(decision));
  }
  return decisions;
}

}  // namespace

Measurements ReadMeasurements(const std::string& folder) {
  const std::array files = {kMarksFile, kImagePointsFile, kPointsFile, kDecisionsFile};
  std::error_code ignored;
  const auto there = [&](const char* file) { return fs::exists(PathIn(folder, file), ignored); };
  if (std::none_of(files.begin(), files.end(), there))
    throw InputError(fmt::format("{} holds none of the files {}", folder, fmt::join(files, ", ")));
  Measurements all;
  all.folder = folder;
  if (there(kMarksFile)) all.marks = ReadMarks(PathIn(folder, kMarksFile));
  if (there(kImagePointsFile)) all.image_points = ReadImagePoints(PathIn(folder, kImagePointsFile));
  if (there(kPointsFile)) all.points = ReadPoints(PathIn(folder, kPointsFile));
  if (there(kDecisionsFile)) all.decisions = ReadDecisions(PathIn(folder, kDecisionsFile));
  return all;
}

}  // namespace orient

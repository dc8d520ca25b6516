#include "core/measurements/written_measurements.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "core/base/atomic_write.h"
#include "core/base/csv_cell.h"
#include "core/base/new_file.h"
#include "core/base/trimmed.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string PathIn(const std::string& folder, const char* file) {
  return (fs::path(folder) / file).string();
}

// For pixels, millimetres and metres: finer than any measurement.
std::string Text(double value) { return fmt::format("{:.12g}", value); }

// Quoted if it would otherwise be read as a comment, or trimmed.
std::string Cell(const std::string& text) {
  const std::string cell = CsvCell(text);
  const bool bare = !cell.starts_with('"');
  const bool quotes = text.starts_with('#') || Trimmed(text) != text;
  return bare && quotes ? "\"" + cell + "\"" : cell;
}

std::string Ending(const Attribution& attribution) {
  return "," + Cell(attribution.by) + "," + Cell(attribution.when) + "\n";
}

std::string MarksTable(const std::vector<MarkMeasurement>& marks) {
  std::string text = "photo,mark,col,row,sigma,exact,by,when\n";
  for (const MarkMeasurement& mark : marks)
    text += fmt::format("{},{},{},{},{},{}{}", Cell(mark.photo), Cell(mark.mark),
                        Text(mark.pixel.x()), Text(mark.pixel.y()), Text(mark.sigma_px),
                        mark.exact ? "yes" : "no", Ending(mark.attribution));
  return text;
}

std::string ImagePointsTable(const std::vector<ImagePointMeasurement>& points) {
  const bool in_mm = !points.empty() && points.front().photo_mm;
  std::string text =
      in_mm ? "photo,point,x_mm,y_mm,sigma,by,when\n" : "photo,point,col,row,sigma,by,when\n";
  for (const ImagePointMeasurement& seen : points) {
    const auto& at = in_mm ? seen.photo_mm : seen.pixel;
    if (!at) throw std::invalid_argument("measurements: pixels and millimetres in one table");
    text += fmt::format("{},{},{},{},{}{}", Cell(seen.photo), Cell(seen.point), Text(at->x()),
                        Text(at->y()), Text(seen.sigma), Ending(seen.attribution));
  }
  return text;
}

std::string PointsTable(const std::vector<GroundPoint>& points) {
  std::string text = "point,x,y,z,sigma_x,sigma_y,sigma_z,role,by,when\n";
  for (const GroundPoint& point : points)
    text += fmt::format("{},{},{},{},{},{},{},{}{}", Cell(point.name), Text(point.ground_m.x()),
                        Text(point.ground_m.y()), Text(point.ground_m.z()), Text(point.sigma_m.x()),
                        Text(point.sigma_m.y()), Text(point.sigma_m.z()),
                        point.role == PointRole::kCheck ? "check" : "control",
                        Ending(point.attribution));
  return text;
}

std::string DecisionsTable(const std::vector<Decision>& decisions) {
  std::string text = "photo,decision,value,reason,by,when\n";
  for (const Decision& one : decisions)
    text += fmt::format("{},{},{},{}{}", Cell(one.photo), Name(one.kind), Cell(one.value),
                        Cell(one.reason), Ending(one.attribution));
  return text;
}

// The previous contents of a file; empty if there was none.
std::optional<std::string> ContentsBefore(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  return ReadFile(path);
}

// Restores the files replaced so far, unless all of them have been replaced.
class PutBack {
 public:
  void Add(const std::string& path, std::optional<std::string> contents) {
    before_.emplace_back(path, std::move(contents));
  }
  void Release() { before_.clear(); }
  ~PutBack() {
    for (const auto& [path, contents] : before_) Restore(path, contents);
  }

 private:
  static void Restore(const std::string& path, const std::optional<std::string>& contents) {
    std::error_code ignored;
    try {
      if (contents)
        WriteFileAtomically(path, *contents);
      else
        fs::remove(path, ignored);
    } catch (const std::exception&) {  // the error that led here is the one to report
    }
  }

  std::vector<std::pair<std::string, std::optional<std::string>>> before_;
};

// All are written before the first one gets its final name.
void WriteTogether(const std::vector<std::pair<std::string, std::string>>& files) {
  std::vector<std::unique_ptr<NewFile>> made;
  for (const auto& [path, text] : files) {
    made.push_back(std::make_unique<NewFile>(path));
    made.back()->Write(text);
  }
  PutBack put_back;
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::optional<std::string> before = ContentsBefore(files[i].first);
    made[i]->Keep();
    put_back.Add(files[i].first, std::move(before));
  }
  put_back.Release();
}

}  // namespace

void WriteMarks(const std::string& folder, const std::vector<MarkMeasurement>& marks) {
  WriteFileAtomically(PathIn(folder, kMarksFile), MarksTable(marks));
}

void WriteImagePoints(const std::string& folder, const std::vector<ImagePointMeasurement>& points) {
  WriteFileAtomically(PathIn(folder, kImagePointsFile), ImagePointsTable(points));
}

void WritePoints(const std::string& folder, const std::vector<GroundPoint>& points) {
  WriteFileAtomically(PathIn(folder, kPointsFile), PointsTable(points));
}

void WriteDecisions(const std::string& folder, const std::vector<Decision>& decisions) {
  WriteFileAtomically(PathIn(folder, kDecisionsFile), DecisionsTable(decisions));
}

std::vector<std::string> FilesOf(const Measurements& measurements) {
  std::vector<std::string> files;
  if (!measurements.marks.empty()) files.emplace_back(kMarksFile);
  if (!measurements.image_points.empty()) files.emplace_back(kImagePointsFile);
  if (!measurements.points.empty()) files.emplace_back(kPointsFile);
  if (!measurements.decisions.empty()) files.emplace_back(kDecisionsFile);
  return files;
}

void WriteMeasurements(const std::string& folder, const Measurements& measurements) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const std::string& file : FilesOf(measurements)) {
    const std::string text = file == kMarksFile ? MarksTable(measurements.marks)
                             : file == kImagePointsFile
                                 ? ImagePointsTable(measurements.image_points)
                             : file == kPointsFile ? PointsTable(measurements.points)
                                                   : DecisionsTable(measurements.decisions);
    files.emplace_back(PathIn(folder, file.c_str()), text);
  }
  WriteTogether(files);
}

}  // namespace orient

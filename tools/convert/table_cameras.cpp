#include "tools/convert/table_cameras.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <vector>

#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/base/table_text.h"
#include "core/base/trimmed.h"

namespace orient {
namespace {

// Of a header split at the text's delimiter; empty where this is none, or has no such column.
std::optional<std::size_t> CameraColumn(const TableText& text, const std::string& line) {
  std::vector<std::string> names;
  for (const TableCell& cell : text.Split(line)) names.push_back(cell.text);
  std::optional<std::size_t> twice;
  const auto places = ColumnPlaces(names, &twice);
  if (!places.contains("filename") || !places.contains("x") || !places.contains("camera"))
    return std::nullopt;
  return places.at("camera");
}

// Reads up to the header, which may be a comment.
std::optional<std::size_t> FindCameraColumn(TableText* text) {
  std::string line;
  while (text->NextText(&line)) {
    const bool comment = TableText::IsComment(line);
    if (comment && line.find('"') != std::string::npos) continue;  // which may close nowhere
    if (comment) line[line.find('#')] = ' ';
    for (const char delimiter : {',', ';', '\t'}) {
      text->SetDelimiter(delimiter);
      if (const auto column = CameraColumn(*text, line)) return column;
    }
    if (!comment) break;
  }
  return std::nullopt;
}

}  // namespace

std::set<std::string> CamerasNamed(const std::string& table) {
  TableText text(table);
  std::set<std::string> cameras;
  const auto column = FindCameraColumn(&text);
  if (!column) return cameras;
  std::vector<TableCell> cells;
  while (text.NextLine(&cells)) {
    if (*column >= cells.size()) continue;
    const std::string name(Trimmed(cells[*column].text));
    if (!name.empty()) cameras.insert(name);
  }
  return cameras;
}

void RequireOneCamera(const std::string& table) {
  const std::set<std::string> cameras = CamerasNamed(table);
  if (cameras.size() < 2) return;
  throw InputError(fmt::format(
      "{} names {} cameras in its column camera ({}), but its photos are converted with "
      "one; make a table of each camera's photos and convert them one by one",
      table, cameras.size(), fmt::join(cameras, ", ")));
}

}  // namespace orient

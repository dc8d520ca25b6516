#include "core/files/orientation_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/column_names.h"
#include "core/base/csv_cell.h"
#include "core/base/date.h"
#include "core/base/remote_files.h"
#include "core/base/table_text.h"
#include "core/base/trimmed.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr std::array<const char*, 7> kColumns = {"filename", "x",   "y",    "z",
                                                 "omega",    "phi", "kappa"};
constexpr std::array<const char*, 6> kSigmaColumns = {"sigma_x",     "sigma_y",   "sigma_z",
                                                      "sigma_omega", "sigma_phi", "sigma_kappa"};
constexpr int kLargestSigma = 1000000;  // metres, degrees
constexpr const char* kDateColumn = "date";
constexpr const char* kHeader = "filename,x,y,z,omega,phi,kappa";

// Where each known column stands in this table.
struct Columns {
  std::map<std::string, size_t> index;
  size_t count = 0;
  bool has_angles = true;
  size_t sigmas = 0;  // 6, or 3: of positions alone
};

// Only all three angles together may be absent.
void RequireColumns(const TableText& text, Attitudes attitudes, Columns* columns) {
  const auto known = [&](const char* name) { return columns->index.contains(name); };
  const auto angles = kColumns.begin() + 4;
  columns->has_angles =
      attitudes == Attitudes::kRequired || std::any_of(angles, kColumns.end(), known);
  const auto end = columns->has_angles ? kColumns.end() : angles;
  const auto missing = std::find_if_not(kColumns.begin(), end, known);
  if (missing != end)
    text.Fail(std::string("the header has no column \"") + *missing + "\"; it is " + kHeader);
}

std::vector<std::string> TextsOf(const std::vector<TableCell>& cells) {
  std::vector<std::string> texts;
  for (const TableCell& cell : cells) texts.push_back(cell.text);
  return texts;
}

// Whether these are at least a photo's name and position.
bool IsHeader(const std::vector<TableCell>& cells) {
  std::optional<size_t> twice;
  const auto places = ColumnPlaces(TextsOf(cells), &twice);
  return std::all_of(kColumns.begin(), kColumns.begin() + 4,
                     [&](const char* name) { return places.contains(name); });
}

// The first line that is no comment, or a comment that is a header ("#Label,X/Easting,..."); sets
// the table's delimiter: the one by which the header is one, a comma by default.
std::vector<TableCell> HeaderCells(TableText* text) {
  std::string line;
  while (text->NextText(&line)) {
    const bool comment = TableText::IsComment(line);
    if (comment) line[line.find('#')] = ' ';
    for (const char delimiter : {',', ';', '\t'}) {
      text->SetDelimiter(delimiter);
      // An apostrophe or a quote in a comment closes nowhere.
      if (comment && line.find('"') != std::string::npos) continue;
      if (std::vector<TableCell> cells = text->Split(line); IsHeader(cells)) return cells;
    }
    text->SetDelimiter(',');
    if (!comment) return text->Split(line);
  }
  text->Fail(fmt::format("the table is empty; it starts with the header {}", kHeader));
}

Columns ReadHeader(TableText* text, Attitudes attitudes) {
  const std::vector<TableCell> cells = HeaderCells(text);
  Columns columns;
  columns.count = cells.size();
  std::optional<size_t> twice;
  columns.index = ColumnPlaces(TextsOf(cells), &twice);
  RequireColumns(*text, attitudes, &columns);
  if (twice)
    text->Fail(cells[*twice],
               fmt::format("the column \"{}\" appears twice", ColumnName(cells[*twice].text)));
  const auto known = [&](const char* name) { return columns.index.contains(name); };
  columns.sigmas = static_cast<size_t>(
      std::find_if_not(kSigmaColumns.begin(), kSigmaColumns.end(), known) - kSigmaColumns.begin());
  const auto given =
      static_cast<size_t>(std::count_if(kSigmaColumns.begin(), kSigmaColumns.end(), known));
  if (given != columns.sigmas || (given != 0 && given != 6 && (given != 3 || columns.has_angles)))
    text->Fail(
        "some sigma columns are missing; give all six (sigma_x,sigma_y,sigma_z,sigma_omega,"
        "sigma_phi,sigma_kappa) or none, of positions alone also the first three");
  return columns;
}

// Of photos that look down, of which nobody knows which way they were flown.
Vector6d OpenAttitude() {
  Vector6d sigma = Vector6d::Zero();
  sigma.tail<3>() << RadFromDeg(3), RadFromDeg(3), std::numbers::pi;
  return sigma;
}

std::optional<Vector6d> ReadSigma(const TableText& text, const Columns& columns,
                                  const std::vector<TableCell>& cells) {
  if (columns.sigmas == 0) return std::nullopt;
  const auto cell = [&](size_t i) -> const TableCell& {
    return cells[columns.index.at(kSigmaColumns[i])];
  };
  size_t empty = 0;
  for (size_t i = 0; i < columns.sigmas; ++i) empty += cell(i).text.empty() ? 1 : 0;
  if (empty == columns.sigmas) return std::nullopt;
  Vector6d sigma = OpenAttitude();
  for (size_t i = 0; i < columns.sigmas; ++i) {
    const double value = text.Number(cell(i), kSigmaColumns[i]);
    if (!(value > 0 && value <= kLargestSigma))
      text.Fail(cell(i),
                fmt::format("{} must be positive and at most {}", kSigmaColumns[i], kLargestSigma));
    sigma[static_cast<Eigen::Index>(i)] = i < 3 ? value : RadFromDeg(value);
  }
  return sigma;
}

std::optional<std::string> ReadDate(const TableText& text, const Columns& columns,
                                    const std::vector<TableCell>& cells) {
  const auto column = columns.index.find(kDateColumn);
  if (column == columns.index.end() || cells[column->second].text.empty()) return std::nullopt;
  const TableCell& cell = cells[column->second];
  if (const std::string wrong = WhyNoDate(cell.text); !wrong.empty()) text.Fail(cell, wrong);
  return cell.text;
}

// Empty where the table names none of this photo.
std::string ReadCamera(const Columns& columns, const std::vector<TableCell>& cells) {
  const auto column = columns.index.find("camera");
  return column == columns.index.end() ? "" : std::string(Trimmed(cells[column->second].text));
}

OrientationRow ReadRow(const TableText& text, const Columns& columns,
                       const std::vector<TableCell>& cells) {
  if (cells.size() != columns.count)
    text.Fail(fmt::format("the line has {} cells and the header {}", cells.size(), columns.count));
  OrientationRow row;
  const TableCell& name = cells[columns.index.at("filename")];
  row.photo = WithoutImageEnding(std::string(TextOfCell(name.text)));
  if (row.photo.empty()) text.Fail(name, "the photo has no name");
  row.attitude_known = columns.has_angles;
  for (size_t i = 1; i < (columns.has_angles ? kColumns.size() : 4); ++i) {
    const TableCell& cell = cells[columns.index.at(kColumns[i])];
    const double value = text.Number(cell, kColumns[i]);
    if (i <= 3) {
      row.pose.position_m[static_cast<Eigen::Index>(i - 1)] = value;
    } else if (std::abs(value) > 360) {
      text.Fail(cell, fmt::format("{} is {}; angles are in degrees", kColumns[i], cell.text));
    } else {
      row.pose.opk_rad[static_cast<Eigen::Index>(i - 4)] = NormalizeAngle(RadFromDeg(value));
    }
  }
  row.sigma = ReadSigma(text, columns, cells);
  row.date = ReadDate(text, columns, cells);
  return row;
}

std::string ProjectionPath(const std::string& path) {
  return fs::path(path).replace_extension(".prj").string();
}

// 0.1 mm and 1e-9 degrees: a tenth of what the eye or any adjustment can tell apart.
constexpr int kMetreDecimals = 4;
constexpr int kDegreeDecimals = 9;

std::string Quoted(const std::string& name) {
  if (name.find_first_of("\n\r") != std::string::npos)
    throw std::invalid_argument("WriteOrientationTable: a photo's name holds a line break");
  const std::string cell = CsvCell(name);
  const bool bare = !cell.starts_with('"');
  const bool quotes = name.starts_with('#') || name.starts_with(' ') || name.ends_with(' ');
  return bare && quotes ? "\"" + cell + "\"" : cell;
}

std::string RowText(const OrientationRow& row, bool with_sigma) {
  std::string text = Quoted(row.photo);
  const auto add = [&text](double value, int decimals) {
    if (!std::isfinite(value))
      throw std::invalid_argument("WriteOrientationTable: a value is not finite");
    text += fmt::format(",{:.{}f}", value, decimals);
  };
  for (int i = 0; i < 3; ++i) add(row.pose.position_m[i], kMetreDecimals);
  for (int i = 0; i < 3; ++i) add(DegFromRad(NormalizeAngle(row.pose.opk_rad[i])), kDegreeDecimals);
  for (int i = 0; with_sigma && i < 6; ++i) {
    if (!row.sigma)
      text += ",";
    else if (i < 3)
      add((*row.sigma)[i], kMetreDecimals + 2);
    else
      add(DegFromRad((*row.sigma)[i]), kDegreeDecimals);
  }
  return text + "\n";
}

}  // namespace

const OrientationRow* OrientationTable::Find(const std::string& photo) const {
  const auto found = std::find_if(rows.begin(), rows.end(),
                                  [&](const OrientationRow& row) { return row.photo == photo; });
  return found == rows.end() ? nullptr : &*found;
}

OrientationTable ReadOrientationTable(const std::string& path, Attitudes attitudes) {
  TableText text(path);
  const Columns columns = ReadHeader(&text, attitudes);
  OrientationTable table;
  std::set<std::string> names;
  std::vector<TableCell> cells;
  while (text.NextLine(&cells)) {
    table.rows.push_back(ReadRow(text, columns, cells));
    if (const std::string camera = ReadCamera(columns, cells); !camera.empty())
      table.cameras.insert(camera);
    if (!names.insert(table.rows.back().photo).second)
      text.Fail(cells[columns.index.at("filename")],
                fmt::format("the photo \"{}\" is named a second time", table.rows.back().photo));
  }
  std::error_code error;
  if (fs::exists(ProjectionPath(path), error)) table.crs = Crs::FromFile(ProjectionPath(path));
  return table;
}

void WriteOrientationTable(const std::string& path, const OrientationTable& table) {
  const bool with_sigma =
      std::any_of(table.rows.begin(), table.rows.end(),
                  [](const OrientationRow& row) { return row.sigma.has_value(); });
  std::string text = kHeader;
  for (size_t i = 0; with_sigma && i < kSigmaColumns.size(); ++i)
    text += std::string(",") + kSigmaColumns[i];
  text += "\n";
  for (const OrientationRow& row : table.rows) text += RowText(row, with_sigma);
  if (table.crs) WriteFileAtomically(ProjectionPath(path), table.crs->Wkt1() + "\n");
  WriteFileAtomically(path, text);
}

std::string PhotoName(const std::string& path) {
  return fs::path(IsRemote(path) ? WithoutEscapes(path) : path).stem().string();
}

}  // namespace orient

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
#include <utility>

#include "core/base/atomic_write.h"
#include "core/base/column_names.h"
#include "core/base/csv_cell.h"
#include "core/base/date.h"
#include "core/base/remote_files.h"
#include "core/base/table_text.h"
#include "core/base/trimmed.h"
#include "core/geometry/sigma.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr std::array<const char*, 7> kColumns = {"filename", "x",   "y",    "z",
                                                 "omega",    "phi", "kappa"};
constexpr std::array<const char*, 6> kSigmaColumns = {"sigma_x",     "sigma_y",   "sigma_z",
                                                      "sigma_omega", "sigma_phi", "sigma_kappa"};
constexpr const char* kDateColumn = "date";
constexpr std::array kDelimiters = {',', ';', '\t', ' '};
constexpr const char* kHeader = "filename,x,y,z,omega,phi,kappa";

constexpr const char* kHeightRemedy =
    "give the height of positions in metres (z), or the flying height above the ground: "
    "flying_height_m or scale under [flight] of a block file, or --flying-height-m of 'orient "
    "exterior'";

// The index of each known column in this table.
struct Columns {
  std::map<std::string, size_t> index;
  size_t count = 0;
  OpenCells open = OpenCells::kNone;
  bool has_sigmas = false;
  char delimiter = ',';  // of the header, and of the rows unless it is a comment
  bool in_comment = false;
  std::vector<std::string> ignored_angles;

  bool Has(const char* name) const { return index.contains(name); }
};

// For the columns x to kappa; `i` is the index in kColumns.
bool CellMayBeEmpty(OpenCells open, size_t i) {
  return i > 0 && (i == 3 ? open == OpenCells::kAnglesAndHeights : open != OpenCells::kNone);
}

bool IsAngle(size_t i) { return i > 3; }

// The header's column of the same quantity in another unit, as written; empty if there is none.
std::string InOtherUnit(const std::vector<TableCell>& cells, const std::string& name) {
  const auto cell = std::find_if(cells.begin(), cells.end(), [&](const TableCell& one) {
    return ColumnOfOtherUnit(one.text) == name;
  });
  return cell == cells.end() ? "" : cell->text;
}

bool HasLongitudes(const std::vector<TableCell>& cells) {
  return std::any_of(cells.begin(), cells.end(), [](const TableCell& cell) {
    const std::string name = ColumnName(cell.text);
    return name.starts_with("lon") || name.starts_with("lng") || name == "x/longitude";
  });
}

// Heights in another unit are an error, not missing; such angles are reported (IgnoredAngles).
void RequireColumn(const TableText& text, const std::vector<TableCell>& cells,
                   const Columns& columns, size_t i) {
  const std::string name = kColumns[i];
  if (columns.index.contains(name)) return;
  const bool of_approximations = columns.open != OpenCells::kNone;
  if (IsAngle(i) && of_approximations) return;
  const std::string missing = "the header has no column \"" + name + "\"";
  if (const std::string other = InOtherUnit(cells, name); !other.empty())
    text.Fail(fmt::format("{}, only \"{}\"; give it in {} and call it {}", missing, other,
                          IsAngle(i) ? "degrees" : "metres", name));
  if (i == 3 && CellMayBeEmpty(columns.open, i)) return;
  if (i == 3 && of_approximations) text.Fail(missing + "; " + kHeightRemedy);
  if ((i == 1 || i == 2) && of_approximations && HasLongitudes(cells))
    text.Fail(missing +
              "; a table's positions are metres in the block's CRS: give those in longitude and "
              "latitude, or in any other CRS, as points of a GeoJSON or GeoPackage file");
  text.Fail(missing + "; it is " + kHeader);
}

void RequireColumns(const TableText& text, const std::vector<TableCell>& cells,
                    const Columns& columns) {
  for (size_t i = 0; i < kColumns.size(); ++i) RequireColumn(text, cells, columns, i);
  if (columns.Has("omega") != columns.Has("phi"))
    text.Fail(fmt::format("the header has a column \"{}\" and no \"{}\"; give both or neither",
                          columns.Has("omega") ? "omega" : "phi",
                          columns.Has("omega") ? "phi" : "omega"));
}

// If an angle is missing, the columns that may be meant for it.
std::vector<std::string> IgnoredAngles(const std::vector<TableCell>& cells,
                                       const Columns& columns) {
  std::vector<std::string> ignored;
  if (columns.Has("omega") && columns.Has("phi") && columns.Has("kappa")) return ignored;
  for (const TableCell& cell : cells) {
    const std::string name = ColumnName(cell.text);
    const bool is_read = std::find(kColumns.begin(), kColumns.end(), name) != kColumns.end();
    if (!is_read && NamesAngle(cell.text)) ignored.push_back(cell.text);
  }
  // "roll" alone is the roll of film, not the angle.
  if (ignored.size() == 1 && ColumnName(ignored.front()) == "roll") ignored.clear();
  return ignored;
}

std::vector<std::string> TextsOf(const std::vector<TableCell>& cells) {
  std::vector<std::string> texts;
  for (const TableCell& cell : cells) texts.push_back(cell.text);
  return texts;
}

// Whether these are at least a photo's name and position (for approximations, x and y suffice).
bool IsHeader(const std::vector<TableCell>& cells, OpenCells open) {
  std::optional<size_t> twice;
  const auto places = ColumnPlaces(TextsOf(cells), &twice);
  return std::all_of(kColumns.begin(), kColumns.begin() + (open == OpenCells::kNone ? 4 : 3),
                     [&](const char* name) { return places.contains(name); });
}

// Cells of a line that is no header, by the delimiter that gives the most (a comma if none gives
// more), so that messages about missing columns refer to the columns that people see.
std::vector<TableCell> MostCells(TableText* text, const std::string& line) {
  std::vector<TableCell> most = text->Split(line);
  for (const char delimiter : {';', '\t'}) {
    text->SetDelimiter(delimiter);
    if (std::vector<TableCell> cells = text->Split(line); cells.size() > most.size())
      most = std::move(cells);
  }
  return most;
}

// The first line that is no comment, or a comment that is a header ("#Label,X/Easting,..."); sets
// the table's delimiter: the one with which the line is a header, a comma by default.
std::vector<TableCell> HeaderCells(TableText* text, OpenCells open, Columns* columns) {
  std::string line;
  while (text->NextText(&line)) {
    const bool comment = columns->in_comment = TableText::IsComment(line);
    if (comment) line[line.find('#')] = ' ';
    for (const char delimiter : kDelimiters) {
      text->SetDelimiter(columns->delimiter = delimiter);
      // A quote in a comment may never be closed.
      if (comment && line.find('"') != std::string::npos) continue;
      if (std::vector<TableCell> cells = text->Split(line); IsHeader(cells, open)) return cells;
    }
    text->SetDelimiter(columns->delimiter = ',');
    if (!comment) return MostCells(text, line);
  }
  text->Fail(fmt::format("the table is empty; it starts with the header {}", kHeader));
}

// All of the values that are there have sigmas, or none.
bool HasSigmas(const TableText& text, const Columns& columns) {
  const auto has = [&](const char* name) { return columns.Has(name); };
  if (std::none_of(kSigmaColumns.begin(), kSigmaColumns.end(), has)) return false;
  for (size_t i = 0; i < kSigmaColumns.size(); ++i)
    if (columns.Has(kColumns[i + 1]) && !columns.Has(kSigmaColumns[i]))
      text.Fail(
          "some sigma columns are missing; give all six (sigma_x,sigma_y,sigma_z,sigma_omega,"
          "sigma_phi,sigma_kappa) or none, of positions alone also the first three");
  return true;
}

Columns ReadHeader(TableText* text, OpenCells open) {
  Columns columns;
  const std::vector<TableCell> cells = HeaderCells(text, open, &columns);
  columns.count = cells.size();
  columns.open = open;
  std::optional<size_t> twice;
  columns.index = ColumnPlaces(TextsOf(cells), &twice);
  RequireColumns(*text, cells, columns);
  if (twice)
    text->Fail(cells[*twice],
               fmt::format("the column \"{}\" appears twice", ColumnName(cells[*twice].text)));
  columns.has_sigmas = HasSigmas(*text, columns);
  if (open != OpenCells::kNone) columns.ignored_angles = IgnoredAngles(cells, columns);
  return columns;
}

// The next row's cells; false at the end. A header in a comment may have another delimiter than the
// rows (Metashape: commas, then tabs): theirs is the one that gives as many cells as the header.
bool NextRow(TableText* text, Columns* columns, std::vector<TableCell>* cells) {
  std::string line;
  do {
    if (!text->NextText(&line)) return false;
  } while (TableText::IsComment(line));
  *cells = text->Split(line);
  if (!std::exchange(columns->in_comment, false)) return true;
  for (const char delimiter : kDelimiters) {
    if (cells->size() == columns->count) return true;
    text->SetDelimiter(delimiter);
    *cells = text->Split(line);
  }
  if (cells->size() == columns->count) return true;
  text->SetDelimiter(columns->delimiter);
  *cells = text->Split(line);
  return true;
}

// The cell of a column; null if there is no such column or the cell is empty.
const TableCell* Written(const Columns& columns, const std::vector<TableCell>& cells,
                         const char* name) {
  const auto column = columns.index.find(name);
  if (column == columns.index.end() || cells[column->second].text.empty()) return nullptr;
  return &cells[column->second];
}

double ReadOneSigma(const TableText& text, const TableCell& cell, size_t i) {
  const double value = text.Number(cell, kSigmaColumns[i]);
  if (const std::string why = SigmaProblem(value); !why.empty())
    text.Fail(cell, fmt::format("{} is {:g}; {}", kSigmaColumns[i], value, why));
  return i < 3 ? value : RadFromDeg(value);
}

// `values`: NaN if the row leaves them open. Such a photo is taken as near vertical, with unknown
// kappa and a height (from the flying height) that is no more accurate than the position.
std::optional<Vector6d> ReadSigma(const TableText& text, const Columns& columns,
                                  const std::vector<TableCell>& cells, const Vector6d& values) {
  if (!columns.has_sigmas ||
      std::none_of(kSigmaColumns.begin(), kSigmaColumns.end(),
                   [&](const char* name) { return Written(columns, cells, name) != nullptr; }))
    return std::nullopt;
  constexpr double kHeight_m = 10;
  Vector6d sigma;
  sigma << 0, 0, 0, RadFromDeg(3), RadFromDeg(3), std::numbers::pi;
  for (size_t i = 0; i < kSigmaColumns.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const bool open = std::isnan(values[at]);
    const TableCell* cell = Written(columns, cells, kSigmaColumns[i]);
    if (i == 2 && open) sigma[at] = std::max(kHeight_m, sigma.head<2>().maxCoeff());
    if (open && (cell == nullptr || i == 5)) continue;
    sigma[at] = ReadOneSigma(text, cells[columns.index.at(kSigmaColumns[i])], i);
  }
  return sigma;
}

std::optional<std::string> ReadDate(const TableText& text, const Columns& columns,
                                    const std::vector<TableCell>& cells) {
  const TableCell* cell = Written(columns, cells, kDateColumn);
  if (cell == nullptr) return std::nullopt;
  if (const std::string wrong = DateProblem(cell->text); !wrong.empty()) text.Fail(*cell, wrong);
  return cell->text;
}

// Empty if the table names no camera for this photo.
std::string ReadCamera(const Columns& columns, const std::vector<TableCell>& cells) {
  const TableCell* cell = Written(columns, cells, "camera");
  return cell == nullptr ? "" : std::string(Trimmed(cell->text));
}

// One of x to kappa; NaN if it is left open and that is allowed.
double ReadValue(const TableText& text, const Columns& columns, const std::vector<TableCell>& cells,
                 size_t i) {
  const auto column = columns.index.find(kColumns[i]);
  if (column == columns.index.end()) return std::nan("");
  const TableCell& cell = cells[column->second];
  if (cell.text.empty() && CellMayBeEmpty(columns.open, i)) return std::nan("");
  if (cell.text.empty() && i == 3 && columns.open != OpenCells::kNone)
    text.Fail(cell, std::string("z is empty; ") + kHeightRemedy);
  const double value = text.Number(cell, kColumns[i]);
  if (IsAngle(i) && std::abs(value) > 360)
    text.Fail(cell, fmt::format("{} is {}; angles are in degrees", kColumns[i], cell.text));
  return value;
}

// The position is NaN where the row leaves x or y open; nothing else is read then.
OrientationRow ReadRow(const TableText& text, const Columns& columns,
                       const std::vector<TableCell>& cells) {
  if (cells.size() != columns.count)
    text.Fail(fmt::format("the line has {} cells and the header {}{}", cells.size(), columns.count,
                          columns.delimiter == ' '
                              ? "; separate the cells by commas or tabs where names hold blanks"
                              : ""));
  OrientationRow row;
  const TableCell& name = cells[columns.index.at("filename")];
  row.photo = WithoutImageEnding(std::string(TextOfCell(name.text)));
  if (row.photo.empty()) text.Fail(name, "the photo has no name");
  Vector6d values = Vector6d::Constant(std::nan(""));
  for (size_t i = 1; i < kColumns.size(); ++i) {
    values[static_cast<Eigen::Index>(i - 1)] = ReadValue(text, columns, cells, i);
    if (i == 2 && !values.head<2>().allFinite()) break;
  }
  row.pose.position_m = values.head<3>();
  if (!values.head<2>().allFinite()) return row;
  row.attitude_known = !std::isnan(values[5]);
  for (int i = 0; i < 3; ++i)
    if (const double angle = values[i + 3]; !std::isnan(angle))
      row.pose.opk_rad[i] = NormalizeAngle(RadFromDeg(angle));
  row.sigma = ReadSigma(text, columns, cells, values);
  row.date = ReadDate(text, columns, cells);
  row.camera = ReadCamera(columns, cells);
  return row;
}

std::string ProjectionPath(const std::string& path) {
  return fs::path(path).replace_extension(".prj").string();
}

// 0.1 mm and 1e-9 degrees: a tenth of what the eye or any adjustment can distinguish.
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

OrientationTable ReadOrientationTable(const std::string& path, OpenCells open) {
  TableText text(path);
  Columns columns = ReadHeader(&text, open);
  OrientationTable table;
  table.ignored_angles = columns.ignored_angles;
  std::set<std::string> names;
  std::vector<TableCell> cells;
  while (NextRow(&text, &columns, &cells)) {
    OrientationRow row = ReadRow(text, columns, cells);
    if (!names.insert(row.photo).second)
      text.Fail(cells[columns.index.at("filename")],
                fmt::format("the photo \"{}\" is named a second time", row.photo));
    if (!row.camera.empty()) table.cameras.insert(row.camera);
    if (row.pose.position_m.head<2>().allFinite())
      table.rows.push_back(std::move(row));
    else
      table.without_position.push_back(row.photo);
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

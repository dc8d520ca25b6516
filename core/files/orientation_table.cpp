#include "core/files/orientation_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/date.h"
#include "core/base/error.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr std::array<const char*, 7> kColumns = {"filename", "x",   "y",    "z",
                                                 "omega",    "phi", "kappa"};
constexpr std::array<const char*, 6> kSigmaColumns = {"sigma_x",     "sigma_y",   "sigma_z",
                                                      "sigma_omega", "sigma_phi", "sigma_kappa"};
constexpr const char* kDateColumn = "date";
constexpr const char* kHeader = "filename,x,y,z,omega,phi,kappa";

struct Cell {
  std::string text;
  size_t column = 1;  // of the cell's first character in its line, from 1
};

// Reads one line after another and knows where it is.
class TableText {
 public:
  TableText(std::string path, std::string text) : path_(std::move(path)), text_(std::move(text)) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text_.starts_with(kByteOrderMark)) position_ = kByteOrderMark.size();
  }

  // Cells of the next line that holds anything; comment lines start with '#'. False at the end.
  bool NextLine(std::vector<Cell>* cells) {
    while (position_ < text_.size()) {
      const size_t end = std::min(text_.find('\n', position_), text_.size());
      std::string line = text_.substr(position_, end - position_);
      position_ = end + 1;
      ++line_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      const size_t first = line.find_first_not_of(" \t");
      if (first == std::string::npos || line[first] == '#') continue;
      *cells = Split(line);
      return true;
    }
    return false;
  }

  [[noreturn]] void Fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}, line {}: {}", path_, line_, complaint));
  }
  [[noreturn]] void Fail(const Cell& cell, const std::string& complaint) const {
    throw InputError(
        fmt::format("{}, line {}, column {}: {}", path_, line_, cell.column, complaint));
  }

 private:
  static std::string Trimmed(const std::string& text) {
    const size_t first = text.find_first_not_of(" \t");
    if (first == std::string::npos) return "";
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
  }

  // RFC 4180: a quoted cell may hold commas and doubled quotes (no line breaks, they have no place
  // in a photo's name).
  std::vector<Cell> Split(const std::string& line) const {
    std::vector<Cell> cells;
    for (size_t i = 0; i <= line.size(); ++i) {  // i: first character of a cell
      size_t first = std::min(line.find_first_not_of(" \t", i), line.size());
      Cell cell{"", first + 1};
      if (first < line.size() && line[first] == '"') {
        i = ReadQuoted(line, first, &cell);
      } else {
        const size_t comma = std::min(line.find(',', i), line.size());
        cell = {Trimmed(line.substr(i, comma - i)), (first < comma ? first : i) + 1};
        i = comma;
      }
      cells.push_back(std::move(cell));
    }
    return cells;
  }

  // Returns where the cell's comma (or the line's end) stands.
  size_t ReadQuoted(const std::string& line, size_t quote, Cell* cell) const {
    size_t i = quote + 1;
    for (; i < line.size(); ++i) {
      if (line[i] == '"') {
        if (i + 1 >= line.size() || line[i + 1] != '"') break;
        ++i;
      }
      cell->text += line[i];
    }
    if (i >= line.size()) Fail(*cell, "the quote is never closed; add a \" at the cell's end");
    i = std::min(line.find_first_not_of(" \t", i + 1), line.size());
    if (i < line.size() && line[i] != ',')
      Fail(*cell, "text follows the closing quote; double a quote that belongs to the name");
    return i;
  }

  std::string path_;
  std::string text_;
  size_t position_ = 0;
  int line_ = 0;
};

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

Columns ReadHeader(TableText* text, Attitudes attitudes) {
  std::vector<Cell> cells;
  if (!text->NextLine(&cells))
    text->Fail(std::string("the table is empty; it starts with the header ") + kHeader);
  Columns columns;
  columns.count = cells.size();
  for (size_t i = 0; i < cells.size(); ++i) columns.index.emplace(cells[i].text, i);
  RequireColumns(*text, attitudes, &columns);
  for (size_t i = 0; i < cells.size(); ++i)
    if (columns.index.at(cells[i].text) != i)
      text->Fail(cells[i], fmt::format("the column \"{}\" appears twice", cells[i].text));
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

double ParseNumber(const TableText& text, const Cell& cell, const std::string& name) {
  const char* first = cell.text.data();
  const char* last = first + cell.text.size();
  if (first != last && *first == '+') ++first;
  double number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (first == last || error != std::errc() || end != last || !std::isfinite(number))
    text.Fail(cell, name + " is \"" + cell.text +
                        "\"; it must be a number with a point as its decimal mark");
  return number;
}

// Of photos that look down, of which nobody knows which way they were flown.
Vector6d OpenAttitude() {
  Vector6d sigma = Vector6d::Zero();
  sigma.tail<3>() << RadFromDeg(3), RadFromDeg(3), std::numbers::pi;
  return sigma;
}

std::optional<Vector6d> ReadSigma(const TableText& text, const Columns& columns,
                                  const std::vector<Cell>& cells) {
  if (columns.sigmas == 0) return std::nullopt;
  const auto cell = [&](size_t i) -> const Cell& {
    return cells[columns.index.at(kSigmaColumns[i])];
  };
  size_t empty = 0;
  for (size_t i = 0; i < columns.sigmas; ++i) empty += cell(i).text.empty() ? 1 : 0;
  if (empty == columns.sigmas) return std::nullopt;
  Vector6d sigma = OpenAttitude();
  for (size_t i = 0; i < columns.sigmas; ++i) {
    const double value = ParseNumber(text, cell(i), kSigmaColumns[i]);
    if (value <= 0) text.Fail(cell(i), std::string(kSigmaColumns[i]) + " must be positive");
    sigma[static_cast<Eigen::Index>(i)] = i < 3 ? value : RadFromDeg(value);
  }
  return sigma;
}

std::optional<std::string> ReadDate(const TableText& text, const Columns& columns,
                                    const std::vector<Cell>& cells) {
  const auto column = columns.index.find(kDateColumn);
  if (column == columns.index.end() || cells[column->second].text.empty()) return std::nullopt;
  const Cell& cell = cells[column->second];
  if (const std::string wrong = WhyNoDate(cell.text); !wrong.empty()) text.Fail(cell, wrong);
  return cell.text;
}

OrientationRow ReadRow(const TableText& text, const Columns& columns,
                       const std::vector<Cell>& cells) {
  if (cells.size() != columns.count)
    text.Fail(fmt::format("the line has {} cells and the header {}", cells.size(), columns.count));
  OrientationRow row;
  const Cell& name = cells[columns.index.at("filename")];
  row.photo = name.text;
  if (row.photo.empty()) text.Fail(name, "the photo has no name");
  row.attitude_known = columns.has_angles;
  for (size_t i = 1; i < (columns.has_angles ? kColumns.size() : 4); ++i) {
    const Cell& cell = cells[columns.index.at(kColumns[i])];
    const double value = ParseNumber(text, cell, kColumns[i]);
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
  const bool plain = name.find_first_of(",\"") == std::string::npos && !name.starts_with('#') &&
                     !name.starts_with(' ') && !name.ends_with(' ');
  if (plain) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
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
  TableText text(path, ReadFile(path));
  const Columns columns = ReadHeader(&text, attitudes);
  OrientationTable table;
  std::set<std::string> names;
  std::vector<Cell> cells;
  while (text.NextLine(&cells)) {
    table.rows.push_back(ReadRow(text, columns, cells));
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

std::string PhotoName(const std::string& path) { return fs::path(path).stem().string(); }

}  // namespace orient

#include "core/base/table_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/base/atomic_write.h"
#include "core/base/csv_cell.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/trimmed.h"

namespace orient {

TableText::TableText(std::string path) : path_(std::move(path)), text_(ReadFile(path_)) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text_.starts_with(kByteOrderMark)) position_ = kByteOrderMark.size();
  // A header in UTF-16 has a zero beside every letter.
  if (text_.substr(0, text_.find('\n')).find('\0') != std::string::npos)
    throw InputError(path_ + " is not a text in UTF-8 (UTF-16?); save it as UTF-8");
}

bool TableText::NextText(std::string* line) {
  while (position_ < text_.size()) {
    const std::size_t end = std::min(text_.find_first_of("\r\n", position_), text_.size());
    *line = text_.substr(position_, end - position_);
    position_ = end + (text_.compare(end, 2, "\r\n") == 0 ? 2 : 1);
    ++line_;
    if (line->find_first_not_of(" \t") != std::string::npos) return true;
  }
  return false;
}

bool TableText::NextLine(std::vector<TableCell>* cells) {
  std::string line;
  while (NextText(&line))
    if (!IsComment(line)) {
      *cells = Split(line);
      return true;
    }
  return false;
}

bool TableText::IsComment(const std::string& line) {
  const std::size_t first = line.find_first_not_of(" \t");
  return first != std::string::npos && line[first] == '#';
}

std::size_t TableText::FirstInk(const std::string& line, std::size_t from) const {
  return std::min(line.find_first_not_of(delimiter_ == '\t' ? " " : " \t", from), line.size());
}

double TableText::Number(const TableCell& cell, const std::string& name) const {
  const auto number = SignedNumberIn(cell.text);
  if (!number)
    Fail(cell,
         name + " is \"" + cell.text + "\"; it must be a number with a point as its decimal mark");
  return *number;
}

std::string TableText::Where() const { return fmt::format("{}, line {}", path_, line_); }

void TableText::Fail(const std::string& complaint) const {
  throw InputError(Where() + ": " + complaint);
}

void TableText::Fail(const TableCell& cell, const std::string& complaint) const {
  throw InputError(fmt::format("{}, line {}, column {}: {}", path_, line_, cell.column, complaint));
}

namespace {

std::vector<TableCell> Words(const std::string& line) {
  constexpr const char* kBlank = " \t";
  std::vector<TableCell> words;
  std::size_t begin = line.find_first_not_of(kBlank);
  while (begin != std::string::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlank, begin), line.size());
    words.push_back({line.substr(begin, end - begin), begin + 1});
    begin = line.find_first_not_of(kBlank, end);
  }
  return words;
}

}  // namespace

// A quoted cell may hold commas and doubled quotes (no line breaks, they have no place in a name).
std::vector<TableCell> TableText::Split(const std::string& line) const {
  if (delimiter_ == ' ') return Words(line);
  std::vector<TableCell> cells;
  for (std::size_t i = 0; i <= line.size(); ++i) {  // i: first character of a cell
    const std::size_t first = FirstInk(line, i);
    TableCell cell{"", first + 1};
    if (first < line.size() && line[first] == '"') {
      i = ReadQuoted(line, first, &cell);
    } else {
      const std::size_t comma = std::min(line.find(delimiter_, i), line.size());
      cell = {std::string(Trimmed(std::string_view(line).substr(i, comma - i))),
              (first < comma ? first : i) + 1};
      i = comma;
    }
    cells.push_back(std::move(cell));
  }
  return cells;
}

// Returns the position of the delimiter after the cell (or of the line's end).
std::size_t TableText::ReadQuoted(const std::string& line, std::size_t quote,
                                  TableCell* cell) const {
  std::size_t i = quote + 1;
  for (; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (i + 1 >= line.size() || line[i + 1] != '"') break;
      ++i;
    }
    cell->text += line[i];
  }
  if (i >= line.size()) Fail(*cell, "the quote is never closed; add a \" at the cell's end");
  i = FirstInk(line, i + 1);
  if (i < line.size() && line[i] != delimiter_)
    Fail(*cell, "text follows the closing quote; double a quote that belongs to the name");
  return i;
}

NamedTable::NamedTable(const std::string& path, const std::vector<std::string>& required,
                       const std::vector<std::string>& optional)
    : text_(path) {
  const std::string header = fmt::format("{}", fmt::join(required, ","));
  if (!text_.NextLine(&cells_))
    text_.Fail("the table is empty; it starts with the header " + header);
  for (const TableCell& cell : cells_) {
    const auto among = [&](const std::vector<std::string>& names) {
      return std::find(names.begin(), names.end(), cell.text) != names.end();
    };
    if (!among(required) && !among(optional))
      text_.Fail(cell, fmt::format("there is no column \"{}\"; the columns are {} and, "
                                   "optionally, {}",
                                   cell.text, header, fmt::join(optional, ",")));
    if (!columns_.emplace(cell.text, columns_.size()).second)
      text_.Fail(cell, fmt::format("the column \"{}\" appears twice", cell.text));
  }
  for (const std::string& name : required)
    if (!Has(name))
      text_.Fail(fmt::format("the header has no column \"{}\"; it is {}", name, header));
}

bool NamedTable::Next() {
  if (!text_.NextLine(&cells_)) return false;
  if (cells_.size() != columns_.size())
    text_.Fail(
        fmt::format("the line has {} cells and the header {}", cells_.size(), columns_.size()));
  return true;
}

const TableCell& NamedTable::Cell(const std::string& column) const {
  return cells_[columns_.at(column)];
}

std::string NamedTable::Text(const std::string& column) const {
  return Has(column) ? std::string(TextOfCell(Cell(column).text)) : std::string();
}

std::string NamedTable::Name(const std::string& column) const {
  if (Text(column).empty()) Fail(column, fmt::format("the {} has no name", column));
  return Text(column);
}

double NamedTable::Number(const std::string& column) const {
  return text_.Number(Cell(column), column);
}

double NamedTable::PositiveNumber(const std::string& column) const {
  const double number = Number(column);
  if (!(number > 0))
    Fail(column, fmt::format("{} is {}; it must be positive", column, Text(column)));
  return number;
}

void NamedTable::Fail(const std::string& column, const std::string& complaint) const {
  text_.Fail(Cell(column), complaint);
}

}  // namespace orient

// Tables of comma-separated values that people write (RFC 4180), with errors that name file, line
// and column.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace orient {

struct TableCell {
  std::string text;
  std::size_t column = 1;  // of the cell's first character in its line, from 1
};

// Reads one line after another and knows where it is.
class TableText {
 public:
  // Throws InputError where the file cannot be read.
  explicit TableText(std::string path);

  // The next line that holds anything, a comment or not. False at the end.
  bool NextText(std::string* line);
  // Cells of the next one that is no comment.
  bool NextLine(std::vector<TableCell>* cells);
  // Whether it starts with '#'.
  static bool IsComment(const std::string& line);
  // ',' until another one is set; ' ' stands for any number of blanks and tabs, and knows no
  // quotes.
  void SetDelimiter(char delimiter) { delimiter_ = delimiter; }
  std::vector<TableCell> Split(const std::string& line) const;
  // Throws InputError where the cell holds no finite number; `name` is what it should be.
  double Number(const TableCell& cell, const std::string& name) const;
  std::string Where() const;  // "<file>, line <n>": of the line read last
  [[noreturn]] void Fail(const std::string& complaint) const;
  [[noreturn]] void Fail(const TableCell& cell, const std::string& complaint) const;

 private:
  std::size_t FirstInk(const std::string& line, std::size_t from) const;
  std::size_t ReadQuoted(const std::string& line, std::size_t quote, TableCell* cell) const;

  std::string path_;
  std::string text_;
  std::size_t position_ = 0;
  int line_ = 0;
  char delimiter_ = ',';
};

// A table whose first line names its columns, in any order: cells by name.
class NamedTable {
 public:
  // Throws InputError where a required column is missing, or one is neither required nor optional,
  // or stands twice.
  NamedTable(const std::string& path, const std::vector<std::string>& required,
             const std::vector<std::string>& optional);

  bool Has(const std::string& column) const { return columns_.contains(column); }
  // The next line; false at the end. Throws InputError where it has more or fewer cells.
  bool Next();
  // Of the present line. Text: empty where the column is not there. Throws InputError where a cell
  // of a name is empty, or one of a number holds none.
  std::string Text(const std::string& column) const;
  std::string Name(const std::string& column) const;
  double Number(const std::string& column) const;
  double PositiveNumber(const std::string& column) const;
  [[noreturn]] void Fail(const std::string& column, const std::string& complaint) const;

 private:
  const TableCell& Cell(const std::string& column) const;

  TableText text_;
  std::map<std::string, std::size_t> columns_;
  std::vector<TableCell> cells_;
};

}  // namespace orient

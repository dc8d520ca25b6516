// The table at the end of a run.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "core/base/number_text.h"
#include "core/files/finding.h"

namespace orient {

// Columns as wide as their widest cell, two spaces between them; a column whose cells are all
// numbers (or "-") stands to the right.
class SummaryTable {
 public:
  explicit SummaryTable(std::vector<std::string> header);
  // Throws std::invalid_argument where the row is not as long as the header.
  void AddRow(std::vector<std::string> cells);
  void Print(std::ostream& out) const;

 private:
  std::vector<std::vector<std::string>> rows_;  // the header first
};

// Of several findings the first of those that decide the status, and how many more the result file
// has.
std::string MessageCell(const Findings& findings);

}  // namespace orient

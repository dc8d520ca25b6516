// Tables of the report.
#pragma once

#include <string>
#include <vector>

#include "core/files/results.h"

namespace orient {

// Cells are HTML: escape what comes from files. The header's columns that begin with '#' hold
// numbers and stand to the right.
class HtmlTable {
 public:
  explicit HtmlTable(const std::vector<std::string>& header, const std::string& css_class = "");
  // Throws std::invalid_argument where the row is not as long as the header.
  void AddRow(const std::vector<std::string>& cells);
  std::string Html() const;

 private:
  std::vector<bool> numeric_;
  std::string html_;
};

// A coloured word: "ok", "weak", "failed".
std::string StatusPill(Status status);

}  // namespace orient

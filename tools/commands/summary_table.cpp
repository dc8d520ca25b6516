#include "tools/commands/summary_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <stdexcept>

namespace orient {
namespace {

// Characters on the screen: UTF-8's continuation bytes take no room.
size_t Width(const std::string& text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

bool IsNumber(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789.+-%e ") == std::string::npos;
}

}  // namespace

SummaryTable::SummaryTable(std::vector<std::string> header) { rows_.push_back(std::move(header)); }

void SummaryTable::AddRow(std::vector<std::string> cells) {
  if (cells.size() != rows_.front().size())
    throw std::invalid_argument("SummaryTable: a row has another length than the header");
  rows_.push_back(std::move(cells));
}

void SummaryTable::Print(std::ostream& out) const {
  const size_t columns = rows_.front().size();
  std::vector<size_t> width(columns, 0);
  std::vector<bool> to_right(columns, rows_.size() > 1);
  for (size_t row = 0; row < rows_.size(); ++row) {
    for (size_t column = 0; column < columns; ++column) {
      width[column] = std::max(width[column], Width(rows_[row][column]));
      if (row > 0 && !IsNumber(rows_[row][column])) to_right[column] = false;
    }
  }
  for (const auto& row : rows_) {
    std::string line;
    for (size_t column = 0; column < columns; ++column) {
      const std::string padding(width[column] - Width(row[column]), ' ');
      line += column > 0 ? "  " : "";
      line += to_right[column] ? padding + row[column] : row[column] + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << "\n";
  }
}

std::string MessageCell(const Findings& findings) {
  if (findings.empty()) return "";
  const Status status = StatusOf(findings);
  const auto deciding = std::find_if(findings.begin(), findings.end(), [&](const Finding& finding) {
    return finding.at_best == status;
  });
  const std::string told = Sentence(*deciding);
  return findings.size() == 1 ? told : fmt::format("{} (+{} more)", told, findings.size() - 1);
}

}  // namespace orient

#include "tools/report/html_table.h"

#include <stdexcept>

namespace orient {

HtmlTable::HtmlTable(const std::vector<std::string>& header, const std::string& css_class) {
  html_ = "<div class=\"wide\"><table" + (css_class.empty() ? "" : " class=\"" + css_class + "\"") +
          ">\n<thead><tr>";
  for (const std::string& column : header) {
    numeric_.push_back(column.starts_with('#'));
    html_ += numeric_.back() ? "<th class=\"n\">" + column.substr(1) : "<th>" + column;
    html_ += "</th>";
  }
  html_ += "</tr></thead>\n<tbody>\n";
}

void HtmlTable::AddRow(const std::vector<std::string>& cells) {
  if (cells.size() != numeric_.size())
    throw std::invalid_argument("HtmlTable: a row is not as long as the header");
  html_ += "<tr>";
  for (size_t i = 0; i < cells.size(); ++i)
    html_ += (numeric_[i] ? "<td class=\"n\">" : "<td>") + cells[i] + "</td>";
  html_ += "</tr>\n";
}

std::string HtmlTable::Html() const { return html_ + "</tbody></table></div>\n"; }

std::string StatusPill(Status status) {
  const std::string name(Name(status));
  return "<span class=\"pill " + name + "\">" + name + "</span>";
}

}  // namespace orient

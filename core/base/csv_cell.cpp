#include "core/base/csv_cell.h"

#include "core/base/number_text.h"

namespace orient {
namespace {

// Also true after leading apostrophes, so that TextOfCell recognises an added one.
bool IsFormula(std::string_view text) {
  const std::size_t first = text.find_first_not_of('\'');
  if (first == std::string_view::npos ||
      std::string_view("=+-@").find(text[first]) == std::string_view::npos)
    return false;
  return !NumberIn(text);
}

}  // namespace

std::string CsvCell(const std::string& text) {
  const std::string cell = IsFormula(text) ? "'" + text : text;
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  std::string quoted = "\"";
  for (const char c : cell) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string_view TextOfCell(std::string_view cell) {
  if (cell.starts_with('\'') && IsFormula(cell)) cell.remove_prefix(1);
  return cell;
}

}  // namespace orient

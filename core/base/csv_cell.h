// Cells of tables (CSV) that spreadsheets open.
#pragma once

#include <string>
#include <string_view>

namespace orient {

// A cell as RFC 4180 wants it: quoted where it holds a comma, a quote or a line's end. A text that
// a spreadsheet would take for a formula (it begins with = + - or @ and is not a number) gets an
// apostrophe before it.
std::string CsvCell(const std::string& text);

// The text of such a cell, once its quotes are gone: without the apostrophe.
std::string_view TextOfCell(std::string_view cell);

}  // namespace orient

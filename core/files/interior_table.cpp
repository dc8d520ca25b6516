#include "core/files/interior_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/csv_cell.h"
#include "core/files/used_marks.h"

namespace orient {
namespace {

using Cells = std::vector<std::string>;

std::string Row(const Cells& cells) {
  std::string row;
  for (const std::string& cell : cells) {
    if (&cell != &cells.front()) row += ",";
    row += CsvCell(cell);
  }
  return row + "\n";
}

std::string Number(const std::optional<double>& value, int digits) {
  if (!value || !std::isfinite(*value)) return "";
  return fmt::format("{:.{}g}", *value, digits);
}

std::string Fraction(const std::optional<double>& value, int decimals) {
  if (!value || !std::isfinite(*value)) return "";
  return fmt::format("{:.{}f}", *value, decimals);
}

template <typename Enum>
std::string NameOrNone(const std::optional<Enum>& value) {
  return value ? std::string(Name(*value)) : "";
}

void AddVector(const std::optional<Eigen::Vector2d>& vector, int decimals, Cells* cells) {
  for (const int i : {0, 1})
    cells->push_back(vector ? Fraction((*vector)[i], decimals) : std::string());
}

Cells PhotoCells(const InteriorResult& r) {
  Cells cells = {r.photo,
                 std::string(Name(r.status)),
                 std::to_string(r.width),
                 std::to_string(r.height),
                 Number(r.pixel_size_um, 9),
                 NameOrNone(r.polarity),
                 r.possible_orientations.size() > 1 ? "open" : NameOrNone(r.orientation)};
  std::vector<std::string_view> possible;
  for (const ScanOrientation orientation : r.possible_orientations)
    possible.push_back(Name(orientation));
  cells.push_back(fmt::format("{}", fmt::join(possible, " ")));
  // If several orientations are possible, the transform in the first of them is not a result.
  const bool known = r.photo_from_pixel && r.possible_orientations.size() <= 1;
  for (const int row : {0, 1})
    for (const int col : {0, 1})
      cells.push_back(known ? Number(r.photo_from_pixel->A(row, col), 12) : "");
  for (const int row : {0, 1}) cells.push_back(known ? Number(r.photo_from_pixel->t[row], 12) : "");
  cells.push_back(Fraction(r.sigma0_um, 2));
  cells.push_back(Fraction(r.margin, 2));
  cells.push_back(std::to_string(CountUsedMarks(r)));
  cells.push_back(std::to_string(r.marks.size()));
  cells.push_back(fmt::format("{}", fmt::join(Sentences(r.findings), " ")));
  return cells;
}

}  // namespace

std::string InteriorTable(const std::vector<InteriorResult>& results) {
  std::string text =
      "photo,status,scan_width,scan_height,pixel_size_um,polarity,orientation,possible_"
      "orientations,a11,a12,a21,a22,t1,"
      "t2,sigma0_um,margin,marks_used,marks,messages\n";
  for (const InteriorResult& result : results) text += Row(PhotoCells(result));
  return text;
}

std::string MarkTable(const std::vector<InteriorResult>& results,
                      const std::vector<Fiducial>& fiducials) {
  std::string text =
      "photo,mark,state,col,row,sigma_col_px,sigma_row_px,x_mm,y_mm,residual_x_um,residual_y_um,"
      "score\n";
  for (const InteriorResult& result : results)
    for (const MarkResult& mark : result.marks) {
      const auto fiducial = std::find_if(fiducials.begin(), fiducials.end(),
                                         [&](const Fiducial& f) { return f.id == mark.id; });
      Cells cells = {result.photo, mark.id, std::string(Name(mark.state))};
      AddVector(mark.pixel, 4, &cells);
      AddVector(mark.sigma_px, 4, &cells);
      AddVector(fiducial == fiducials.end() ? std::nullopt : std::optional(fiducial->position_mm),
                5, &cells);
      AddVector(mark.residual_um, 2, &cells);
      cells.push_back(Fraction(mark.score, 4));
      text += Row(cells);
    }
  return text;
}

}  // namespace orient

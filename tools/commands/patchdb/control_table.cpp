#include "tools/commands/patchdb/control_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "patchdb/store/patch_limits.h"

namespace orient {
namespace {

constexpr const char* kHeader = "point,x,y,z,sigma_x,sigma_y,sigma_z,photo,col,row";
constexpr std::size_t kColumns = 10;

class Lines {
 public:
  explicit Lines(const std::string& path) : path_(path), text_(ReadFile(path)) {}

  // Cells of the next line that holds anything; false at the end.
  bool Next(std::vector<std::string>* cells) {
    std::string line;
    while (std::getline(text_, line)) {
      ++number_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      if (line.find_first_not_of(" \t") == std::string::npos || line[0] == '#') continue;
      *cells = Split(line);
      return true;
    }
    return false;
  }

  [[noreturn]] void Fail(const std::string& complaint) const {
    throw InputError(fmt::format("{}, line {}: {}", path_, number_, complaint));
  }

  double Number(const std::string& text) const {
    const auto value = NumberIn(text);
    if (!value) Fail(fmt::format("'{}' is not a number", text));
    return *value;
  }

 private:
  static std::vector<std::string> Split(const std::string& line) {
    std::vector<std::string> cells;
    for (std::size_t i = 0; i <= line.size();) {
      const std::size_t comma = std::min(line.find(',', i), line.size());
      std::string cell = line.substr(i, comma - i);
      const std::size_t first = cell.find_first_not_of(" \t");
      cell = first == std::string::npos
                 ? ""
                 : cell.substr(first, cell.find_last_not_of(" \t") - first + 1);
      cells.push_back(cell);
      i = comma + 1;
    }
    return cells;
  }

  std::string path_;
  std::istringstream text_;
  int number_ = 0;
};

patchdb::ControlPoint PointOf(const Lines& lines, const std::vector<std::string>& cells) {
  patchdb::ControlPoint point;
  point.id = cells[0];
  for (int i = 0; i < 3; ++i) {
    point.ground_m[i] = lines.Number(cells[static_cast<std::size_t>(1 + i)]);
    point.sigma_m[i] = lines.Number(cells[static_cast<std::size_t>(4 + i)]);
  }
  if (!(point.sigma_m.minCoeff() > 0)) lines.Fail("a sigma must be positive");
  if (!(point.sigma_m.maxCoeff() <= patchdb::kGreatestPatchSigma_m))
    lines.Fail(fmt::format("a sigma is at most {:.0f} m", patchdb::kGreatestPatchSigma_m));
  return point;
}

}  // namespace

std::vector<ControlTablePoint> ReadControlTable(const std::string& path) {
  Lines lines(path);
  std::vector<std::string> cells;
  std::string header;
  if (lines.Next(&cells))
    for (const std::string& cell : cells) header += (header.empty() ? "" : ",") + cell;
  if (header != kHeader) lines.Fail(std::string("the header must be ") + kHeader);
  std::vector<ControlTablePoint> points;
  while (lines.Next(&cells)) {
    if (cells.size() != kColumns || cells[0].empty() || cells[7].empty())
      lines.Fail("a row must have ten cells, point and photo not empty");
    const patchdb::ControlPoint point = PointOf(lines, cells);
    auto known = std::find_if(points.begin(), points.end(), [&](const ControlTablePoint& other) {
      return other.point.id == point.id;
    });
    if (known == points.end()) known = points.insert(points.end(), {point, {}});
    if (known->point.ground_m != point.ground_m || known->point.sigma_m != point.sigma_m)
      lines.Fail(
          fmt::format("point '{}' has other coordinates or sigmas in an earlier row", point.id));
    for (const MeasuredPoint& other : known->measured)
      if (other.photo == cells[7])
        lines.Fail("point '" + point.id + "' is measured twice in photo '" + other.photo + "'");
    known->measured.push_back(
        {cells[7], Eigen::Vector2d(lines.Number(cells[8]), lines.Number(cells[9]))});
  }
  return points;
}

}  // namespace orient

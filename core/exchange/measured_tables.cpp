#include "core/exchange/measured_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/base/column_names.h"
#include "core/base/csv_cell.h"
#include "core/base/error.h"
#include "core/base/table_text.h"
#include "core/exchange/measured_columns.h"
#include "core/geometry/sigma.h"

namespace orient {
namespace {

constexpr double kPixelSigma = 1;
constexpr double kPhotoSigma_mm = 0.01;

std::vector<std::string> TextsOf(const std::vector<TableCell>& cells) {
  std::vector<std::string> texts;
  for (const TableCell& cell : cells) texts.push_back(cell.text);
  return texts;
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// The lines of a table; cells are accessed by the meaning of their column.
class MeasuredTable {
 public:
  explicit MeasuredTable(const std::string& path) : text_(path) { ReadHeader(); }

  const MeasuredColumns& Columns() const { return columns_; }
  std::string Where() const { return text_.Where(); }

  bool Next() {
    if (!text_.NextLine(&cells_)) return false;
    if (cells_.size() != count_)
      text_.Fail(fmt::format("the line has {} cells and the header {}", cells_.size(), count_));
    return true;
  }

  // Empty if the table has no column of this meaning.
  std::string Text(const std::string& meaning) const {
    return columns_.Has(meaning) ? std::string(TextOfCell(Cell(meaning).text)) : std::string();
  }

  double Number(const std::string& meaning) {
    TableCell cell = Cell(meaning);
    const std::size_t comma = cell.text.find(',');
    const bool point = cell.text.find('.') != std::string::npos;
    if (delimiter_ == ',' || (comma == std::string::npos && !point))
      return text_.Number(cell, meaning);
    if (decimal_mark_ == '\0') decimal_mark_ = point ? '.' : ',';
    if ((point && comma != std::string::npos) || decimal_mark_ != (point ? '.' : ','))
      text_.Fail(cell,
                 fmt::format("{} is \"{}\", but other numbers of the table have a decimal {}; "
                             "write all with the same decimal mark, and none for thousands",
                             meaning, cell.text, decimal_mark_ == ',' ? "comma" : "point"));
    if (comma != std::string::npos) cell.text[comma] = '.';
    return text_.Number(cell, meaning);
  }

  // Empty if there is no such column or the cell is empty.
  std::optional<double> Sigma(const std::string& meaning) {
    if (Text(meaning).empty()) return std::nullopt;
    const double sigma = Number(meaning);
    if (const std::string why = SigmaProblem(sigma); !why.empty())
      Fail(meaning, fmt::format("the accuracy is {}; {}", Text(meaning), why));
    return sigma;
  }

  [[noreturn]] void Fail(const std::string& meaning, const std::string& complaint) const {
    text_.Fail(Cell(meaning), complaint);
  }

 private:
  const TableCell& Cell(const std::string& meaning) const {
    return cells_[columns_.places.at(meaning)];
  }

  // The first line that is no comment, or a comment that is a header ("#Label,X/Easting,...").
  void ReadHeader() {
    std::string line;
    while (text_.NextText(&line)) {
      const bool comment = TableText::IsComment(line);
      if (comment) line[line.find('#')] = ' ';
      if (comment && line.find('"') != std::string::npos) continue;
      std::string why_not;
      for (const char delimiter : {',', ';', '\t'}) {
        if (TakeHeader(line, delimiter)) return;
        if (why_not.empty() || line.find(delimiter) != std::string::npos)
          why_not = columns_.why_not;
      }
      if (!comment) text_.Fail(why_not);
    }
    text_.Fail("the table is empty; it begins with a line that names its columns");
  }

  bool TakeHeader(const std::string& line, char delimiter) {
    text_.SetDelimiter(delimiter);
    const std::vector<std::string> header = TextsOf(text_.Split(line));
    columns_ = MeasuredColumnsOf(header);
    delimiter_ = delimiter;
    count_ = header.size();
    return columns_.why_not.empty();
  }

  TableText text_;
  MeasuredColumns columns_;
  std::size_t count_ = 0;
  char delimiter_ = ',', decimal_mark_ = '\0';
  std::vector<TableCell> cells_;
};

class TableReader {
 public:
  TableReader(const std::string& path, const MeasuredSigma& sigma, GatheredMeasurements* all)
      : path_(path), table_(path), sigma_(sigma), all_(*all) {}

  void Read() {
    const MeasuredColumns& columns = table_.Columns();
    while (table_.Next()) {
      if (columns.image_points) AddImagePoint();
      if (columns.ground_points) AddGroundPoint();
    }
    if (ground_points_ > 0 && in_degrees_)
      throw InputError(path_ +
                       ": all its ground points lie within 180 by 90, so these are degrees; "
                       "transform them to the block's CRS, in metres");
    NoteDefaults();
    if (!columns.unread.empty())
      all_.Note(fmt::format("{}: these columns are not read: {}", path_,
                            fmt::join(columns.unread, ", ")));
  }

 private:
  double ImageSigma() const {
    return sigma_.image.value_or(table_.Columns().InPixels() ? kPixelSigma : kPhotoSigma_mm);
  }

  // In a table of image and ground points, the column `sigma` is that of the image point.
  void AddImagePoint() {
    const std::string file = table_.Text("photo");
    ImagePointMeasurement seen;
    seen.photo = WithoutImageEnding(file.substr(file.find_last_of("/\\") + 1));
    seen.point = table_.Text("point");
    if (table_.Columns().InPixels()) {
      seen.pixel = Eigen::Vector2d{table_.Number("col"), table_.Number("row")};
      constexpr double kWidest_px = 2e5;  // scan
      if (table_.Columns().perhaps_mm &&
          (seen.pixel->minCoeff() < 0 || seen.pixel->maxCoeff() > kWidest_px))
        table_.Fail("col",
                    "x, y are no pixels of a scan; name the columns x_mm, y_mm where they are "
                    "millimetres of the photo system, and add z where they are on the ground");
    } else {
      seen.photo_mm = Eigen::Vector2d{table_.Number("x_mm"), table_.Number("y_mm")};
    }
    const auto given = table_.Sigma("sigma");
    image_defaults_ += given ? 0 : 1;
    seen.sigma = given.value_or(ImageSigma());
    all_.Add(table_.Where(), seen);
  }

  double GroundSigma(const char* axis) {
    const bool of_both = table_.Columns().image_points;
    auto given = table_.Sigma(axis);
    if (!given && std::string(axis) != "sigma_z") given = table_.Sigma("sigma_xy");
    if (!given) given = table_.Sigma(of_both ? "sigma_ground" : "sigma");
    if (!given) default_of_point_ = true;
    return given.value_or(sigma_.ground_m);
  }

  void AddGroundPoint() {
    GroundPoint point;
    point.name = table_.Text("point");
    point.ground_m = {table_.Number("x"), table_.Number("y"), table_.Number("z")};
    default_of_point_ = false;
    point.sigma_m = {GroundSigma("sigma_x"), GroundSigma("sigma_y"), GroundSigma("sigma_z")};
    ground_defaults_ += default_of_point_ ? 1 : 0;
    point.role = Role();
    ++ground_points_;
    in_degrees_ =
        in_degrees_ && std::abs(point.ground_m.x()) <= 180 && std::abs(point.ground_m.y()) <= 90;
    all_.Add(table_.Where(), point);
  }

  // As in Metashape: a marker that is not enabled is not used as control.
  bool IsEnabled() const {
    const std::string enabled = Lower(table_.Text("enabled"));
    for (const char* yes : {"", "1", "true", "yes"})
      if (enabled == yes) return true;
    for (const char* no : {"0", "false", "no"})
      if (enabled == no) return false;
    table_.Fail("enabled", fmt::format("\"{}\" does not say whether the point is enabled; write "
                                       "yes or no",
                                       table_.Text("enabled")));
  }

  PointRole Role() const {
    if (!IsEnabled()) return PointRole::kCheck;
    const std::string role = Lower(table_.Text("role"));
    for (const char* name : {"", "control", "control point", "gcp", "3d gcp"})
      if (role == name) return PointRole::kControl;
    for (const char* name : {"check", "check point", "checkpoint"})
      if (role == name) return PointRole::kCheck;
    table_.Fail("role", fmt::format("\"{}\" is no role of a ground point; write control or check",
                                    table_.Text("role")));
  }

  void NoteDefaults() const {
    if (image_defaults_ > 0)
      all_.Note(fmt::format(
          "{}: image points without an accuracy, taken with one sigma of {} {} "
          "(--sigma): {}",
          path_, ImageSigma(), table_.Columns().InPixels() ? "px" : "mm", image_defaults_));
    if (ground_defaults_ > 0)
      all_.Note(
          fmt::format("{}: ground points without an accuracy, taken with one sigma of {} m "
                      "(--ground-sigma-m): {}",
                      path_, sigma_.ground_m, ground_defaults_));
  }

  std::string path_;
  MeasuredTable table_;
  MeasuredSigma sigma_;
  GatheredMeasurements& all_;
  int image_defaults_ = 0, ground_defaults_ = 0, ground_points_ = 0;
  bool default_of_point_ = false, in_degrees_ = true;
};

}  // namespace

void AddMeasuredTable(const std::string& path, const MeasuredSigma& sigma,
                      GatheredMeasurements* all) {
  TableReader(path, sigma, all).Read();
}

}  // namespace orient

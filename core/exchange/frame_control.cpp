#include "core/exchange/frame_control.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/geometry/ground_height.h"

namespace orient {
namespace {

using Block = std::vector<TextLine>;

// Codes of standard deviations may follow the coordinates of a control point, nothing else.
void RequireCodes(const TextLine& line, std::size_t first, std::size_t most) {
  if (line.Size() > first + most)
    line.Fail(
        fmt::format("a control point's coordinates are followed by {} at most; this line has "
                    "{} words",
                    most == 1 ? "one code" : "two codes", line.Size()));
  for (std::size_t i = first; i < line.Size(); ++i)
    if (!IsCode(line.Word(i, "a code")))
      line.Fail(fmt::format("\"{}\" is no code of a standard deviation (a whole number up to 999)",
                            line.Word(i, "a code")));
}

double HeightIn(const TextLine& line, std::size_t i) {
  const double height_m = line.Number(i, "Z");
  if (!CanBeGround(height_m))
    line.Fail(
        fmt::format("Z is {}, where no ground lies; a control point has its number, X, Y and "
                    "Z in metres",
                    line.Word(i, "Z")));
  return height_m;
}

void AddPoint(const TextLine& line, const std::string& name, const Eigen::Vector3d& ground_m,
              double sigma_m, GatheredMeasurements* all) {
  all->Add(line.Where(),
           GroundPoint{name, ground_m, Eigen::Vector3d::Constant(sigma_m), PointRole::kControl});
}

[[noreturn]] void FailAsAmbiguous(const TextLine& line) {
  line.Fail(fmt::format(
      "\"{}\" may be a height or the code of a standard deviation; write heights with decimals, or "
      "let a code follow them",
      line.Word(3, "Z")));
}

// "name X Y Z", codes.
void AddFull(const TextLine& line, double sigma_m, GatheredMeasurements* all) {
  if (line.Size() == 4 && IsCode(line.Word(3, "Z"))) FailAsAmbiguous(line);
  RequireCodes(line, 4, 2);
  AddPoint(line, line.Word(0, "a point"),
           {line.Number(1, "X"), line.Number(2, "Y"), HeightIn(line, 3)}, sigma_m, all);
}

// The blocks of the file, each ended by -99.
std::vector<Block> BlocksOf(const std::vector<TextLine>& lines) {
  std::vector<Block> blocks(1);
  for (const TextLine& line : lines) {
    if (IsEnd(line))
      blocks.emplace_back();
    else
      blocks.back().push_back(line);
  }
  if (!blocks.back().empty())
    lines.back().Fail(
        "the control points are not ended by -99; add that line, or the part of the file that is "
        "missing");
  while (!blocks.empty() && blocks.back().empty()) blocks.pop_back();
  if (blocks.size() > 2) {
    const auto further = std::find_if(blocks.begin() + 2, blocks.end(),
                                      [](const Block& block) { return !block.empty(); });
    further->front().Fail(
        "here a third block begins; PAT-B's control is one block of X, Y and Z, or one of X and Y "
        "and one of Z. Give the points of the others a file of their own");
  }
  return blocks;
}

// Whether the lines of a single block have X, Y and Z; otherwise they are horizontal control.
bool IsFull(const Block& block) {
  return std::any_of(block.begin(), block.end(),
                     [](const TextLine& line) { return line.Size() >= 4; });
}

struct Horizontal {
  TextLine line;
  Eigen::Vector2d ground_m;
};

// Joins the blocks of horizontal and of vertical control by their points.
class TwoBlocks {
 public:
  void AddHorizontal(const TextLine& line) {
    RequireCodes(line, 3, 1);
    const std::string& name = line.Word(0, "a point");
    const Eigen::Vector2d at{line.Number(1, "X"), line.Number(2, "Y")};
    if (!horizontal_.try_emplace(name, Horizontal{line, at}).second)
      line.Fail(fmt::format("point {} has horizontal coordinates a second time; delete one", name));
  }

  void AddVertical(const TextLine& line) {
    RequireCodes(line, 2, 1);
    const std::string& name = line.Word(0, "a point");
    if (!vertical_.try_emplace(name, HeightIn(line, 1)).second)
      line.Fail(fmt::format("point {} has a height a second time; delete one", name));
  }

  void AddTo(const std::string& path, double sigma_m, GatheredMeasurements* all) const {
    std::vector<std::string> no_height, height_only;
    for (const auto& [name, point] : horizontal_) {
      const auto height = vertical_.find(name);
      if (height == vertical_.end())
        no_height.push_back(name);
      else
        AddPoint(point.line, name, {point.ground_m.x(), point.ground_m.y(), height->second},
                 sigma_m, all);
    }
    for (const auto& [name, height] : vertical_)
      if (!horizontal_.contains(name)) height_only.push_back(name);
    NoteLeftOut(path, no_height, "without a height", all);
    NoteLeftOut(path, height_only, "with nothing but a height", all);
  }

 private:
  static void NoteLeftOut(const std::string& path, const std::vector<std::string>& names,
                          const std::string& why, GatheredMeasurements* all) {
    if (!names.empty())
      all->Note(fmt::format("{}: points {}, left out (a ground point needs X, Y and Z): {}", path,
                            why, fmt::join(names, ", ")));
  }

  std::map<std::string, Horizontal> horizontal_;
  std::map<std::string, double> vertical_;
};

}  // namespace

bool IsEnd(const TextLine& line) { return line.Word(0, "a number") == "-99"; }

bool IsCode(const std::string& word) {
  constexpr std::size_t kDigits = 3;
  return !word.empty() && word.size() <= kDigits &&
         std::all_of(word.begin(), word.end(),
                     [](unsigned char c) { return c >= '0' && c <= '9'; });
}

void AddPatbControl(const std::string& path, const std::vector<TextLine>& lines, double sigma_m,
                    GatheredMeasurements* all) {
  const std::vector<Block> blocks = BlocksOf(lines);
  if (blocks.empty()) return;
  const bool heights_follow = blocks.size() == 2;
  if (!heights_follow && IsFull(blocks[0])) {
    for (const TextLine& line : blocks[0]) AddFull(line, sigma_m, all);
    return;
  }
  TwoBlocks points;
  for (const TextLine& line : blocks[0]) points.AddHorizontal(line);
  if (heights_follow)
    for (const TextLine& line : blocks[1]) points.AddVertical(line);
  points.AddTo(path, sigma_m, all);
}

void AddBingoControl(const TextLine& line, double sigma_m, GatheredMeasurements* all) {
  constexpr std::size_t kWords = 5;
  if (line.Size() != kWords)
    line.Fail(
        fmt::format("a line CONT has a point's number, X, Y and Z behind it; this one has {} "
                    "words",
                    line.Size()));
  AddPoint(line, line.Word(1, "a point"),
           {line.Number(2, "X"), line.Number(3, "Y"), HeightIn(line, 4)}, sigma_m, all);
}

}  // namespace orient

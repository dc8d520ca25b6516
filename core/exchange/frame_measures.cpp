#include "core/exchange/frame_measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "core/base/error.h"
#include "core/exchange/frame_adjustments.h"
#include "core/exchange/frame_control.h"
#include "core/exchange/text_lines.h"

namespace orient {
namespace {

// How a program writes image coordinates.
struct Writing {
  double mm;  // of its unit
  const char* unit;
  const char* remedy;  // if the file has another unit
};
constexpr Writing kPatb = {1e-3, "micrometres",
                           "where the file has millimetres, import it with --from bingo"};
constexpr Writing kBingo = {1, "millimetres",
                            "where the file has micrometres, import it with --from patb"};
constexpr double kLargestPhoto_mm = 300;   // from the principal point: no frame is larger
constexpr double kSmallestPhoto_mm = 0.5;  // the farthest point of a file

// Photo by photo: a heading, points, -99.
class ImageCoordinates {
 public:
  ImageCoordinates(const std::string& path, const Writing& writing, const MeasuredSigma& sigma,
                   GatheredMeasurements* all)
      : path_(path), writing_(writing), sigma_(sigma), all_(*all), names_(ReadPhotoNumbers(path)) {}

  void Read(const std::vector<TextLine>& lines) {
    for (const TextLine& line : lines) {
      if (IsEnd(line))
        photo_.clear();
      else if (photo_.empty())
        ReadHeading(line);
      else
        ReadPoint(line);
    }
    if (!photo_.empty())
      lines.back().Fail("the points of photo " + photo_ +
                        " are not ended by -99; add that line, or the part of the file that is "
                        "missing");
    if (points_ > 0 && largest_mm_ < kSmallestPhoto_mm)
      throw InputError(
          fmt::format("{}: the largest image coordinate is {} {}, so small is no photo; "
                      "{}",
                      path_, largest_mm_ / writing_.mm, writing_.unit, writing_.remedy));
    if (named_ > 0)
      all_.Note(fmt::format(
          "{}: photos that have their names from the photo_numbers.txt beside: {}", path_, named_));
  }

 private:
  void ReadHeading(const TextLine& line) {
    constexpr std::size_t kMostWords = 4;
    if (line.Size() > kMostWords)
      line.Fail(
          fmt::format("here a photo begins, with a heading of one to four words (its number, "
                      "principal distance or camera, codes); this line has {}",
                      line.Size()));
    for (std::size_t i = 2; i < line.Size(); ++i)
      if (!IsCode(line.Word(i, "a code")))
        line.Fail(fmt::format(
            "here a photo begins, and \"{}\" is no code (a whole number up to 999) of its heading; "
            "where this is a point, the photo's heading is missing before it",
            line.Word(i, "a code")));
    const std::string& number = line.Word(0, "a photo's number");
    const auto name = names_.find(number);
    photo_ = name == names_.end() ? number : name->second;
    named_ += name == names_.end() ? 0 : 1;
    distance_ = line.Size() > 1 ? line.Word(1, "a principal distance") : "";
  }

  void ReadPoint(const TextLine& line) {
    const std::string begins = fmt::format(
        "; where it begins a photo, -99 is missing before it, after the points of {}", photo_);
    if (line.Size() < 3 || line.Size() > 4)
      line.Fail(
          fmt::format("a point has its number, x, y and perhaps a code; this line has {} words{}",
                      line.Size(), begins));
    if (line.Size() == 4 && !IsCode(line.Word(3, "a code")))
      line.Fail(fmt::format("\"{}\" is no code of a point (a whole number up to 999)",
                            line.Word(3, "a code")));
    if (line.Word(1, "x") == distance_)
      line.Fail(fmt::format("x is {}, like the principal distance of photo {}{}", distance_, photo_,
                            begins));
    const Eigen::Vector2d at_mm{Coordinate(line, 1, "x"), Coordinate(line, 2, "y")};
    all_.Add(line.Where(), ImagePointMeasurement{photo_, line.Word(0, "a point"), std::nullopt,
                                                 at_mm, *sigma_.image});
  }

  double Coordinate(const TextLine& line, std::size_t i, const char* name) {
    const double mm = writing_.mm * line.Number(i, name);
    if (std::abs(mm) > kLargestPhoto_mm)
      line.Fail(fmt::format("{} is {} {}, far outside a photo; {}", name, line.Word(i, name),
                            writing_.unit, writing_.remedy));
    largest_mm_ = std::max(largest_mm_, std::abs(mm));
    ++points_;
    return mm;
  }

  std::string path_;
  Writing writing_;
  MeasuredSigma sigma_;
  GatheredMeasurements& all_;
  std::map<std::string, std::string> names_;  // by number
  std::string photo_, distance_;              // of the present photo, as in the file
  double largest_mm_ = 0;
  int points_ = 0, named_ = 0;
};

// Whether the line could be a heading; with more than two words it could be a control point, too.
bool CouldBeHeading(const TextLine& line) {
  for (std::size_t i = 2; i < line.Size(); ++i)
    if (!IsCode(line.Word(i, "a code"))) return false;
  return line.Size() <= 4;
}

enum class PatbFile { kImageCoordinates, kControl };

PatbFile KindOf(const std::string& path, const std::vector<TextLine>& lines) {
  const TextLine& first = lines.front();
  if (IsEnd(first)) return PatbFile::kControl;  // no horizontal points
  if (first.Size() <= 2) return PatbFile::kImageCoordinates;
  if (!CouldBeHeading(first)) return PatbFile::kControl;
  if (lines.size() > 1 && !IsEnd(lines[1]) && !CouldBeHeading(lines[1]))
    return PatbFile::kImageCoordinates;
  const std::string ending = std::filesystem::path(path).extension().string();
  if (ending == ".im") return PatbFile::kImageCoordinates;
  if (ending == ".con") return PatbFile::kControl;
  first.Fail(
      "this may begin a photo's image coordinates or a block of control; give the file the ending "
      ".im (image coordinates) or .con (control)");
}

std::vector<TextLine> LinesOf(const std::string& path) {
  std::vector<TextLine> lines = ReadTextLines(path);
  if (lines.empty())
    throw InputError(path + " is empty; it must hold image coordinates or control");
  return lines;
}

}  // namespace

void AddPatbMeasures(const std::string& path, const MeasuredSigma& sigma,
                     GatheredMeasurements* all) {
  const std::vector<TextLine> lines = LinesOf(path);
  if (KindOf(path, lines) == PatbFile::kControl)
    AddPatbControl(path, lines, sigma.ground_m, all);
  else
    ImageCoordinates(path, kPatb, sigma, all).Read(lines);
}

void AddBingoMeasures(const std::string& path, const MeasuredSigma& sigma,
                      GatheredMeasurements* all) {
  std::vector<TextLine> others;
  for (const TextLine& line : LinesOf(path)) {
    if (line.Word(0, "a record") == "CONT")
      AddBingoControl(line, sigma.ground_m, all);
    else
      others.push_back(line);
  }
  if (!others.empty()) ImageCoordinates(path, kBingo, sigma, all).Read(others);
}

}  // namespace orient

// Whether another program's files say what Orient meant: their verification points, projected by
// the program's own formulas. Files that Orient did not write are compared with their own points.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/convert/program_formulas.h"

namespace orient {

// How far a reading of the files is from the verification points, px.
struct ReadingFit {
  Reading reading;
  double rms_px = 0, largest_px = 0;
  double median_px = 0;  // of measured points, which have residuals and gross errors
};

struct ExportCheck {
  ExchangeFormat format = ExchangeFormat::kOpk;
  std::string directory;
  std::size_t points = 0;
  bool measured = false;  // the points are the files' own, where their images saw them
  std::vector<std::string> off, unchecked;  // images whose measured points do not fit; without any
  ReadingFit declared;                      // infinite where the program sees no point at all
  std::optional<ReadingFit> fits;  // another reading that does fit, where the declared one does not
  bool ok = false;
};

// Up to here a difference is rounding or the ground system's curvature.
inline constexpr double kFits_px = 0.1, kAlmost_px = 0.5;
// The median residual that an adjustment of image measurements may leave in an image.
inline constexpr double kMeasuredFits_px = 2;

// Checks the files of `directory`; `format` empty: the one of its export.json. `points`:
// verification points, empty: the folder's verification.csv, or else the files' own points. Throws
// InputError where there are none.
ExportCheck CheckExport(const std::string& directory, std::optional<ExchangeFormat> format,
                        const std::string& points);

// Folders with export files: `directory` itself or those directly below it.
std::vector<std::string> ExportFolders(const std::string& directory);

// One line for a person.
std::string Verdict(const ExportCheck& check);

}  // namespace orient

// What the user states about a scan; what is empty is determined.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/geometry/transform2d.h"
#include "interior/locators/mark_search.h"

namespace orient::interior {

// What the scanner does to the film: next to nothing, or scales that differ by up to 2.5 % and
// bends of a tenth of a millimetre (desktop scanners, contact prints).
enum class Scanner { kPhotogrammetric, kDesktop };

// How candidates are assigned to marks: the exact search of assignment.h, or the published local
// method (softassign.h), whose answer stands only where no other set is as probable.
enum class AssignmentMethod { kExact, kSoftassign };

// A mark that a person has clicked on this scan.
struct MarkClick {
  std::string mark;  // its id in the camera file
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma_px = 1;  // of each coordinate
  bool exact = false;   // the click is the measurement; nothing is measured around it
};

struct InteriorOptions {
  std::optional<double> pixel_size_um;  // empty: the tag, else from the marks (JudgePixelSize)
  std::optional<Polarity> polarity;     // empty: determined
  std::optional<ScanOrientation> orientation;     // empty: determined or left open
  std::optional<Scanner> scanner = std::nullopt;  // empty: determined
  // Empty: by the drawing's kind (UsualLocator).
  std::optional<LocatorKind> locator = std::nullopt;
  AssignmentMethod assignment = AssignmentMethod::kExact;
  std::vector<MarkClick> clicks = {};  // at most one a mark, of marks that the camera has
};

}  // namespace orient::interior

// A search for one mark in a window of the scan: what is asked for, what comes out, and the
// interface that every locator implements.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "interior/locators/scan_windows.h"
#include "interior/marks/mark_drawing.h"

namespace orient::interior {

enum class LocatorKind { kHough, kNcc, kLines };

struct MarkCandidate {
  // Scan; hough and ncc are accurate to about a third of a coarse px, lines to a fraction of a px.
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double ncc = 0;  // with the locator's template; positive also for a negative's dark mark
};

struct MarkCandidates {
  std::vector<MarkCandidate> bright;  // strokes brighter than what is around them: a positive
  std::vector<MarkCandidate> dark;    // a negative
  double searched_mm2 = 0;
  double coarse_pixel_mm = 0;  // pixel size at which was searched
};

struct MarkSearch {
  PixelWindow window;             // where the mark's centre may lie; its arms may lie outside
  Eigen::Matrix2d pixel_from_mm;  // linear part of scan pixel from photo mm, unturned
  int max_count = 20;             // candidates of either polarity
  double min_ncc = 0.25;     // below it the drawing is not recognised, and counts only feed clutter
  bool interpolate = false;  // thin strokes: takes four times as long
  std::vector<double> turns_rad = {-0.07, 0.0, 0.07};  // the film's rotation on the scanner
};

class Locator {
 public:
  virtual ~Locator() = default;
  // Candidates, best first. May be called from several threads. `shape` must outlive the locator,
  // which keeps what it rendered of it.
  virtual MarkCandidates Find(ScanWindows& scan, const MarkShape& shape,
                              const MarkSearch& search) const = 0;
};

}  // namespace orient::interior

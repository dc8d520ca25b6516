// Where in a search window a mark may lie. Three systems of the literature behind one interface:
// hough (Kersten & Haering), ncc (Lue; Karabork et al.) and lines (Jiang et al.).
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

#include "interior/mark_drawing.h"
#include "interior/scan_windows.h"

namespace orient {

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
  double min_ncc = 0.25;  // below it the drawing is not recognised, and counts only feed clutter
  std::vector<double> turns_rad = {-0.07, 0.0, 0.07};  // the film's turn on the scanner
};

class Locator {
 public:
  virtual ~Locator() = default;
  // Candidates, best first. May be called from several threads. `shape` must outlive the locator,
  // which keeps what it rendered of it.
  virtual MarkCandidates Find(ScanWindows& scan, const MarkShape& shape,
                              const MarkSearch& search) const = 0;
};

std::unique_ptr<Locator> MakeLocator(LocatorKind kind);

// The locator that suits a drawing where the user names none: `lines` for a cross without anything
// else that lies in the picture itself, where clutter correlates as well as the mark does; `ncc`
// for all other drawings and for pictures of marks.
LocatorKind UsualLocator(const MarkShape& shape);

// `wanted` where the drawing allows it: a picture has no strokes for `hough`, one whose strokes are
// partly dark no skeleton brighter than its neighbourhood, a drawing without a cross no lines.
// There `ncc` takes their place.
LocatorKind LocatorFor(const MarkShape& shape, std::optional<LocatorKind> wanted);

// Log-likelihood ratios of a mark against clutter for the candidates of one window, nats. What is
// clutter's usual coefficient is seen from the candidates themselves: a dot resembles much, a ring
// with a cross nothing.
std::vector<double> ScoreNats(const std::vector<MarkCandidate>& candidates);

}  // namespace orient

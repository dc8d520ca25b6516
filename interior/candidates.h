// Where in a search window a mark may lie: places where the rendered drawing correlates with the
// scan, slightly turned film included.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/imaging/raster.h"
#include "interior/mark_drawing.h"

namespace orient {

struct MarkCandidate {
  Eigen::Vector2d pixel =
      Eigen::Vector2d::Zero();  // scan, accurate to about a third of a coarse px
  double ncc = 0;               // positive also for a negative's dark mark
};

struct MarkCandidates {
  std::vector<MarkCandidate> bright;  // strokes brighter than what is around them: a positive
  std::vector<MarkCandidate> dark;    // a negative
  double searched_mm2 = 0;
  double coarse_pixel_mm = 0;  // pixel size at which was searched
};

struct MarkSearchOptions {
  int max_count = 20;
  double min_ncc = 0.25;  // below it the drawing is not recognised, and counts only feed clutter
  std::vector<double> turns_rad = {-0.07, 0.0, 0.07};  // the film's turn on the scanner
};

// `pixel_from_mm`: linear part of scan pixel from photo mm, unturned. The window is read once,
// area-averaged to what the drawing needs; slow brightness is taken away before correlating, so
// that the dark corner's edge does not outshine a faint mark.
MarkCandidates FindMarkCandidates(const Raster& scan, const PixelWindow& window,
                                  const MarkShape& shape, const Eigen::Matrix2d& pixel_from_mm,
                                  const MarkSearchOptions& options = {});

// Log-likelihood ratios of a mark against clutter for the candidates of one window, nats. What is
// clutter's usual coefficient is seen from the candidates themselves: a dot resembles much, a ring
// with a cross nothing.
std::vector<double> ScoreNats(const std::vector<MarkCandidate>& candidates);

}  // namespace orient

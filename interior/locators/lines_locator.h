// Thin crosses that lie in the picture itself (Jiang, Zhang & Li; P31): line templates along both
// arms over the search range, a parabola across the profile, a Hough transform, straight lines by
// least squares, and their intersections.
#pragma once

#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "interior/locators/mark_search.h"

namespace orient::interior {

// The drawing's longest cross; null where it has none.
const CrossElement* CrossOf(const MarkShape& shape);

// Dark and bright lines alike. Crosses at other angles than the scan's axes are searched in a
// window turned by the drawing's angle. Every crossing of two perpendicular lines of one polarity
// is a candidate for the cross's middle, dark lines on a positive where the cross is drawn darker
// than what is around it; its score is the correlation with the rendered drawing. A drawing without
// a cross has no candidates.
class LinesLocator : public Locator {
 public:
  LinesLocator();
  ~LinesLocator() override;
  LinesLocator(const LinesLocator&) = delete;
  LinesLocator& operator=(const LinesLocator&) = delete;

  MarkCandidates Find(ScanWindows& scan, const MarkShape& shape,
                      const MarkSearch& search) const override;

 private:
  struct TurnedMark;
  // Drawing, size and turns.
  using Key = std::pair<const MarkShape*, std::vector<double>>;

  const std::vector<TurnedMark>& TurnsOf(const MarkShape& shape, const Eigen::Vector2d& cross_mm,
                                         const Eigen::Matrix2d& window_from_mm,
                                         const std::vector<double>& turns_rad,
                                         double blur_px) const;

  // A camera's marks mostly share one drawing: it is rendered once.
  mutable std::mutex mutex_;
  mutable std::map<Key, std::vector<TurnedMark>> made_;
};

}  // namespace orient::interior

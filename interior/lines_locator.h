// Thin crosses that lie in the picture itself (Jiang, Zhang & Li; P31): line templates along both
// arms over the search range, a parabola across the profile, a Hough transform, straight lines by
// least squares, and their intersections.
#pragma once

#include "interior/locator.h"

namespace orient {

// The drawing's longest cross; null where it has none.
const CrossElement* CrossOf(const MarkShape& shape);

// Dark and bright lines alike. Crosses at other angles than the scan's axes are searched in a
// window turned by the drawing's angle. Every crossing of two perpendicular lines of one polarity
// is a candidate; its score is the correlation with the rendered drawing. A drawing without a cross
// has no candidates.
class LinesLocator : public Locator {
 public:
  MarkCandidates Find(ScanWindows& scan, const MarkShape& shape,
                      const MarkSearch& search) const override;
};

}  // namespace orient

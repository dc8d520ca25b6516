// Modified Hough transform (Kersten & Haering 1997): the mark's skeleton minus its neighbourhood.
//
// The paper sums the grey values under vectors from the centre to every point of the skeleton, and
// subtracts the sum under those to the neighbourhood, a line about two pixels outside of the mark.
// The difference of the two means is a correlation with a kernel of two levels; divided by the grey
// values' spread over both point sets it is, but for a constant factor, the masked correlation
// coefficient of a binary template: it no longer grows with contrast, and finds faint marks beside
// bright clutter.
#pragma once

#include "interior/locators/template_search.h"

namespace orient::interior {

class HoughLocator : public Locator {
 public:
  // A mark with a picture has no strokes: nothing is found.
  MarkCandidates Find(ScanWindows& scan, const MarkShape& shape,
                      const MarkSearch& search) const override;

 private:
  TemplateSearch search_{false};
};

// 1 on the strokes' middle lines, 0 on the neighbourhood, NaN elsewhere; middle lines and
// neighbourhood are one pixel wide. `pixel_from_mm` as for RenderMark.
MarkTemplate SkeletonTemplate(const MarkShape& shape, const Eigen::Matrix2d& pixel_from_mm);

}  // namespace orient::interior

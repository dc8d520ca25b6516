#include "interior/locators/ncc_locator.h"

#include <Eigen/LU>
#include <cmath>

#include "interior/locators/template_search.h"

namespace orient::interior {

MarkCandidates NccLocator::Find(ScanWindows& scan, const MarkShape& shape,
                                const MarkSearch& search) const {
  return search_.Find(scan, shape, search, [&](const Eigen::Matrix2d& pixel_from_mm) {
    RenderOptions render;
    render.background_sigma_px =
        kBackgroundSigmaMm * std::sqrt(std::abs(pixel_from_mm.determinant()));
    return RenderMark(shape, pixel_from_mm, render);
  });
}

}  // namespace orient::interior

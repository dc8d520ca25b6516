// Masked correlation over a search window, coarse to fine: what hough and ncc share.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "core/matching/spot_correlation.h"
#include "interior/locators/mark_search.h"

namespace orient::interior {

// The mark as a template at one size and rotation.
using TemplateMaker = std::function<MarkTemplate(const Eigen::Matrix2d& pixel_from_mm)>;

// The window is read once, area-averaged to about 32 pixels over the mark; slow brightness is taken
// away, so that a dark corner's edge does not outshine a faint mark. Half that resolution is
// correlated everywhere, the best places of either polarity are looked at again with all turns.
class TemplateSearch {
 public:
  // `drawn`: templates show the mark as a scan does, so that a faint one can be scored without
  // grain.
  explicit TemplateSearch(bool drawn) : drawn_(drawn) {}

  MarkCandidates Find(ScanWindows& scan, const MarkShape& shape, const MarkSearch& search,
                      const TemplateMaker& make) const;

 private:
  struct Templates {
    double reduction = 1;             // scan pixels per pixel of `turns`
    std::vector<MarkTemplate> turns;  // as the search names them
    std::vector<SpotTemplate> spots;  // the same
    std::vector<MarkTemplate> half;   // upright, at half the resolution; empty: no such step
  };
  // Drawing, size and turns.
  using Key = std::pair<const MarkShape*, std::vector<double>>;

  const Templates& TemplatesFor(const MarkShape& shape, const MarkSearch& search,
                                const TemplateMaker& make) const;

  bool drawn_;
  // A camera's marks mostly share one drawing: it is rendered once.
  mutable std::mutex mutex_;
  mutable std::map<Key, Templates> made_;
};

// The part of the window and what the mark's arms need around it.
PixelWindow Grow(const PixelWindow& window, int by);

}  // namespace orient::interior

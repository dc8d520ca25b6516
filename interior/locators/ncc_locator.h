// Normalised cross-correlation with the rendered drawing or a picture of the mark (Lue 1995;
// Karabork, Yildiz & Yakar 2004), in several small turns of the film.
#pragma once

#include "interior/locators/template_search.h"

namespace orient::interior {

class NccLocator : public Locator {
 public:
  MarkCandidates Find(ScanWindows& scan, const MarkShape& shape,
                      const MarkSearch& search) const override;

 private:
  TemplateSearch search_{true};
};

}  // namespace orient::interior

// Where in a search window a mark may lie. Three systems of the literature behind one interface:
// hough (Kersten & Haering), ncc (Lue; Karabork et al.) and lines (Jiang et al.).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "interior/locators/mark_search.h"

namespace orient::interior {

std::unique_ptr<Locator> MakeLocator(LocatorKind kind);

// The locator that suits a drawing where the user names none: `lines` for a cross without anything
// else that lies in the picture itself, where clutter correlates as well as the mark does; `ncc`
// for all other drawings and for pictures of marks.
LocatorKind UsualLocator(const MarkShape& shape);

// `wanted` where the drawing allows it: a picture has no strokes for `hough`, one whose strokes are
// partly dark no skeleton brighter than its neighbourhood, a drawing without a cross no lines.
// There `ncc` takes their place.
LocatorKind LocatorFor(const MarkShape& shape, std::optional<LocatorKind> wanted);

// Log-likelihood ratios of a mark against clutter for the candidates of one window, nats. The usual
// coefficient of clutter is estimated from the candidates themselves: much clutter resembles a dot,
// none a ring with a cross.
std::vector<double> ScoreNats(const std::vector<MarkCandidate>& candidates);

}  // namespace orient::interior

#include "interior/locators/locator.h"

#include <algorithm>

#include "interior/locators/hough_locator.h"
#include "interior/locators/lines_locator.h"
#include "interior/locators/ncc_locator.h"

namespace orient::interior {

std::unique_ptr<Locator> MakeLocator(LocatorKind kind) {
  switch (kind) {
    case LocatorKind::kHough:
      return std::make_unique<HoughLocator>();
    case LocatorKind::kLines:
      return std::make_unique<LinesLocator>();
    case LocatorKind::kNcc:
      break;
  }
  return std::make_unique<NccLocator>();
}

LocatorKind UsualLocator(const MarkShape& shape) {
  if (shape.picture || shape.drawing.background != MarkBackground::kImage ||
      shape.drawing.elements.size() != 1 || CrossOf(shape) == nullptr)
    return LocatorKind::kNcc;
  return LocatorKind::kLines;
}

LocatorKind LocatorFor(const MarkShape& shape, std::optional<LocatorKind> wanted) {
  const LocatorKind kind = wanted.value_or(UsualLocator(shape));
  const auto& elements = shape.drawing.elements;
  const bool all_bright = std::all_of(elements.begin(), elements.end(),
                                      [](const auto& e) { return BrightnessOf(e) > 0; });
  if (kind == LocatorKind::kHough && (shape.picture || !all_bright)) return LocatorKind::kNcc;
  if (kind == LocatorKind::kLines && CrossOf(shape) == nullptr) return LocatorKind::kNcc;
  return kind;
}

std::vector<double> ScoreNats(const std::vector<MarkCandidate>& candidates) {
  // Clutter's best peaks lie below 0.6 for a drawing with some structure, clear marks above 0.7
  // (measured on scanned film frames).
  constexpr double kEven = 0.6, kAboveClutter = 0.15, kSlope = 10.0, kLimit = 1.5;
  constexpr size_t kEnough = 5;
  double even = kEven;
  if (candidates.size() >= kEnough)  // best first: the middle one is clutter
    even = std::max(even, candidates[candidates.size() / 2].ncc + kAboveClutter);
  std::vector<double> nats;
  for (const MarkCandidate& c : candidates)
    nats.push_back(std::clamp(kSlope * (c.ncc - even), -kLimit, kLimit));
  return nats;
}

}  // namespace orient::interior

#include "interior/constellation/set_evidence.h"

#include <algorithm>
#include <cmath>

namespace orient::interior {
namespace {

// That the camera's marks are there at all must be far likelier than a set of clutter that happens
// to fit: photos without marks reach 6 nats (tests, random texture).
constexpr double kMinSetNats = 9.0;
// A set's nats are odds against clutter, which the assignment's model considers unlikely, as each
// mark is found with a probability of 0.85: -log 0.15 = 1.9 for every mark, found or not. A camera
// without its marks on the scan is no such coincidence, and against it a set's odds are less by 1.9
// nats a mark: nine nats of four marks are 1.4 above it, and as much is required of any number.
constexpr double kNatsPerFurtherMark = 1.9;

}  // namespace

double MinSetNats(int all) { return kMinSetNats + kNatsPerFurtherMark * std::max(all - 4, 0); }

int NeededMarks(int all) { return std::max(4, static_cast<int>(std::ceil(0.6 * all))); }

Status JudgeSet(int all, int used, double set_nats, double margin) {
  if (used < 3 || set_nats < MinSetNats(all) || margin <= kMinMarginNats) return Status::kFailed;
  return used < NeededMarks(all) ? Status::kWeak : Status::kOk;
}

}  // namespace orient::interior

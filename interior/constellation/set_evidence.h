// How much evidence a set of marks needs to be more than chance.
#pragma once

#include "core/files/results.h"

namespace orient::interior {

// What a verdict of ok needs beyond the second-best reading, nats.
inline constexpr double kMinMarginNats = 3.0;

// Marks that a verdict of ok needs: max(4, 60 %).
int NeededMarks(int all);

// What a set of marks needs at least to be more than chance, nats: 9 for four marks (photos without
// marks reach 6), and 1.9 for every further mark of the camera, found or not.
double MinSetNats(int all);

// What geometry alone allows: failed below three marks, MinSetNats(all) or 3 nats of margin; weak
// below NeededMarks(all). Three of four marks leave nothing to test them by: however large the
// margin, chance has a part in them.
Status JudgeSet(int all, int used, double set_nats, double margin);

}  // namespace orient::interior

// MicMac's tie points: Homol/Pastis<image>/<other image>.txt, a line for each point that both show:
// x y in the first, x y in the second, a weight (ElPackHomologue; its programs read text with
// ExpTxt=1). The centre of a pixel has whole numbers: theirs = ours - 0.5.
#pragma once

#include <string>

#include "core/exchange/exchange_block.h"

namespace orient {

// Both ways of every pair of photos that share points, control included.
void WriteMicmacHomologues(const std::string& directory, const ExchangeBlock& block);

}  // namespace orient

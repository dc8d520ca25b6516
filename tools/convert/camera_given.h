// The camera that a person names for files of another program, against what those files say.
#pragma once

#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"

namespace orient {

// `of_files`: as read; what a format does not hold (image size, principal distance) is zero there
// and not compared. Throws InputError naming `input`, both values and what to do: several different
// cameras for the one given, images of another size, principal distances that differ by more than
// 5 %. What differs less is replaced, and a sentence says by how many pixels; empty: nothing to
// say.
std::string CompareWithGiven(const std::vector<ExchangeCamera>& of_files,
                             const ExchangeCamera& given, const std::string& input);

}  // namespace orient

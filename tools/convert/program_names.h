// Photos' names in the files of programs that take no blanks in them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"
#include "tools/convert/exchange_format.h"

namespace orient {

// The block's images as the format's files name them. COLMAP and ASP cut names at blanks and say
// nothing: there a blank becomes "_", and what would be another photo's name, with or without its
// ending, gets a number.
std::vector<std::string> NamesInFiles(const ExchangeBlock& block, ExchangeFormat format);

// The true names back: `true_names` are by the files' names, of those that differ. Files without
// endings get names without endings.
void RestoreNames(const std::map<std::string, std::string>& true_names, ExchangeBlock* block);

}  // namespace orient

// What a result was made from. Every result file says so in its field "made_from", which is written
// with the result and by the same rename: the two cannot get apart.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace orient {

// Name of an input ("camera", "scan", "options") -> what identifies its content: a digest
// (block/inputs/digest.h), or a short content itself.
using Inputs = std::map<std::string, std::string>;

// Names of the inputs that are not the same in both, those that only one of them has too; sorted.
std::vector<std::string> WhatChanged(const Inputs& then, const Inputs& now);

// For messages: "camera file, DEM, scan". Empty for no names.
std::string TextOfInputs(const std::vector<std::string>& names);

// From a result file of any stage. Empty if the file is absent or damaged: not an error, as such
// a result is simply recomputed. An empty map if the file does not state its inputs.
std::optional<Inputs> ReadMadeFrom(const std::string& path);

}  // namespace orient

// What an import says, as one text.
#pragma once

#include <string>

#include "core/measurements/gathered_measurements.h"

namespace orient {

// Its notes, a line each.
inline std::string NotesOf(const GatheredMeasurements& all) {
  std::string notes;
  for (const std::string& note : all.Notes()) notes += note + "\n";
  return notes;
}

}  // namespace orient

// One of the camera's marks as it was measured on a scan.
#pragma once

#include <optional>
#include <vector>

#include "core/files/results.h"
#include "interior/marks/subpixel.h"

namespace orient::interior {

struct FilmMark {
  MarkState state = MarkState::kMissing;
  std::optional<MarkPosition> position;  // absent for a missing mark
  // A bare cross whose strokes are seen along their whole length (cross_position.h).
  bool clear = false;
};
using FilmMarks = std::vector<FilmMark>;  // in the order of the camera's fiducials

}  // namespace orient::interior

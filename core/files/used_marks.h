// How many of a photo's marks its transform rests on.
#pragma once

#include "core/files/results.h"

namespace orient {

int CountUsedMarks(const InteriorResult& result);

}  // namespace orient

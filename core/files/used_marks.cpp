#include "core/files/used_marks.h"

#include <algorithm>

namespace orient {

int CountUsedMarks(const InteriorResult& result) {
  const auto used =
      std::count_if(result.marks.begin(), result.marks.end(),
                    [](const MarkResult& mark) { return mark.state == MarkState::kUsed; });
  return static_cast<int>(used);
}

}  // namespace orient

#include "core/raster/grey_range.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace orient {

std::pair<float, float> GreyRange(const Image& image) {
  std::vector<float> values;
  for (const float value : image.values)
    if (!std::isnan(value)) values.push_back(value);
  if (values.empty()) return {0.0f, 0.0f};
  const auto at = [&](size_t index) {
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(index);
    std::nth_element(values.begin(), place, values.end());
    return *place;
  };
  const size_t edge = values.size() / 100;
  const float low = at(edge);
  return {low, at(values.size() - 1 - edge)};
}

}  // namespace orient

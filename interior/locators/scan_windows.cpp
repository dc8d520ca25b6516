#include "interior/locators/scan_windows.h"

#include <algorithm>
#include <cmath>

#include "core/raster/resample.h"

namespace orient::interior {

const ImageWindow& ScanWindows::Read(const PixelWindow& w, double reduction) {
  const Key key{w.col, w.row, w.width, w.height, reduction};
  {
    const std::lock_guard lock(mutex_);
    const auto known = read_.find(key);
    if (known != read_.end()) return known->second;
  }
  // The raster has its own lock: meanwhile other threads may use windows that were read before.
  ImageWindow window = scan_.ReadGrey(w, std::max(reduction, 1.0));
  if (reduction < 1) {
    window.image = EnlargeBy(window.image, static_cast<int>(std::lround(1 / reduction)));
    window.scale *= reduction;
  }
  const std::lock_guard lock(mutex_);
  return read_.try_emplace(key, std::move(window)).first->second;
}

}  // namespace orient::interior

#include "tools/simulate/simulation_options.h"

#include <fmt/format.h>

#include <array>

namespace orient {
namespace {

struct Range {
  const char* option;
  double value, low, high;
};

// The options that are plain numbers, by the names that the command line gives them.
std::array<Range, 22> Ranges(const SimulationOptions& o) {
  return {{{"--photos", static_cast<double>(o.photos), 1, 1000},
           {"--strips", static_cast<double>(o.strips), 1, 100},
           {"--gsd-m", o.gsd_m, 0.02, 20},
           {"--forward-overlap", o.forward_overlap, 0, 0.95},
           {"--side-overlap", o.side_overlap, 0, 0.95},
           {"--tilt-deg", o.tilt_deg, 0, 5},
           {"--relief-m", o.relief_m, 0, 5000},
           {"--dem-cell-m", o.dem_cell_m, 0.5, 200},
           {"--change", o.change, 0, 1},
           {"--pixel-size-um", o.pixel_size_um.value_or(25), 4, 500},
           {"--scan-rotation-deg", o.scan_rotation_deg, 0, 5},
           {"--film-shrink-ppm", o.film_shrink_ppm, 0, 5000},
           {"--film-bend-um", o.film_bend_um, 0, 100},
           {"--grain", o.grain, 0, 60},
           {"--blur-px", o.blur_px, 0, 10},
           {"--missing-marks", static_cast<double>(o.missing_marks), 0, 8},
           {"--dirty-marks", static_cast<double>(o.dirty_marks), 0, 8},
           {"--old-gsd-ratio", o.old_gsd_ratio, 0.2, 5},
           {"--old-height-ratio", o.old_height_ratio, 0.5, 4},
           {"--position-error-m", o.position_error_m, 0, 10000},
           {"--attitude-error-deg", o.attitude_error_deg, 0, 20},
           {"--kappa", o.kappa_deg, -360, 360}}};
}

std::string Plain(double number) {
  std::string text = std::to_string(number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

std::optional<std::string> SimulationOptions::Check() const {
  for (const Range& range : Ranges(*this))
    if (!(range.value >= range.low && range.value <= range.high))
      return fmt::format("{} {}: must lie between {} and {}", range.option, Plain(range.value),
                         Plain(range.low), Plain(range.high));
  if (strips > photos) return fmt::format("--strips {}: more than --photos", strips);
  if (bits != 8 && bits != 16) return fmt::format("--bits {}: must be 8 or 16", bits);
  if (camera == CameraPreset::kDigital &&
      (orientation != ScanOrientation::kR0 || polarity != Polarity::kPositive))
    return "--camera-preset digital: a digital frame is positive and upright; leave out "
           "--polarity and --scan-orientation";
  return std::nullopt;
}

}  // namespace orient

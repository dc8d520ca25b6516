// The measurements in the files of an import, gathered: no duplicates, and nothing is dropped
// silently. Private to core/exchange, except for what `orient measurements` writes of it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/measurements/measurements.h"

namespace orient {

// Standard deviations for measurements whose file states none.
struct MeasuredSigma {
  // Pixels; mm for PAT-B, BINGO and tables in mm. Only tables can do without: 1 pixel, 0.01 mm.
  std::optional<double> image = {};
  double ground_m = 0.05;
};

class GatheredMeasurements {
 public:
  // `where` is "<file>, line <n>". The same once more is taken once. Throws InputError naming both
  // places where a photo's point (a point's ground position) is given with two values, where some
  // image points are in pixels and some in mm, for an empty name, one with a line break, and
  // where a sigma can be none (SigmaProblem).
  void Add(const std::string& where, const ImagePointMeasurement& seen);
  void Add(const std::string& where, const GroundPoint& point);
  // A sentence on what was left out or assumed.
  void Note(std::string sentence) { notes_.push_back(std::move(sentence)); }

  const Measurements& All() const { return all_; }
  const std::vector<std::string>& Notes() const { return notes_; }
  // How many points were added, those said a second time among them.
  std::size_t Found() const { return found_; }

 private:
  struct Place {
    std::size_t index = 0;
    std::string where;
  };

  Measurements all_;
  std::map<std::string, Place> image_points_, points_;  // by what they are called
  std::vector<std::string> notes_;
  std::size_t found_ = 0;
};

}  // namespace orient

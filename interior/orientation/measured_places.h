// Marks of one scan that are measured already: where the film is found to lie otherwise, its marks
// get other names, but most lie where they were measured before.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "interior/marks/mark_drawing.h"
#include "interior/orientation/film_mark.h"

namespace orient::interior {

// All that a measurement depends on.
struct MeasuringPlace {
  const MarkShape* shape = nullptr;
  Eigen::Matrix2d pixel_from_mm;  // of the drawing
  Eigen::Vector2d start;          // pixels
  Polarity polarity = Polarity::kPositive;
};

class MeasuredPlaces {
 public:
  // What was measured from there with this drawing, or with one that is turned into itself. Null
  // where nothing was. `shape` must still live.
  const FilmMark* Find(const MeasuringPlace& place) const;
  void Add(const MeasuringPlace& place, const FilmMark& measured);

 private:
  struct Measured {
    MeasuringPlace place;
    FilmMark mark;
  };
  // Whether the drawing looks the same under both transforms.
  bool SameDrawing(const MarkShape& shape, const Eigen::Matrix2d& a,
                   const Eigen::Matrix2d& b) const;

  std::vector<Measured> measured_;
  // Whether a drawing is turned into itself, determined once; by the turn's numbers.
  using Turned = std::pair<const MarkShape*, std::array<double, 4>>;
  mutable std::map<Turned, bool> symmetric_;
};

}  // namespace orient::interior

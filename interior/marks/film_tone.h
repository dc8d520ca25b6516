// Grey values of a scan as tones of the positive: 0 what surrounds a mark, 1 its strokes.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/files/results.h"
#include "core/raster/raster.h"
#include "interior/marks/mark_drawing.h"

namespace orient::interior {

struct FilmTone {
  double surrounding = 0;  // grey value
  double stroke = 1;       // grey value of a stroke without blur; the smaller one on a negative

  double Of(double grey) const { return (grey - surrounding) / (stroke - surrounding); }
};

// The two grey values at a measured mark, by regression on its drawing. Empty where the scan does
// not reach around the mark or the strokes do not stand out in the way `polarity` says.
std::optional<FilmTone> ToneAtMark(const Raster& scan, const MarkShape& shape,
                                   const Eigen::Matrix2d& pixel_from_mm,
                                   const Eigen::Vector2d& pixel, Polarity polarity);

// Part of the film in tones, on a square grid of the photo system: the pixel (i + 0.5, j + 0.5)
// shows the place low_mm + step_mm * (i + 0.5, j + 0.5). NaN beyond the scan.
struct TonePicture {
  Image tone;
  Eigen::Vector2d low_mm = Eigen::Vector2d::Zero();
  double step_mm = 0.05;

  // Bilinear; NaN outside.
  float At(const Eigen::Vector2d& photo_mm) const;
};

// What lies between two corners (least and largest x and y). Averaged over the grid's step.
TonePicture ReadTones(const Raster& scan, const Affine2d& pixel_from_photo, const FilmTone& tone,
                      const Eigen::Vector2d& low_mm, const Eigen::Vector2d& high_mm,
                      double step_mm);

}  // namespace orient::interior

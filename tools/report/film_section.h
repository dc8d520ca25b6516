// The report's parts about camera, flight and film.
#pragma once

#include <optional>
#include <vector>

#include "tools/report/block_record.h"
#include "tools/report/figures/film_figures.h"
#include "tools/report/template.h"

namespace orient {

// The camera, and at what scale, pixel size on the ground and height it saw the ground. Empty where
// the folder has no block_camera.toml.
Markup CameraSection(const BlockRecord& block);

// Of one photo; empty without pose, footprint or pixel size.
struct SeenScale {
  double height_m = 0;  // of the projection centre above the footprint's mean height
  double scale = 0;     // 1 : scale
  double gsd_m = 0;     // of a pixel of the scan on level ground
};
std::optional<SeenScale> ScaleOf(const PhotoRecord& photo, const Camera& camera);

std::vector<FilmRoll> FilmRollsOf(const BlockRecord& block);

// How the film lies against its calibrated marks, in a table for each camera and pixel size. Empty
// without film.
Markup FilmSection(const BlockRecord& block);

}  // namespace orient

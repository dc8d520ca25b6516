// What a film carries beside the picture: the dark rebate with fiducial marks and the data strip.
#pragma once

#include <cstdint>
#include <vector>

#include "core/files/camera_file.h"
#include "core/raster/image.h"
#include "tools/simulate/scan_geometry.h"

namespace orient::simulation {

// kDirty: a hair and a blot between the strokes; kScratched: bright and dark scratches right
// across; kDusty: specks over strokes and surroundings; kArmLost: a quarter of the mark was not
// exposed.
enum class MarkCondition { kClean, kDirty, kScratched, kDusty, kArmLost, kMissing };

struct FilmFrame {
  CameraFile camera;
  double film_half_mm = 0;                // the film's edge, from the frame's centre
  std::vector<MarkCondition> conditions;  // one a fiducial
  bool data_strip = true;                 // text beside the frame, on the photo's left side
  float mark_tone = 0.92f;                // of marks, symbols and text's brightest; 0.06 is rebate
  std::uint32_t seed = 1;
};

// Distance of a mark drawing's outermost part from its centre, mm.
double MarkRadius(const MarkDrawing& drawing);

// Brightness of a place of the mark's drawing (-1 to 1, 0: what surrounds the mark); `at_mm`
// relative to the mark, photo axes.
double MarkBrightness(const MarkDrawing& drawing, const Eigen::Vector2d& at_mm);
// Whether a place is part of the identification symbol.
bool InSymbol(const MarkSymbol& symbol, const Eigen::Vector2d& at_mm);

// Turns the scene's tones into the positive (0 black, 1 white), draws the film around them and
// blurs both (a Gaussian of sigma `blur_px`): marks before the scan's pixels average, as a
// scanner's optics do, and what is one value per pixel already, the picture and the rebate,
// afterwards. `image` shows the scan from its pixel `origin` on; by default all of it.
void DrawFilm(const FilmFrame& film, const ScanGeometry& scan, double blur_px, Image* image,
              const Eigen::Vector2i& origin = Eigen::Vector2i::Zero());

}  // namespace orient::simulation

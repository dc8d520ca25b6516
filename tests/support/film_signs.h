// Signs on a film, besides its marks, that reveal the scan orientation: identification symbols, the
// data strip, and border features of the camera file. Drawn by sampling the definitions.
#pragma once

#include "core/files/camera_file.h"
#include "core/geometry/transform2d.h"
#include "core/raster/image.h"

namespace orient {

struct SignBrightness {
  double dark = 18, bright = 210;  // grey values
};

// Where symbols without a stated position are drawn: first element, and the step to the next.
inline const Eigen::Vector2d kSymbolAt_mm(2.6, 0.4);
inline const Eigen::Vector2d kSymbolStep_mm(0.5, 0);

// Draws the symbols of all fiducials except those in `missing`.
void DrawSymbols(const CameraFile& camera, const Affine2d& pixel_from_photo,
                 const SignBrightness& brightness, const std::vector<int>& missing, Image* scan);

// Draws text over the middle two thirds of the data strip's side, and the border features.
void DrawBorder(const CameraFile& camera, const Affine2d& pixel_from_photo,
                const SignBrightness& brightness, Image* scan);

}  // namespace orient

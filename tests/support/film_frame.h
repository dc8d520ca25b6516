// Scans of film frames with known truth: texture, dark rebate and corners, fiducial marks, grain.
// The marks are drawn by sampling their definition directly, independently of
// interior/marks/mark_drawing; symbols, data strip and border as defined by the camera file
// (film_signs.h).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/geometry/transform2d.h"
#include "core/raster/image.h"

namespace orient {

struct FilmFrameSpec {
  CameraFile camera;
  double pixel_mm = 0.1;
  double rebate_mm = 6;  // black film around the exposed frame
  ScanOrientation orientation = ScanOrientation::kR0;
  Polarity polarity = Polarity::kPositive;
  double turn_rad = 0;  // rotation of the film on the scanner, in addition to the orientation
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();  // of the scanner's columns and rows
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double blur_sigma_px = 0.7;
  double noise = 4;  // one sigma, grey values of 255
  double mark_brightness = 210;
  std::vector<int> missing;  // indices of fiducials that are not on the film
  bool marks = true;
  bool dark_corners = true;  // under the marks; false: the marks are in the picture
  unsigned seed = 1;
};

struct FilmFrame {
  Image scan;                                // 0..255
  Affine2d pixel_from_photo;                 // truth
  std::vector<Eigen::Vector2d> mark_pixels;  // truth, in the order of the camera's fiducials
};

FilmFrame RenderFilmFrame(const FilmFrameSpec& spec);

// Photo texture only: fields, roads, grain at all sizes; no rebate, no marks.
Image RenderTexture(int width, int height, unsigned seed);

// 8-bit grey PNG.
void WriteScan(const std::string& path, const Image& scan);

// A square 23 cm camera with ring-and-cross corner marks at +-106 mm, like a Wild RC10; with
// smaller arguments, e.g. a 6 cm camera with the same marks that is quick to render.
CameraFile RingCamera(double mark_mm = 106, double frame_mm = 230);

}  // namespace orient

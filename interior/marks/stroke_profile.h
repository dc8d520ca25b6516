// A straight stroke of a mark as it lies in the scan, and the profiles across it (Jiang, Zhang &
// Li: a parabola across the profile).
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "core/files/camera_file.h"
#include "core/raster/image.h"

namespace orient::interior {

// One stroke of a cross. `steep`: rows and columns are exchanged, so that
// every stroke is y = offset + slope * x, with x and y from the cross's predicted centre.
struct Stroke {
  bool steep = false;
  double offset = 0, slope = 0;
  double from_px = 0, to_px = 0;  // along x: where the arms begin and end, both sides of the centre
  double smoothing_px = 1;        // along y
  double half_width_px = 0.5;     // along y
  double side_response = 0;       // g1 where one side is brighter by 1 than the other
};

// The top of one profile, from the line.
struct Profile {
  double g1 = 0, g2 = 0;
  double side_effect = 0;  // on g1, of the two sides' different brightness
  double weight = 1;
  bool seen = false;
};

// An image, or its transpose.
class Plane {
 public:
  Plane(const Image& image, bool transposed) : image_(image), transposed_(transposed) {}
  double At(int x, int y) const {
    if (transposed_) std::swap(x, y);
    if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return std::nan("");
    return static_cast<double>(image_.At(x, y));
  }

 private:
  const Image& image_;
  bool transposed_;
};

// `angle_rad`: counter-clockwise from the photo's +x axis; `blur_px`: of the profiles besides the
// stroke's own width.
Stroke StrokeOf(const CrossElement& cross, double angle_rad, const Eigen::Matrix2d& pixel_from_mm,
                double blur_px);

// Derivatives of the smoothed profile down column x at height y (corner convention), without what
// the unlike sides of the stroke do to them.
Profile ProfileAt(const Plane& plane, int x, double y, const Stroke& stroke);

// A stroke narrower than two pixels or so is undersampled: its top moves with its place in the
// pixel, as the sine of it, by the amplitude given here, px. That of sharp optics; what softer ones
// blur before the pixels average leaves less, how much less is not seen.
double AliasingOf(const Stroke& stroke);

}  // namespace orient::interior

// One oriented photo as a source of orthophotos.
#pragma once

#include <optional>
#include <string>

#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "exterior/steps/photo_image.h"

namespace orient::block {

struct QuicklookPhoto {
  std::string name, path;
  PhotoView view;  // final pose
  bool negative = false;
};

// North up; (west, north) is the outer corner of the first pixel.
struct GroundGrid {
  double west_m = 0, north_m = 0, gsd_m = 1;
  int width = 0, height = 0;

  Eigen::Vector2d At(double col, double row) const {
    return {west_m + gsd_m * col, north_m - gsd_m * row};
  }
};

// To one mean and contrast, around 128: photos of one block differ.
void Standardise(Image* image);

class OrthoPhoto {
 public:
  // Throws InputError where the photo cannot be opened. Refers to `photo`.
  explicit OrthoPhoto(const QuicklookPhoto& photo);

  const std::string& Name() const { return photo_.name; }

  // Ground metres a pixel at the middle of the frame.
  double Gsd(double height_m) const;

  // The scan pixel of a ground point inside the frame, its distance from the frame's middle (in
  // half frames) and how near the border it is (0 in the middle, 1 on the border).
  struct Seen {
    Eigen::Vector2d pixel;
    double off_middle = 0, to_border = 0;
  };
  std::optional<Seen> See(const Eigen::Vector3d& ground_m) const;

  ImageWindow Whole(int reduction) const;  // throws InputError where the photo is damaged

  // The orthophoto over a small grid at the photo's full resolution, standardised. NaN where the
  // photo or the surface shows nothing, or the photo is damaged.
  Image Draw(const GroundGrid& grid, const GroundSurface& surface) const;

 private:
  const QuicklookPhoto& photo_;
  Raster raster_;
  exterior::PhotoImage image_;
};

}  // namespace orient::block

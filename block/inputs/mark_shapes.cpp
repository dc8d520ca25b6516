#include "block/inputs/mark_shapes.h"

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/raster/raster.h"
#include "interior/interior.h"

namespace orient::block {
namespace {

// Refuses a whole scan in place of a cut-out mark: reading and searching it would be in vain.
Image LoadPicture(const std::string& mark, const MarkImage& image) {
  constexpr double kLargest_mm = 20;
  const Raster raster = Raster::Open(image.path);
  const double side_mm = std::max(raster.Width(), raster.Height()) * image.pixel_size_mm;
  if (side_mm > kLargest_mm)
    throw InputError(image.path + ": the picture of mark " + mark + " is " + Fixed(side_mm, 1) +
                     " mm wide; cut the mark out, or correct pixel_size_mm");
  const Eigen::Vector2d& centre = image.centre_px;
  if (centre.minCoeff() < 0 || centre.x() > raster.Width() || centre.y() > raster.Height())
    throw InputError(image.path + ": the centre_px of mark " + mark + " lies outside its picture");
  return raster.ReadGrey().image;
}

}  // namespace

interior::MarkShapes LoadMarkShapes(const CameraFile& camera) {
  std::map<std::string, Image> pictures;
  for (const auto& [name, drawing] : camera.marks)
    if (drawing.image) pictures[name] = LoadPicture(name, *drawing.image);
  return interior::ShapesOf(camera, pictures);
}

}  // namespace orient::block

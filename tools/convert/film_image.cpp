#include "tools/convert/film_image.h"

#include <fmt/format.h>

#include "block/inputs/mark_shapes.h"
#include "block/inputs/photo_interior.h"
#include "core/base/error.h"
#include "core/files/results.h"
#include "core/geometry/lens.h"
#include "interior/interior.h"

namespace orient {

FilmImage::FilmImage(const CameraFile& camera, const std::string& photo,
                     const std::string& interior_directory,
                     std::optional<ScanOrientation> orientation, const Camera& image,
                     bool remove_distortion)
    : film_(camera.camera.kind == CameraKind::kFilm),
      remove_distortion_(remove_distortion),
      camera_(camera.camera) {
  if (!film_) return;
  const std::string path = InteriorResultPath(interior_directory, photo);
  InteriorResult result = ReadInteriorResult(path);
  if (!result.photo_from_pixel)
    throw InputError(path + " holds no interior orientation (status " +
                     std::string(Name(result.status)) + "); leave this photo out");
  if (result.possible_orientations.size() > 1) {
    if (!orientation)
      throw InputError(path + " leaves the scan orientation open; repeat " +
                       "'orient interior' with --orientation");
    const auto turned =
        interior::InOrientation(result, camera, block::LoadMarkShapes(camera), *orientation);
    if (!turned)
      throw InputError(path + " has no transform in the orientation " +
                       std::string(Name(*orientation)) + " of the exterior orientation");
    result = *turned;
  } else if (orientation && result.orientation && result.orientation != orientation) {
    throw InputError(
        fmt::format("{}: the scan lies {}, but its exterior orientation is of a scan "
                    "that lies {}: they are of two runs; orient the photos again",
                    path, Name(*result.orientation), Name(*orientation)));
  }
  interior_path_ = path;
  interior_ = result;
  correction_ = block::CorrectionOf(result);
  // The digital camera's photo system begins at the image's centre, the film's at its own origin.
  Affine2d photo_from_image = DigitalPhotoFromPixel(image);
  photo_from_image.t += camera_.frame_centre_mm;
  image_from_photo_ = photo_from_image.Inverse();
}

void FilmImage::RequireScan(const std::string& path, int width, int height) const {
  if (!film_) return;
  const std::string why = block::WhyOfAnotherScan(interior_, interior_path_, path, width, height);
  if (!why.empty()) throw InputError(why);
}

std::optional<Eigen::Vector2d> FilmImage::ImageFromScan(const Eigen::Vector2d& scan_px) const {
  if (!film_) return scan_px;
  Eigen::Vector2d photo = PhotoFromPixel(*interior_.photo_from_pixel, correction_.get(), scan_px);
  if (remove_distortion_) {
    const auto ideal = UndistortPoint(camera_.lens, photo - camera_.principal_point_mm);
    if (!ideal) return std::nullopt;
    photo = *ideal + camera_.principal_point_mm;
  }
  return image_from_photo_ * photo;
}

Eigen::Vector2d FilmImage::ScanFromImage(const Eigen::Vector2d& image_px) const {
  if (!film_) return image_px;
  Eigen::Vector2d photo = image_from_photo_.Inverse() * image_px;
  if (remove_distortion_)
    photo =
        DistortPoint(camera_.lens, photo - camera_.principal_point_mm) + camera_.principal_point_mm;
  return PixelFromPhoto(*interior_.photo_from_pixel, correction_.get(), photo);
}

}  // namespace orient

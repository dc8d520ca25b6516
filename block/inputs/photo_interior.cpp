#include "block/inputs/photo_interior.h"

#include "block/inputs/digest.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"

namespace orient::block {
namespace {

std::string SizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height) + " px";
}

void RequireSize(const Raster& photo, int width, int height) {
  if (photo.Width() != width || photo.Height() != height)
    throw InputError(photo.Path() + " has " + SizeText(photo.Width(), photo.Height()) +
                     ", the camera file says " + SizeText(width, height) +
                     "; give the camera or the image that belongs to it");
}

}  // namespace

PhotoInterior PhotoInteriorOf(const Raster& photo, const Camera& camera,
                              const std::string& interior_directory) {
  if (camera.kind == CameraKind::kDigital) {
    if (camera.image_px) RequireSize(photo, camera.image_px->x(), camera.image_px->y());
    return {DigitalPhotoFromPixel(camera)};
  }
  if (interior_directory.empty())
    throw InputError(photo.Path() + " is a film photo: give the folder of its interior " +
                     "orientation with --interior (made by 'orient interior')");
  const std::string path = InteriorResultPath(interior_directory, PhotoName(photo.Path()));
  const InteriorResult interior = ReadInteriorResult(path);
  if (!interior.photo_from_pixel)
    throw InputError(path + " holds no interior orientation (status " +
                     std::string(Name(interior.status)) + "); leave this photo out");
  if (interior.possible_orientations.size() > 1)
    throw InputError(path + " leaves the scan orientation open; repeat 'orient interior' " +
                     "with --orientation");
  if (const std::string why =
          WhyOfAnotherScan(interior, path, photo.Path(), photo.Width(), photo.Height());
      !why.empty())
    throw InputError(why);
  return {*interior.photo_from_pixel, CorrectionOf(interior)};
}

std::string WhyOfAnotherScan(const InteriorResult& interior, const std::string& path,
                             const std::string& scan, int width, int height) {
  if (interior.width != width || interior.height != height)
    return path + " is of a scan of " + SizeText(interior.width, interior.height) + ", " + scan +
           " has " + SizeText(width, height) + "; run 'orient interior' again";
  const auto then = interior.made_from.find("scan");
  if (then == interior.made_from.end() || then->second.empty()) return "";
  const std::string now = DigestOfFile(scan);
  if (now.empty() || now == then->second) return "";
  return path + " is of another scan than " + scan +
         " (the same size, other content); run 'orient interior' again";
}

std::shared_ptr<const FilmCorrection> CorrectionOf(const InteriorResult& interior) {
  if (!interior.reseau) return nullptr;
  return std::make_shared<const FilmCorrection>(interior.reseau->correction);
}

}  // namespace orient::block

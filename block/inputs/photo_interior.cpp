#include "block/inputs/photo_interior.h"

#include <fmt/format.h>

#include "block/inputs/digest.h"
#include "block/inputs/mark_shapes.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "interior/interior.h"

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

std::string PathOf(const Raster& photo, const std::string& interior_directory) {
  if (interior_directory.empty())
    throw InputError(photo.Path() + " is a film photo: give the folder of its interior " +
                     "orientation with --interior (made by 'orient interior')");
  return InteriorResultPath(interior_directory, PhotoName(photo.Path()));
}

// A film photo's interior orientation, in file `path`. Throws InputError if it is another scan's.
InteriorResult ReadOwnInterior(const Raster& photo, const std::string& path) {
  InteriorResult interior = ReadInteriorResult(path);
  const std::string why =
      WhyOfAnotherScan(interior, path, photo.Path(), photo.Width(), photo.Height());
  if (!why.empty()) throw InputError(why);
  return interior;
}

void RequireImageOf(const Raster& photo, const Camera& digital) {
  if (digital.image_px) RequireSize(photo, digital.image_px->x(), digital.image_px->y());
}

}  // namespace

PhotoInterior PhotoInteriorOf(const Raster& photo, const Camera& camera,
                              const std::string& interior_directory) {
  return PhotoInteriorOf(photo, CameraFile{camera, {}, {}, std::nullopt, {}}, interior_directory,
                         [] { return std::nullopt; });
}

PhotoInterior PhotoInteriorOf(const Raster& photo, const CameraFile& camera,
                              const std::string& interior_directory,
                              const std::function<std::optional<ScanOrientation>()>& orientation) {
  if (camera.camera.kind == CameraKind::kDigital) {
    RequireImageOf(photo, camera.camera);
    return {DigitalPhotoFromPixel(camera.camera)};
  }
  const std::string path = PathOf(photo, interior_directory);
  const InteriorResult interior = ReadOwnInterior(photo, path);
  if (!interior.photo_from_pixel)
    throw InputError(path + " holds no interior orientation (status " +
                     std::string(Name(interior.status)) + "); leave this photo out");
  if (interior.possible_orientations.size() <= 1)
    return {*interior.photo_from_pixel, CorrectionOf(interior)};
  const std::optional<ScanOrientation> found = orientation();
  if (!found)
    throw InputError(path + " leaves the scan orientation open; repeat 'orient interior' " +
                     "with --orientation");
  const auto turned = interior::InOrientation(interior, camera, LoadMarkShapes(camera), *found);
  if (!turned || !turned->photo_from_pixel)
    throw InputError(
        fmt::format("{} excludes the scan orientation {} in which the photo was "
                    "oriented; orient it again",
                    path, Name(*found)));
  return {*turned->photo_from_pixel, CorrectionOf(*turned)};
}

void RequireOrientedScan(const Raster& photo, const Camera& camera,
                         const std::string& interior_directory) {
  if (camera.kind == CameraKind::kDigital)
    RequireImageOf(photo, camera);
  else
    ReadOwnInterior(photo, PathOf(photo, interior_directory));
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

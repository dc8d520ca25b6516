// Between a photo's scan and the image it is resampled into: the photo system's pixel grid.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/geometry/film_correction.h"
#include "core/geometry/transform2d.h"

namespace orient {

// A digital camera's images stay what they are: both ways are the identity.
class FilmImage {
 public:
  // `camera` is the photo's, `image` the one of ImageCamera(). Of a film photo the interior
  // orientation is read from `interior_directory`; where it leaves open the scan orientation,
  // `orientation` says. Throws InputError naming the photo.
  FilmImage(const CameraFile& camera, const std::string& photo,
            const std::string& interior_directory, std::optional<ScanOrientation> orientation,
            const Camera& image, bool remove_distortion);

  // Empty where the lens model has no inverse.
  std::optional<Eigen::Vector2d> ImageFromScan(const Eigen::Vector2d& scan_px) const;
  Eigen::Vector2d ScanFromImage(const Eigen::Vector2d& image_px) const;

  // Throws InputError where the image (of that size) is not the scan of the interior orientation.
  void RequireScan(const std::string& path, int width, int height) const;
  // Of the scan; 0 for a digital image.
  int ScanWidth() const { return interior_.width; }
  int ScanHeight() const { return interior_.height; }
  bool IsFilm() const { return film_; }

 private:
  bool film_ = false;
  bool remove_distortion_ = false;
  std::string interior_path_;  // of a film photo, and what it holds
  InteriorResult interior_;
  Camera camera_;
  Affine2d image_from_photo_;  // the photo's own system, not the digital camera's
  std::shared_ptr<const FilmCorrection> correction_;
};

}  // namespace orient

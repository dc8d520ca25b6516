// The formulas by which each program projects ground points with its own files: written from the
// programs' documentation, in their own axes and pixels, and apart from Orient's geometry, so that
// the one can be held against the other.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>

#include "tools/convert/convert_source.h"

namespace orient {

// How a file may have been meant other than its program reads it.
struct Reading {
  bool transposed = false;          // the rotation the other way round
  bool phi_omega_kappa = false;     // angles: about Y first, then X, then Z
  bool other_unit = false;          // angles: degrees in place of gon, or gon in place of degrees
  bool turned_axes = false;         // the camera's y and z axes point the other way
  bool mirrored_principal = false;  // the principal point's offset with the other sign
  bool swapped = false;             // rows for columns
  int half_pixels = 0;  // +1: the file's pixels are half a pixel too small; -1: too large

  int Count() const;  // how many conventions are not the program's
};
// "rotation transposed, y axis up"; "as declared" for none.
std::string Describe(const Reading& reading);

// Which conventions a format has at all: the others are never tried.
struct ReadingChoices {
  bool angles = false, matrix = false, pixels = false;
};

class ProgramFiles {
 public:
  virtual ~ProgramFiles() = default;
  virtual ReadingChoices Choices() const = 0;
  // Where the program sees a point of the file's ground system: Orient's pixel (first centre 0.5)
  // for formats of images (Choices().pixels); mm relative to the principal point, y up, for the
  // others, with the principal distance given. Empty behind the camera. Throws InputError for an
  // image that the files do not hold.
  virtual std::optional<Eigen::Vector2d> Project(const std::string& image,
                                                 const Eigen::Vector3d& ground,
                                                 double principal_distance_mm,
                                                 const Reading& reading) const = 0;
};

// Throws InputError where the files cannot be read.
std::unique_ptr<ProgramFiles> OpenProgramFiles(ExchangeFormat format, const std::string& directory);

}  // namespace orient

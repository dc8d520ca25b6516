// The four real NGI frames: published orientation, and blocks made from them for tests.
#pragma once

#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/terrain/ground_surface.h"

namespace orient {

struct Ngi {
  std::string folder;
  CameraFile camera;
  OrientationTable published;
  GroundSurface surface;

  explicit Ngi(const std::string& folder);
  std::string Photo(const std::string& number) const;       // "0251" -> path
  std::string Orthophoto(const std::string& number) const;  // made from that photo
  const OrientationRow& Published(const std::string& number) const;
  std::string CrsFile() const { return folder + "/published_orientation.prj"; }

  // Writes the published orientation with errors of these sizes in every element; the signs are
  // bits of `signs`, six per photo.
  void WriteApproximations(const std::string& path, double position_m, double attitude_deg,
                           unsigned signs) const;
  // RMS reprojection difference over the whole frame, px; length of the position's error, m;
  // largest error of an angle, degrees.
  double FrameRms(const ExteriorResult& result) const;
  double PositionError(const ExteriorResult& result) const;
  double AngleErrorDeg(const ExteriorResult& result) const;
  // RMS of the pose's six errors, decorrelated and divided by their sigmas: 1 if these are
  // realistic.
  double NormalisedError(const ExteriorResult& result) const;
};

// Patches of one strip cover two fifths of the other strip's frames, and orthophotos are displaced
// as a whole: at the far corners, the resulting error may exceed a pixel. Nothing else may be
// wrong.
void ExpectOkOrPoorlyDetermined(const ExteriorResult& result);

}  // namespace orient

// Fiducial measurements as MicMac reads them (`mm3d ReSampFid`, folder Ori-InterneScan).
//
// Two files of one layout, MesureAppuiFlottant1Im: MeasuresCamera.xml holds where the marks are in
// the camera, MeasuresIm-<image file>.xml where they are on the scan. MicMac fits an affine from
// the first to the second (cAppliOneReechMarqFid::DoReech, ElAffin2D::L2Fit) and resamples the scan
// to the rectangle around the camera's points. Two conventions differ from ours:
// - a pixel's centre has integer coordinates: theirs = ours - 0.5;
// - the camera's y points down, as rows do, and its origin is the upper-left corner of the
//   rectangle around the marks: x = ours - min x, y = max y - ours, in mm.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"

namespace orient {

struct MicmacPoint {
  std::string name;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
};

// All marks of the camera, mm; all used marks of the photo, px. In MicMac's conventions.
std::vector<MicmacPoint> MicmacCameraPoints(const std::vector<Fiducial>& fiducials);
std::vector<MicmacPoint> MicmacImagePoints(const InteriorResult& result);

// The file's text. MicMac's own camera files name the image "Glob".
std::string MicmacMeasures(const std::string& image, const std::vector<MicmacPoint>& points);

// Writes <directory>/Ori-InterneScan/MeasuresCamera.xml, whole or not at all.
void WriteMicmacCamera(const std::string& directory, const std::vector<Fiducial>& fiducials);
// Writes <directory>/Ori-InterneScan/MeasuresIm-<file name of image>.xml; removes it where the
// result has no transform, so that none of an earlier run stays behind.
void WriteMicmacImage(const std::string& directory, const std::string& image_path,
                      const InteriorResult& result);

}  // namespace orient

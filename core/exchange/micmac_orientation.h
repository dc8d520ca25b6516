// MicMac's orientation folder: Orientation-<image>.xml and the AutoCal file they name.
//
// The camera system has x right, y down, z forward; CodageMatr's lines L1 L2 L3 are the rows of the
// rotation that takes it to ground (convention eConvApero_DistM2C), Centre is the projection
// centre. Of an ideal point the pixel is PP + F (X/Z, Y/Z), then distorted around CDist:
//   m + d (c1 r2 + c2 r2^2 + c3 r2^3) + (P1 (2 dx^2 + r2) + 2 P2 dx dy, P2 (2 dy^2 + r2) + 2 P1 dx
//   dy)
// in pixels (cFraserModel_Generator / DistElemDRad of MicMac's phgr_ebner_brown_dist.cpp). The
// centre of a pixel has whole numbers: theirs = ours - 0.5. Square pixels only.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"

namespace orient {

struct MicmacCalibration {
  std::string name;  // of the file, without folder and ending
  Eigen::Vector2d pp = Eigen::Vector2d::Zero();
  double f = 0;
  Eigen::Vector2i size = Eigen::Vector2i::Zero();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  // CDist
  std::vector<double> radial;                        // CoeffDist, of r^2, r^4, ...
  double p1 = 0, p2 = 0;
};
struct MicmacCheck {  // one <Appuis> of <Verif>
  Eigen::Vector2d image = Eigen::Vector2d::Zero();
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();
};
struct MicmacOrientation {
  std::string image;
  std::size_t calibration = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // rows L1 L2 L3
  std::vector<MicmacCheck> checks;
};
struct MicmacFolder {
  std::vector<MicmacCalibration> calibrations;
  std::vector<MicmacOrientation> orientations;
};

// Writes <directory>/Ori-<name>/Orientation-<image>.xml, with verification points as the <Verif>
// block that MicMac itself recomputes when it reads the file, and AutoCal_Foc-..._Cam-....xml.
// Throws InputError where pixels are not square.
void WriteMicmacOrientation(const std::string& directory, const std::string& name,
                            const ExchangeBlock& block);

// `directory` holds the Orientation-*.xml (or the only Ori-... folder that does). Throws
// InputError: models of distortion other than ModRad and ModPhgrStd, another convention.
MicmacFolder ReadMicmacOrientation(const std::string& directory);
ExchangeBlock ExchangeFromMicmac(const MicmacFolder& folder);

}  // namespace orient

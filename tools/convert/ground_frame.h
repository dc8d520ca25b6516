// The ground systems of other programs' files: the block's own, shifted, topocentric or geocentric.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"
#include "core/terrain/crs.h"
#include "core/terrain/geocentric.h"

namespace orient {

// Between a block's coordinates (projected CRS, height) and a file's. Heights are taken for
// ellipsoidal ones of WGS 84 after `geoid_m` is added: the geoid's height above the ellipsoid.
class GroundFrame {
 public:
  // file = block - origin: Cartesian as the block itself, so nothing is approximated.
  static GroundFrame Shifted(const Eigen::Vector3d& origin);
  static GroundFrame Geocentric(const Crs& crs, double geoid_m);
  static GroundFrame Topocentric(const Crs& crs, double geoid_m, const Geodetic& origin);

  // A pose carries over as it is: no curvature, no scale of a projection.
  bool IsShift() const { return !to_geographic_; }
  const Eigen::Vector3d& Origin() const { return origin_; }
  const std::optional<Geodetic>& TopocentricOrigin() const { return topocentric_origin_; }

  // Empty where PROJ has no answer.
  std::optional<Eigen::Vector3d> FileFromBlock(const Eigen::Vector3d& block) const;
  std::optional<Eigen::Vector3d> BlockFromFile(const Eigen::Vector3d& file) const;
  std::optional<Geodetic> GeodeticFromBlock(const Eigen::Vector3d& block) const;

 private:
  GroundFrame(const Crs& crs, double geoid_m);
  GroundFrame() = default;

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double geoid_m_ = 0;
  std::shared_ptr<CoordinateTransform> to_geographic_, from_geographic_;
  std::optional<Geodetic> topocentric_origin_;
};

enum class FrameWay { kFileFromBlock, kBlockFromFile };

// The camera of a photo in the old ground system and in the new one: another where one of them has
// curvature in its lens.
struct CameraPair {
  const ExchangeCamera &from, &to;
};

// A photo in another ground system. A projected CRS is not Cartesian (scale, convergence,
// curvature), so that no pose is the same in both everywhere: this one shows the ground between the
// two heights (of the block's system) where the old one does, by least squares over the whole
// image.
struct ReframedPhoto {
  ExchangePhoto photo;
  double rms_px = 0, largest_px = 0;  // what remains, over the image and both heights
};
// The heights are those within 3 % of the flying height of the ground's mean. Empty where the image
// does not see the ground there. A shift is exact.
std::optional<ReframedPhoto> ReframePhoto(const GroundFrame& frame, FrameWay way,
                                          const ExchangePhoto& photo, const CameraPair& cameras,
                                          double ground_height_m);

// Where the ray of a direction (file or block system) from `centre` comes to the height `height_m`
// of the block's system; empty where it does not.
std::optional<Eigen::Vector3d> PointAtHeight(const GroundFrame& frame, FrameWay way,
                                             const Eigen::Vector3d& centre,
                                             const Eigen::Vector3d& direction, double height_m);

}  // namespace orient

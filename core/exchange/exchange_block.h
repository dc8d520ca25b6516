// An oriented block as other programs' files hold it: plain pinhole cameras over pixel grids, poses
// as rotation matrices, points with their observations. The modules beside turn it into the files
// of one program each, and back.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace orient {

// Pixels (col, row) in the corner convention. For a point (X, Y, Z) in the camera system, x
// right, y DOWN, z FORWARD as the image shows them: u = X/Z, v = Y/Z, r2 = u^2 + v^2,
//   u' = u (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 u^2) + 2 p2 u v, v' likewise with p1 and p2
//   exchanged; col = principal_px.x + focal_px.x u', row = principal_px.y + focal_px.y v'.
// (OpenCV, COLMAP and OpenSfM swap the two names: their p1 is our p2, and their p2 our p1.)
struct ExchangeCamera {
  std::string name;
  int width = 0, height = 0;  // px
  double pixel_mm = 0.001;    // size of a pixel; only names units where a file wants mm
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d principal_px = Eigen::Vector2d::Zero();
  std::array<double, 3> k = {0, 0, 0};
  std::array<double, 2> p = {0, 0};

  bool HasDistortion() const;
  // Of the camera system, y down and z forward; empty behind the camera.
  std::optional<Eigen::Vector2d> PixelFromCameraPoint(const Eigen::Vector3d& point) const;
};

struct ExchangePhoto {
  std::string image;       // file name, with its extension where the file holds images
  std::size_t camera = 0;  // index into ExchangeBlock::cameras
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // in the file's ground system
  // Takes photo axes (x right, y UP, z backwards: Orient's) to the ground system.
  Eigen::Matrix3d ground_from_photo = Eigen::Matrix3d::Identity();
};

struct ExchangeObservation {
  std::size_t photo = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct ExchangePoint {
  std::string name;
  bool control = false;  // its ground position is known beforehand
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();
  std::vector<ExchangeObservation> observations;
};

// A ground point and the pixel where Orient's own collinearity puts it.
struct VerificationPoint {
  std::size_t photo = 0;
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();  // in the file's ground system
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct ExchangeBlock {
  std::vector<ExchangeCamera> cameras;
  std::vector<ExchangePhoto> photos;
  std::vector<ExchangePoint> points;
  std::vector<VerificationPoint> verification;
  std::string crs;  // of the ground system, WKT or PROJ string; empty where the file says none
  // What was subtracted from ground coordinates before they came into the file.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  // Of a topocentric ground system (east, north, up): latitude, longitude (degrees, WGS 84) and
  // ellipsoidal height of its origin.
  std::optional<Eigen::Vector3d> reference_lla;
};

// Throws InputError naming `origin` and what it is about: a pose that is not finite, a matrix that
// is no rotation (to 1e-3: files round), a camera that is not finite or sees backwards.
void RequireSound(const ExchangeBlock& block, const std::string& origin);

// A photo's pose in Orient's convention, and back.
Pose PoseOf(const ExchangePhoto& photo);
void SetPose(const Pose& pose, ExchangePhoto* photo);
// Camera system (y down, z forward) to ground.
Eigen::Matrix3d GroundFromCamera(const ExchangePhoto& photo);
void SetGroundFromCamera(const Eigen::Matrix3d& ground_from_camera, ExchangePhoto* photo);

// What COLMAP and OpenSfM write: camera point = rotation * ground point + translation.
struct CameraFromGround {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};
CameraFromGround CameraFromGroundOf(const ExchangePhoto& photo);
// Centre and rotation.
void SetCameraFromGround(const CameraFromGround& camera, ExchangePhoto* photo);

// By the formulas above; empty behind the camera.
std::optional<Eigen::Vector2d> PixelFromGround(const ExchangeBlock& block, std::size_t photo,
                                               const Eigen::Vector3d& ground);

struct FittedExchangeCamera {
  ExchangeCamera camera;
  // Largest distance within the image between the camera's own distortion and the one written, px:
  // 0 for Brown's, whose coefficients are only scaled; a radial table is fitted by k1 k2 k3.
  double largest_difference_px = 0;
};
// Of a digital camera. Throws std::invalid_argument for film: its image must be resampled first.
FittedExchangeCamera ExchangeCameraOf(const Camera& digital);
// The digital camera whose fixed transform and lens are those of `camera`.
Camera CameraOf(const ExchangeCamera& camera);

// The shortest text that reads back as the same double.
std::string ExactNumber(double value);

}  // namespace orient

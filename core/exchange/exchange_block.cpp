#include "core/exchange/exchange_block.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "core/geometry/lens.h"

namespace orient {
namespace {

const Eigen::Vector3d kFlip(1, -1, -1);  // between photo axes and camera axes

// k1 k2 k3 that best fit the table's displacement (mm) over the image's radii, by least
// squares over equally spaced radii.
std::array<double, 3> FittedRadial(const RadialTable& table, double largest_radius_mm) {
  constexpr int kSamples = 200;
  Eigen::MatrixXd design(kSamples, 3);
  Eigen::VectorXd dr(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double t = (i + 1.0) / kSamples;
    const double r = t * largest_radius_mm;
    design.row(i) << t * t * t, std::pow(t, 5), std::pow(t, 7);
    dr[i] = DistortionAt(table, {r, 0}).x();
  }
  const Eigen::Vector3d c = design.colPivHouseholderQr().solve(dr);
  const double r = largest_radius_mm;
  return {c[0] / std::pow(r, 3), c[1] / std::pow(r, 5), c[2] / std::pow(r, 7)};
}

// Farthest corner of the sensor from the principal point.
double LargestRadius(const Camera& camera) {
  double largest = 0;
  for (const double sx : {-0.5, 0.5})
    for (const double sy : {-0.5, 0.5}) {
      const Eigen::Vector2d corner(sx * camera.frame_mm.x(), sy * camera.frame_mm.y());
      largest = std::max(largest, (corner - camera.principal_point_mm).norm());
    }
  return largest;
}

BrownDistortion WrittenLens(const Camera& camera) {
  if (const auto* brown = std::get_if<BrownDistortion>(&camera.lens)) return *brown;
  BrownDistortion brown;
  if (const auto* table = std::get_if<RadialTable>(&camera.lens))
    brown.k = FittedRadial(*table, LargestRadius(camera));
  return brown;
}

double LargestDifference(const Camera& camera, const BrownDistortion& written, double pixel_mm) {
  if (!std::holds_alternative<RadialTable>(camera.lens)) return 0;
  constexpr int kSamples = 500;
  const double radius = LargestRadius(camera);
  double largest = 0;
  for (int i = 0; i <= kSamples; ++i) {
    const Eigen::Vector2d at(radius * i / kSamples, 0);
    const double difference = (DistortionAt(camera.lens, at) - DistortionAt(written, at)).norm();
    largest = std::max(largest, difference / pixel_mm);
  }
  return largest;
}

}  // namespace

bool ExchangeCamera::HasDistortion() const {
  return k != std::array<double, 3>{0, 0, 0} || p != std::array<double, 2>{0, 0};
}

std::optional<Eigen::Vector2d> ExchangeCamera::PixelFromCameraPoint(
    const Eigen::Vector3d& point) const {
  if (!(point.z() > 0)) return std::nullopt;
  const double u = point.x() / point.z(), v = point.y() / point.z();
  const double r2 = u * u + v * v;
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
  const double du = p[0] * (r2 + 2 * u * u) + 2 * p[1] * u * v;
  const double dv = p[1] * (r2 + 2 * v * v) + 2 * p[0] * u * v;
  return Eigen::Vector2d(principal_px.x() + focal_px.x() * (u * radial + du),
                         principal_px.y() + focal_px.y() * (v * radial + dv));
}

void RequireSound(const ExchangeBlock& block, const std::string& origin) {
  constexpr double kRounding = 1e-3;
  for (const ExchangePhoto& photo : block.photos) {
    const Eigen::Matrix3d& r = photo.ground_from_photo;
    if (!photo.centre.allFinite() || !r.allFinite())
      throw InputError(origin + ": the pose of photo " + photo.image + " is not finite");
    const Eigen::Matrix3d off = r * r.transpose() - Eigen::Matrix3d::Identity();
    if (!(off.cwiseAbs().maxCoeff() <= kRounding) || !(r.determinant() > 0))
      throw InputError(origin + ": the matrix of photo " + photo.image +
                       " is not a rotation matrix");
  }
  for (const ExchangeCamera& camera : block.cameras)
    if (!camera.focal_px.allFinite() || !camera.principal_px.allFinite() ||
        !(camera.focal_px.minCoeff() >= 0) || std::min(camera.width, camera.height) < 0 ||
        (camera.width == 0) != (camera.height == 0) ||
        (camera.width > 0 && !(camera.focal_px.minCoeff() > 0)))
      throw InputError(origin + ": the camera '" + camera.name +
                       "' has an impossible size, focal length or principal point");
}

Pose PoseOf(const ExchangePhoto& photo) {
  return {photo.centre, OpkFromRotation(photo.ground_from_photo)};
}

void SetPose(const Pose& pose, ExchangePhoto* photo) {
  photo->centre = pose.position_m;
  photo->ground_from_photo = pose.GroundFromPhoto();
}

Eigen::Matrix3d GroundFromCamera(const ExchangePhoto& photo) {
  return photo.ground_from_photo * kFlip.asDiagonal();
}

void SetGroundFromCamera(const Eigen::Matrix3d& ground_from_camera, ExchangePhoto* photo) {
  photo->ground_from_photo = ground_from_camera * kFlip.asDiagonal();
}

CameraFromGround CameraFromGroundOf(const ExchangePhoto& photo) {
  const Eigen::Matrix3d rotation = GroundFromCamera(photo).transpose();
  return {rotation, -rotation * photo.centre};
}

void SetCameraFromGround(const CameraFromGround& camera, ExchangePhoto* photo) {
  photo->centre = -camera.rotation.transpose() * camera.translation;
  SetGroundFromCamera(camera.rotation.transpose(), photo);
}

std::optional<Eigen::Vector2d> PixelFromGround(const ExchangeBlock& block, std::size_t photo,
                                               const Eigen::Vector3d& ground) {
  const ExchangePhoto& p = block.photos.at(photo);
  return block.cameras.at(p.camera).PixelFromCameraPoint(GroundFromCamera(p).transpose() *
                                                         (ground - p.centre));
}

FittedExchangeCamera ExchangeCameraOf(const Camera& digital) {
  const Affine2d photo_from_pixel = DigitalPhotoFromPixel(digital);  // throws for film
  const Eigen::Vector2d pixel_mm = photo_from_pixel.A.diagonal().cwiseAbs();
  const double c = digital.principal_distance_mm;
  const BrownDistortion lens = WrittenLens(digital);
  FittedExchangeCamera fitted;
  ExchangeCamera& camera = fitted.camera;
  camera.name = digital.name;
  camera.width = digital.image_px->x();
  camera.height = digital.image_px->y();
  camera.pixel_mm = pixel_mm.x();
  camera.focal_px = c * pixel_mm.cwiseInverse();
  camera.principal_px = photo_from_pixel.Inverse() * digital.principal_point_mm;
  camera.k = {lens.k[0] * c * c, lens.k[1] * std::pow(c, 4), lens.k[2] * std::pow(c, 6)};
  // y has the opposite direction, so terms odd in y change sign.
  camera.p = {lens.p[0] * c, -lens.p[1] * c};
  fitted.largest_difference_px = LargestDifference(digital, lens, pixel_mm.minCoeff());
  return fitted;
}

Camera CameraOf(const ExchangeCamera& exchange) {
  Camera camera;
  camera.name = exchange.name;
  camera.kind = CameraKind::kDigital;
  const Eigen::Vector2d pixel_mm(exchange.pixel_mm,
                                 exchange.pixel_mm * exchange.focal_px.x() / exchange.focal_px.y());
  const double c = exchange.focal_px.x() * exchange.pixel_mm;
  camera.principal_distance_mm = c;
  camera.image_px = Eigen::Vector2i(exchange.width, exchange.height);
  camera.frame_mm = camera.image_px->cast<double>().cwiseProduct(pixel_mm);
  camera.principal_point_mm = DigitalPhotoFromPixel(camera) * exchange.principal_px;
  if (exchange.HasDistortion())
    camera.lens = BrownDistortion{
        {exchange.k[0] / (c * c), exchange.k[1] / std::pow(c, 4), exchange.k[2] / std::pow(c, 6)},
        {exchange.p[0] / c, -exchange.p[1] / c}};
  return camera;
}

std::string ExactNumber(double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("ExactNumber: the value is not finite");
  std::array<char, 40> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), static_cast<std::size_t>(end - text.data())};
}

}  // namespace orient

#include "tools/convert/ground_frame.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace orient {
namespace {

constexpr const char* kGeographic = "EPSG:4326";
constexpr int kGrid = 7;  // points along a side of the image

constexpr double kRelief = 0.03;  // of the flying height

// Observation to fit a pose to: a ground point of the new system, and its pixel by the old pose.
struct SeenPoint3d {
  Eigen::Vector3d ground;
  Eigen::Vector2d pixel;
};

std::optional<Eigen::Vector3d> Mapped(const GroundFrame& frame, FrameWay way,
                                      const Eigen::Vector3d& point) {
  return way == FrameWay::kFileFromBlock ? frame.FileFromBlock(point) : frame.BlockFromFile(point);
}

std::optional<double> BlockHeight(const GroundFrame& frame, FrameWay way,
                                  const Eigen::Vector3d& point) {
  if (way == FrameWay::kFileFromBlock) return point.z();
  const auto block = frame.BlockFromFile(point);
  if (!block) return std::nullopt;
  return block->z();
}

// Rays through the whole image. Lens distortion is left out: it moves the grid by a few pixels
// only.
std::vector<Eigen::Vector2d> GridRays(const ExchangeCamera& camera) {
  std::vector<Eigen::Vector2d> rays;
  // Where the size is unknown (ASP) the principal point lies in the middle.
  const Eigen::Vector2d size = camera.width > 0 ? Eigen::Vector2d(camera.width, camera.height)
                                                : Eigen::Vector2d(2 * camera.principal_px);
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const Eigen::Vector2d at(i / (kGrid - 1.0) * size.x(), j / (kGrid - 1.0) * size.y());
      rays.emplace_back((at - camera.principal_px).cwiseQuotient(camera.focal_px));
    }
  return rays;
}

std::vector<SeenPoint3d> SeenPoints(const GroundFrame& frame, FrameWay way,
                                    const ExchangePhoto& photo, const ExchangeCamera& camera,
                                    double lowest_m, double highest_m) {
  std::vector<SeenPoint3d> seen;
  for (const Eigen::Vector2d& ray : GridRays(camera))
    for (const double height : {lowest_m, highest_m}) {
      const Eigen::Vector3d direction =
          GroundFromCamera(photo) * Eigen::Vector3d(ray.x(), ray.y(), 1);
      const auto point = PointAtHeight(frame, way, photo.centre, direction.normalized(), height);
      const auto mapped = point ? Mapped(frame, way, *point) : std::nullopt;
      const auto pixel = camera.PixelFromCameraPoint({ray.x(), ray.y(), 1});
      if (mapped && pixel) seen.push_back({*mapped, *pixel});
    }
  return seen;
}

// The rotation nearest to the mapping's derivative at a point.
std::optional<Eigen::Matrix3d> TurnAt(const GroundFrame& frame, FrameWay way,
                                      const Eigen::Vector3d& point) {
  constexpr double kStep_m = 100;
  Eigen::Matrix3d derivative;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(i);
    const auto after = Mapped(frame, way, point + step), before = Mapped(frame, way, point - step);
    if (!after || !before) return std::nullopt;
    derivative.col(i) = (*after - *before) / (2 * kStep_m);
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(derivative,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  return Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose());
}

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Residuals in px.
std::vector<Eigen::Vector2d> Residuals(const ExchangePhoto& photo, const ExchangeCamera& camera,
                                       const std::vector<SeenPoint3d>& seen) {
  std::vector<Eigen::Vector2d> residuals;
  const Eigen::Matrix3d camera_from_ground = GroundFromCamera(photo).transpose();
  for (const SeenPoint3d& point : seen) {
    const auto pixel =
        camera.PixelFromCameraPoint(camera_from_ground * (point.ground - photo.centre));
    residuals.push_back(pixel ? Eigen::Vector2d(point.pixel - *pixel)
                              : Eigen::Vector2d::Constant(std::nan("")));
  }
  return residuals;
}

// One Gauss-Newton step, the lens left out of its derivatives: rotation (a rotation vector in the
// camera system) and the centre's shift.
void Step(const ExchangeCamera& camera, const std::vector<SeenPoint3d>& seen,
          ExchangePhoto* photo) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  const auto residuals = Residuals(*photo, camera, seen);
  const Eigen::Matrix3d ground_from_camera = GroundFromCamera(*photo);
  const Eigen::Matrix3d camera_from_ground = ground_from_camera.transpose();
  // Scales metres and radians alike, so that the normal equations are well conditioned.
  const double distance = (seen.front().ground - photo->centre).norm();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Eigen::Vector3d q = camera_from_ground * (seen[i].ground - photo->centre);
    Eigen::Matrix<double, 2, 3> by_q;
    by_q << 1 / q.z(), 0, -q.x() / (q.z() * q.z()), 0, 1 / q.z(), -q.y() / (q.z() * q.z());
    by_q = camera.focal_px.asDiagonal() * by_q;
    // R <- R exp([w]): q <- q - w x q; C <- C + R (distance t): q <- q - distance t.
    Eigen::Matrix<double, 2, 6> jacobian;
    jacobian << by_q * Cross(q), -distance * by_q;
    normal += jacobian.transpose() * jacobian;
    right += jacobian.transpose() * residuals[i];
  }
  const Eigen::Matrix<double, 6, 1> step = normal.ldlt().solve(right);
  const Eigen::Vector3d turn = step.head<3>();
  photo->centre += ground_from_camera * (distance * step.tail<3>());
  if (turn.norm() > 0)
    SetGroundFromCamera(
        ground_from_camera * Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix(),
        photo);
}

}  // namespace

GroundFrame::GroundFrame(const Crs& crs, double geoid_m)
    : geoid_m_(geoid_m),
      to_geographic_(std::make_shared<CoordinateTransform>(
          CoordinateTransform::Between(kGeographic, crs.Wkt()))),
      from_geographic_(std::make_shared<CoordinateTransform>(
          CoordinateTransform::Between(crs.Wkt(), kGeographic))) {}

GroundFrame GroundFrame::Shifted(const Eigen::Vector3d& origin) {
  GroundFrame frame;
  frame.origin_ = origin;
  return frame;
}

GroundFrame GroundFrame::Geocentric(const Crs& crs, double geoid_m) { return {crs, geoid_m}; }

GroundFrame GroundFrame::Topocentric(const Crs& crs, double geoid_m, const Geodetic& origin) {
  GroundFrame frame(crs, geoid_m);
  frame.topocentric_origin_ = origin;
  return frame;
}

std::optional<Geodetic> GroundFrame::GeodeticFromBlock(const Eigen::Vector3d& block) const {
  if (IsShift()) return std::nullopt;
  const auto lon_lat = (*to_geographic_)(block.head<2>());
  if (!lon_lat) return std::nullopt;
  return Geodetic{RadFromDeg(lon_lat->y()), RadFromDeg(lon_lat->x()), block.z() + geoid_m_};
}

std::optional<Eigen::Vector3d> GroundFrame::FileFromBlock(const Eigen::Vector3d& block) const {
  if (IsShift()) return Eigen::Vector3d(block - origin_);
  const auto at = GeodeticFromBlock(block);
  if (!at) return std::nullopt;
  const Eigen::Vector3d geocentric = GeocentricFromGeodetic(*at);
  if (!topocentric_origin_) return geocentric;
  return orient::Topocentric(*topocentric_origin_).LocalFromGeocentric(geocentric);
}

std::optional<Eigen::Vector3d> GroundFrame::BlockFromFile(const Eigen::Vector3d& file) const {
  if (IsShift()) return Eigen::Vector3d(file + origin_);
  const Eigen::Vector3d geocentric =
      topocentric_origin_ ? orient::Topocentric(*topocentric_origin_).GeocentricFromLocal(file)
                          : file;
  const Geodetic at = GeodeticFromGeocentric(geocentric);
  const auto xy = (*from_geographic_)({DegFromRad(at.longitude_rad), DegFromRad(at.latitude_rad)});
  if (!xy) return std::nullopt;
  return Eigen::Vector3d(xy->x(), xy->y(), at.height_m - geoid_m_);
}

std::optional<Eigen::Vector3d> PointAtHeight(const GroundFrame& frame, FrameWay way,
                                             const Eigen::Vector3d& centre,
                                             const Eigen::Vector3d& direction, double height_m) {
  const auto top = BlockHeight(frame, way, centre);
  if (!top || *top <= height_m) return std::nullopt;
  // Heights along the ray are almost linear: iterates with the chord from the centre.
  double distance = *top - height_m;
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d point = centre + distance * direction;
    const auto height = BlockHeight(frame, way, point);
    if (!height || *height >= *top) return std::nullopt;
    if (std::abs(*height - height_m) < 1e-6) return point;
    distance *= (*top - height_m) / (*top - *height);
    if (!(distance < 1e6)) return std::nullopt;  // towards the horizon
  }
  return std::nullopt;
}

std::optional<ReframedPhoto> ReframePhoto(const GroundFrame& frame, FrameWay way,
                                          const ExchangePhoto& photo, const CameraPair& cameras,
                                          double ground_height_m) {
  ReframedPhoto result{photo, 0, 0};
  const auto centre = Mapped(frame, way, photo.centre);
  const auto top = BlockHeight(frame, way, photo.centre);
  if (!centre || !top) return std::nullopt;
  result.photo.centre = *centre;
  if (frame.IsShift()) return result;
  const double relief = kRelief * std::abs(*top - ground_height_m);
  const auto seen = SeenPoints(frame, way, photo, cameras.from, ground_height_m - relief,
                               ground_height_m + relief);
  if (seen.size() < 8) return std::nullopt;
  const auto turn = TurnAt(frame, way, photo.centre);
  if (!turn) return std::nullopt;
  result.photo.ground_from_photo = *turn * photo.ground_from_photo;
  for (int i = 0; i < 8; ++i) Step(cameras.to, seen, &result.photo);
  double sum = 0;
  for (const Eigen::Vector2d& r : Residuals(result.photo, cameras.to, seen)) {
    sum += r.squaredNorm();
    result.largest_px = std::max(result.largest_px, r.norm());
  }
  result.rms_px = std::sqrt(sum / static_cast<double>(seen.size()));
  if (!std::isfinite(result.rms_px)) return std::nullopt;
  return result;
}

}  // namespace orient

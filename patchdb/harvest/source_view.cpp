#include "patchdb/harvest/source_view.h"

#include <Eigen/LU>

#include "core/base/error.h"

namespace orient::patchdb {
namespace {

class PhotoSource : public SourceView {
 public:
  PhotoSource(const PhotoView& view, const std::optional<Matrix6d>& pose_covariance,
              double orientation_sigma_px, const GroundSurface& surface)
      : view_(view),
        pixel_from_photo_(view.photo_from_pixel.Inverse()),
        pose_covariance_(pose_covariance),
        orientation_sigma_px_(orientation_sigma_px),
        surface_(surface) {}

  std::optional<Eigen::Vector2d> PixelFromGround(const Eigen::Vector3d& ground_m) const override {
    const auto photo_mm = PhotoFromGround(view_.camera, view_.pose, ground_m);
    if (!photo_mm || !view_.camera.InFrame(*photo_mm)) return std::nullopt;
    return view_.PixelFromPhoto(*photo_mm);
  }

  std::optional<Eigen::Vector3d> GroundFromPixel(const Eigen::Vector2d& pixel) const override {
    if (!view_.camera.InFrame(view_.PhotoFromPixel(pixel))) return std::nullopt;
    return view_.GroundFromPixel(pixel, surface_);
  }

  bool IsOrthophoto() const override { return false; }

  Eigen::Vector3d HeightEffect(const Eigen::Vector3d& ground_m) const override {
    const Eigen::Vector3d sight = view_.pose.position_m - ground_m;
    return sight / sight.z();
  }

  Eigen::Matrix2d OrientationCovariance(const Eigen::Vector3d& ground_m) const override {
    if (pose_covariance_) {
      const auto derivatives = PhotoFromGroundWithDerivatives(view_.camera, view_.pose, ground_m);
      if (derivatives) {
        const Eigen::Matrix<double, 2, 6> by_pose = pixel_from_photo_.A * derivatives->by_pose;
        return by_pose * *pose_covariance_ * by_pose.transpose();
      }
    }
    return Eigen::Matrix2d::Identity() * (orientation_sigma_px_ * orientation_sigma_px_);
  }

 private:
  PhotoView view_;
  Affine2d pixel_from_photo_;
  std::optional<Matrix6d> pose_covariance_;
  double orientation_sigma_px_;
  const GroundSurface& surface_;
};

// Tangent of the angle to a frame's corners, between a normal-angle and a wide-angle camera.
constexpr double kTangentAtCorner = 0.8;

// Where an orthophoto's pixels lie, and in which CRS.
struct OrthoGeoreference {
  Affine2d map_from_pixel;
  Crs crs;
};

OrthoGeoreference GeoreferenceOf(const Raster& ortho) {
  const auto g = ortho.GeoTransform();
  if (!g)
    throw InputError(ortho.Path() + " has no georeference; an orthophoto needs one (a world file " +
                     "or a GeoTIFF)");
  if (ortho.CrsWkt().empty())
    throw InputError(ortho.Path() + " does not name its CRS; write it with 'gdal_edit.py -a_srs'");
  Affine2d map_from_pixel;
  map_from_pixel.A << (*g)[1], (*g)[2], (*g)[4], (*g)[5];
  map_from_pixel.t << (*g)[0], (*g)[3];
  if (!map_from_pixel.A.allFinite() || !map_from_pixel.t.allFinite() ||
      !map_from_pixel.IsInvertible())
    throw InputError(ortho.Path() + " has a degenerate georeference; it cannot be used");
  return {map_from_pixel, Crs::Parse(ortho.CrsWkt(), ortho.Path())};
}

class OrthoSource : public SourceView {
 public:
  OrthoSource(const OrthoGeoreference& georeference, const Bounds& extent, const Crs& ground_crs,
              double orientation_sigma_px, const GroundSurface& surface)
      : centre_((extent.min_x + extent.max_x) / 2, (extent.min_y + extent.max_y) / 2),
        height_(0.5 * std::hypot(extent.max_x - extent.min_x, extent.max_y - extent.min_y) /
                kTangentAtCorner),
        map_from_pixel_(georeference.map_from_pixel),
        pixel_from_map_(georeference.map_from_pixel.Inverse()),
        orientation_sigma_px_(orientation_sigma_px),
        surface_(surface) {
    if (georeference.crs.SameAs(ground_crs)) return;
    map_from_ground_.emplace(georeference.crs, ground_crs);
    ground_from_map_.emplace(ground_crs, georeference.crs);
  }

  std::optional<Eigen::Vector2d> PixelFromGround(const Eigen::Vector3d& ground_m) const override {
    const Eigen::Vector2d ground = ground_m.head<2>();
    const auto map = map_from_ground_ ? (*map_from_ground_)(ground) : std::optional(ground);
    if (!map) return std::nullopt;
    return pixel_from_map_ * *map;
  }

  std::optional<Eigen::Vector2d> PlaneFromPixel(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d map = map_from_pixel_ * pixel;
    return ground_from_map_ ? (*ground_from_map_)(map) : std::optional(map);
  }

  std::optional<Eigen::Vector3d> GroundFromPixel(const Eigen::Vector2d& pixel) const override {
    const auto plane = PlaneFromPixel(pixel);
    if (!plane) return std::nullopt;
    const auto height = surface_.HeightAt(plane->x(), plane->y());
    if (!height) return std::nullopt;
    return Eigen::Vector3d(plane->x(), plane->y(), *height);
  }

  bool IsOrthophoto() const override { return true; }

  // The photo behind an orthophoto is not known. Most orthophotos show one photo's frame, seen from
  // above its middle. The ray through (X, h + 1) meets the true ground h farther out by
  // (X - centre) / height: with heights too high, content lies nearer to the middle than it is.
  Eigen::Vector3d HeightEffect(const Eigen::Vector3d& ground_m) const override {
    const Eigen::Vector2d inwards = (centre_ - ground_m.head<2>()) / height_;
    return {inwards.x(), inwards.y(), 0};
  }

  Eigen::Matrix2d OrientationCovariance(const Eigen::Vector3d&) const override {
    return Eigen::Matrix2d::Identity() * (orientation_sigma_px_ * orientation_sigma_px_);
  }

 private:
  Eigen::Vector2d centre_;  // of its extent, ground
  double height_;           // assumed flying height, m
  Affine2d map_from_pixel_, pixel_from_map_;
  double orientation_sigma_px_;
  const GroundSurface& surface_;
  std::optional<CoordinateTransform> map_from_ground_, ground_from_map_;
};

}  // namespace

std::unique_ptr<SourceView> MakePhotoSource(const PhotoView& view,
                                            const std::optional<Matrix6d>& pose_covariance,
                                            double orientation_sigma_px,
                                            const GroundSurface& surface) {
  return std::make_unique<PhotoSource>(view, pose_covariance, orientation_sigma_px, surface);
}

std::unique_ptr<SourceView> MakeOrthoSource(const Raster& ortho, const Crs& ground_crs,
                                            double orientation_sigma_px,
                                            const GroundSurface& surface) {
  return std::make_unique<OrthoSource>(GeoreferenceOf(ortho), OrthoFootprint(ortho, ground_crs),
                                       ground_crs, orientation_sigma_px, surface);
}

Bounds OrthoFootprint(const Raster& ortho, const Crs& ground_crs) {
  constexpr int kSteps = 8;  // the border of a transformed rectangle is curved
  const OrthoGeoreference georeference = GeoreferenceOf(ortho);
  const CoordinateTransform ground_from_map(ground_crs, georeference.crs);
  Bounds bounds = Bounds::OfNothing();
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d pixel(ortho.Width() * j / double(kSteps),
                                  ortho.Height() * i / double(kSteps));
      if (const auto ground = ground_from_map(georeference.map_from_pixel * pixel))
        bounds.Include(ground->x(), ground->y());
    }
  return bounds;
}

std::optional<Eigen::Matrix<double, 2, 3>> PixelDerivatives(const SourceView& source,
                                                            const Eigen::Vector3d& ground_m,
                                                            double step_m) {
  Eigen::Matrix<double, 2, 3> derivatives;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d step = Eigen::Vector3d::Unit(i) * step_m;
    const auto after = source.PixelFromGround(ground_m + step);
    const auto before = source.PixelFromGround(ground_m - step);
    if (!after || !before) return std::nullopt;
    derivatives.col(i) = (*after - *before) / (2 * step_m);
  }
  return derivatives;
}

std::optional<double> GsdAt(const SourceView& source, const Eigen::Vector3d& ground_m) {
  constexpr double kStep = 1.0;  // m; the mapping is smooth far beyond that
  const auto derivatives = PixelDerivatives(source, ground_m, kStep);
  if (!derivatives) return std::nullopt;
  const double area = std::abs(derivatives->leftCols<2>().determinant());
  if (!(area > 0) || !std::isfinite(area)) return std::nullopt;
  return 1 / std::sqrt(area);
}

}  // namespace orient::patchdb

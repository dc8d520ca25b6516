// What patches are cut from: a raster that shows the ground, and where it shows which ground point.
// A photo sees it through its orientation, an orthophoto through its georeference; the harvest
// knows neither.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "core/raster/raster.h"
#include "core/terrain/crs.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient::patchdb {

class SourceView {
 public:
  virtual ~SourceView() = default;
  // Raster pixel showing a ground point (database CRS); empty where the source does not show it.
  virtual std::optional<Eigen::Vector2d> PixelFromGround(const Eigen::Vector3d& ground_m) const = 0;
  // The point of the ground surface at a raster pixel; empty where the surface has none there.
  virtual std::optional<Eigen::Vector3d> GroundFromPixel(const Eigen::Vector2d& pixel) const = 0;
  // An orthophoto does not show heights: PixelFromGround does not depend on Z.
  virtual bool IsOrthophoto() const = 0;
  // How the ground point that a pixel is taken for moves for each metre by which the heights are
  // too high there: of a photo the surface's, along the line of sight towards the camera; of an
  // orthophoto those that it was made with, in the plane.
  virtual Eigen::Vector3d HeightEffect(const Eigen::Vector3d& ground_m) const = 0;
  // Uncertainty of where the source shows a ground point, px^2: that of its orientation.
  virtual Eigen::Matrix2d OrientationCovariance(const Eigen::Vector3d& ground_m) const = 0;
};

// `pose_covariance` in the order of Pose::AsVector; without it the photo is taken to be oriented to
// `orientation_sigma_px` everywhere. Keeps a reference to `surface`.
std::unique_ptr<SourceView> MakePhotoSource(const PhotoView& view,
                                            const std::optional<Matrix6d>& pose_covariance,
                                            double orientation_sigma_px,
                                            const GroundSurface& surface);

// Any geotransform, turned ones too; a CRS other than the ground's is transformed. Throws
// InputError naming the raster: no geotransform, no CRS, a CRS that is geographic or not metric.
// Keeps a reference to `surface`.
std::unique_ptr<SourceView> MakeOrthoSource(const Raster& ortho, const Crs& ground_crs,
                                            double orientation_sigma_px,
                                            const GroundSurface& surface);

// Ground rectangle that an orthophoto covers. Throws like MakeOrthoSource.
Bounds OrthoFootprint(const Raster& ortho, const Crs& ground_crs);

// d pixel / d (X, Y, Z) by differences over `step_m`; empty where the source does not show it.
std::optional<Eigen::Matrix<double, 2, 3>> PixelDerivatives(const SourceView& source,
                                                            const Eigen::Vector3d& ground_m,
                                                            double step_m);

// Side of the horizontal square that one raster pixel shows there, m.
std::optional<double> GsdAt(const SourceView& source, const Eigen::Vector3d& ground_m);

}  // namespace orient::patchdb

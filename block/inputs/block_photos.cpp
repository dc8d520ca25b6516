#include "block/inputs/block_photos.h"

#include <fmt/format.h>

#include <algorithm>

#include "block/inputs/digest.h"
#include "block/inputs/film_positions.h"
#include "core/base/atomic_write.h"
#include "core/base/error.h"

namespace orient::block {
namespace {

void TakeFilmPosition(const CameraFile& camera, const interior::MarkShapes& marks,
                      const std::string& interior_directory, BlockPhotoFile* photo) {
  if (camera.camera.kind == CameraKind::kDigital) {
    photo->position.photo_from_pixel = DigitalPhotoFromPixel(camera.camera);
    return;
  }
  const InteriorResult interior =
      ReadInteriorResult(InteriorResultPath(interior_directory, photo->name));
  photo->negative = interior.polarity == Polarity::kNegative;
  if (interior.photo_from_pixel)
    for (const exterior::FilmPosition& position : FilmPositions(interior, camera, marks))
      if (position.orientation == photo->exterior.orientation) {
        photo->position = position;
        return;
      }
  WithdrawPose(&photo->exterior);
  photo->exterior.status = Status::kFailed;
  const auto& orientation = photo->exterior.orientation;
  photo->exterior.findings = {{.reason = Reason::kScanOrientationExcluded,
                               .at_best = Status::kFailed,
                               .where = orientation ? std::string(Name(*orientation)) : "unknown"}};
}

}  // namespace

BlockPhotoFile ReadBlockPhoto(const std::string& path, const std::string& result_path,
                              const CameraFile& camera, const interior::MarkShapes& marks,
                              const std::string& interior_directory) {
  BlockPhotoFile photo;
  photo.name = PhotoName(path);
  photo.path = path;
  photo.result_path = result_path;
  photo.exterior = ReadExteriorResult(result_path);
  if (!photo.exterior.covariance) photo.exterior.pose.reset();
  if (!photo.HasPose()) return photo;
  TakeFilmPosition(camera, marks, interior_directory, &photo);
  for (const Eigen::Vector3d& corner : photo.exterior.footprint_m)
    photo.footprint.Include(corner.x(), corner.y());
  return photo;
}

std::string DigestOfPhoto(const BlockPhotoFile& photo) {
  return DigestOf({{"name", photo.name},
                   {"scan", DigestOfFile(photo.path)},
                   {"exterior", Digest(ReadFile(photo.result_path))},
                   {"has a pose", photo.HasPose() ? "yes" : "no"}});
}

GroundSurface SurfaceUnder(const BlockFile& block, const std::vector<BlockPhotoFile>& photos) {
  Bounds all = Bounds::OfNothing();
  for (const BlockPhotoFile& photo : photos) {
    if (photo.footprint.Empty()) continue;
    all.Include(photo.footprint.min_x, photo.footprint.min_y);
    all.Include(photo.footprint.max_x, photo.footprint.max_y);
  }
  return GroundSurface::FromFile(block.dem, block.crs, all);
}

std::vector<std::size_t> NeighboursOf(const std::vector<BlockPhotoFile>& photos,
                                      std::size_t photo) {
  std::vector<std::size_t> neighbours;
  if (!photos[photo].HasPose()) return neighbours;
  for (std::size_t i = 0; i < photos.size(); ++i)
    if (i != photo && photos[i].HasPose() && photos[i].footprint.Overlaps(photos[photo].footprint))
      neighbours.push_back(i);
  return neighbours;
}

OpenPhotos::OpenPhotos(const std::vector<BlockPhotoFile>& photos,
                       const std::vector<std::size_t>& which, std::size_t owner,
                       const Camera& camera) {
  for (const std::size_t i : which) {
    const BlockPhotoFile& photo = photos[i];
    if (i == owner) owner_ = photos_.size();
    try {
      rasters_.push_back(std::make_unique<Raster>(Raster::OpenScan(photo.path)));
    } catch (const InputError&) {
      if (i == owner) throw;
      continue;  // told where it is itself the owner
    }
    images_.push_back(std::make_unique<exterior::PhotoImage>(*rasters_.back(), photo.negative));
    photos_.push_back(
        {photo.name, photo.View(camera), *photo.exterior.covariance, images_.back().get()});
  }
}

bool SamePose(const Pose& a, const Pose& b) {
  constexpr double kDistance_m = 2e-4, kAngle_rad = 1e-9;
  const Vector6d off = PoseDifference(a, b).cwiseAbs();
  return off.head<3>().maxCoeff() < kDistance_m && off.tail<3>().maxCoeff() < kAngle_rad;
}

std::string PoseContradiction(const OrientationRow& row, const ExteriorResult& exterior) {
  if (exterior.pose && exterior.status != Status::kFailed && SamePose(row.pose, *exterior.pose))
    return "";
  return fmt::format(
      "orientation.csv and {0}.exterior.json state different poses of {0}: they are of different "
      "runs, or one was edited; orient the photos again with --overwrite",
      row.photo);
}

}  // namespace orient::block

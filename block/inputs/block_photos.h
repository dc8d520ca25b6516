// The photos of a block as their result files describe them: what ties and adjustment start from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "block/ties/tie_points.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/geometry/bounds.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "exterior/orient_photo.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {

struct BlockPhotoFile {
  std::string name, path;
  std::string result_path;  // of the exterior result
  ExteriorResult exterior;  // of this photo alone, or of its neighbours' patches
  bool by_neighbours = false;
  ExteriorResult alone;    // the photo's own result, if oriented by neighbours
  std::string located_by;  // how it was located, if its approximation was not enough
  // Where it has a pose:
  exterior::FilmPosition position;
  bool negative = false;
  Bounds footprint = Bounds::OfNothing();

  bool HasPose() const { return exterior.pose.has_value(); }
  PhotoView View(const Camera& camera) const {
    return {camera, position.photo_from_pixel, *exterior.pose, position.film_correction};
  }
  // With the principal distance that was estimated with the pose, where it was: what the photo
  // shows by its own result.
  PhotoView ViewOfResult(const Camera& camera) const {
    PhotoView view = View(camera);
    if (exterior.principal_distance)
      view.camera.principal_distance_mm = exterior.principal_distance->value_mm;
    return view;
  }
};

// Reads an exterior result and, where it has a pose, the film position that belongs to it. A photo
// whose interior orientation is not of this scan orientation any more has no pose.
BlockPhotoFile ReadBlockPhoto(const std::string& path, const std::string& result_path,
                              const CameraFile& camera, const interior::MarkShapes& marks,
                              const std::string& interior_directory);

// Digest of all that its neighbours' results depend on: its scan, its exterior result and what that
// was made from. Throws InputError where the result cannot be read.
std::string DigestOfPhoto(const BlockPhotoFile& photo);

// Of the DEM under all photos' footprints. Throws InputError where there is none.
GroundSurface SurfaceUnder(const BlockFile& block, const std::vector<BlockPhotoFile>& photos);

// Indices of the other photos with a pose whose footprints touch this one's.
std::vector<std::size_t> NeighboursOf(const std::vector<BlockPhotoFile>& photos, std::size_t photo);

// Photos with their images open; owned here, referred to by TiePhoto::image.
class OpenPhotos {
 public:
  // In the order of `which`. Those that cannot be opened are left out, but for the `owner`: throws
  // InputError then.
  OpenPhotos(const std::vector<BlockPhotoFile>& photos, const std::vector<std::size_t>& which,
             std::size_t owner, const Camera& camera);
  const std::vector<TiePhoto>& Photos() const { return photos_; }
  std::size_t Owner() const { return owner_; }  // index into Photos()

 private:
  std::vector<std::unique_ptr<Raster>> rasters_;
  std::vector<std::unique_ptr<exterior::PhotoImage>> images_;
  std::vector<TiePhoto> photos_;
  std::size_t owner_ = 0;
};

// Whether poses are equal to the decimals with which they are written.
bool SamePose(const Pose& a, const Pose& b);

// Why a row of the folder's table of poses and the photo's result do not belong together; empty if
// they do. Photos without a pose have no row.
std::string PoseContradiction(const OrientationRow& row, const ExteriorResult& exterior);

}  // namespace orient::block

// What `orient convert` converts: an oriented block, read from Orient's results or another
// program's files, in the coordinates of the block's CRS.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"
#include "core/files/camera_file.h"
#include "core/geometry/camera.h"
#include "core/terrain/crs.h"
#include "tools/convert/exchange_format.h"

namespace orient {

struct ConvertSource {
  ExchangeBlock block;          // in the block's CRS, nothing subtracted
  std::vector<Camera> cameras;  // digital, with their own lens; one for each of block.cameras
  std::vector<std::optional<double>> ground_height_m;  // mean ground under each photo, where known
  // Of Orient's own results: the photos' camera, the one that their poses are true with.
  std::optional<CameraFile> camera_of_poses;
  std::optional<Crs> crs;
  std::vector<std::string> messages;  // what a reader must know: approximations, left-out photos
};

struct ConvertSourceOptions {
  std::string input;   // folder or file
  std::string camera;  // camera file; may be empty where the format holds cameras
  std::optional<std::string>
      interior;  // folder of interior orientations, default: the input folder
  std::optional<double> pixel_size_um;  // of resampled film images
  bool remove_distortion = false;       // of resampled film images
  std::string image_extension = ".tif";
  std::string crs;                // if the input states none
  std::optional<double> geoid_m;  // of the file's heights, see GroundFrame
  std::optional<double> ground_height_m;
  // What was subtracted from the ground coordinates of formats that cannot say it (COLMAP).
  std::optional<Eigen::Vector3d> origin;
  // Of an OpenSfM reconstruction whose poses are projected: see opensfm_ground.h.
  std::optional<Eigen::Vector2d> opensfm_offset;
};

// The camera of the image into which photos of `camera` are resampled: the photo system's pixel
// grid over the frame, `pixel_mm` wide; the film's deformation, and with `remove_distortion` the
// lens's, are gone. A digital camera keeps its pixels.
Camera ImageCamera(const Camera& camera, double pixel_mm, bool remove_distortion);

// The folder that an input (folder or file) is or lies in.
std::string FolderOf(const std::string& input);

// From the folder of `orient block` or `orient exterior` (orientation.csv, the photos' results) or
// an OPK CSV. Throws InputError.
ConvertSource ReadOrientResults(const ConvertSourceOptions& options);
// From another program's files.
ConvertSource ReadForeign(ExchangeFormat format, const ConvertSourceOptions& options);

// Pixel size of the film's scans (mm), the mean of the interior orientations; empty where none is.
std::optional<double> MeanPixelSize(const std::string& interior_directory);

}  // namespace orient

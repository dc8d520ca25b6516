#include "tools/commands/estimate_camera.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <ostream>

#include "block/inputs/camera_library.h"
#include "block/roll/camera_estimation.h"
#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

// The scans' mean affinity below which a scanner counts as photogrammetric: 1.5e-4 of its own, and
// as much again from start positions that are off by some hundredths of a millimetre.
constexpr double kPhotogrammetricAffinity = 5e-4;

size_t IndexOf(const std::string& id, const CameraFile& camera, const std::string& path) {
  for (size_t i = 0; i < camera.fiducials.size(); ++i)
    if (camera.fiducials[i].id == id) return i;
  throw InputError(path + " has a mark \"" + id + "\", which is not in the camera file; give " +
                   "the camera file with which the photos were oriented");
}

// Pixels to millimetres by the pixel size and the way the film lies alone: the affine transform
// would carry the start positions' shape into the scan.
block::ScanOfMarks ScanOf(const InteriorResult& result, const CameraFile& camera,
                          const std::string& path) {
  block::ScanOfMarks scan{result.photo, {}};
  scan.place_mm.resize(camera.fiducials.size());
  const Affine2d& affine = result.photo_from_pixel.value();
  const double pixel_mm = std::sqrt(std::abs(affine.A.determinant()));
  const Eigen::Matrix2d axes = PhotoFromPixelAxes(NearestScanOrientation(affine)) * pixel_mm;
  for (const MarkResult& mark : result.marks) {
    const size_t index = IndexOf(mark.id, camera, path);
    if (mark.state == MarkState::kUsed && mark.pixel)
      scan.place_mm[index] = Eigen::Vector2d(axes * *mark.pixel);
  }
  return scan;
}

struct Scans {
  std::vector<block::ScanOfMarks> scans;
  int open = 0;  // whose orientation is open
};

Scans ReadScans(const std::vector<std::string>& directories, const CameraFile& camera) {
  Scans scans;
  for (const std::string& directory : directories)
    for (const std::string& path : InteriorResultPaths(directory)) {
      const InteriorResult result = ReadInteriorResult(path);
      if (result.status == Status::kFailed || !result.photo_from_pixel) continue;
      scans.scans.push_back(ScanOf(result, camera, path));
      scans.open += result.possible_orientations.size() > 1 ? 1 : 0;
    }
  if (scans.scans.size() < 3)
    throw InputError(directories.front() + ": " + std::to_string(scans.scans.size()) +
                     " photos with an interior orientation; at least three are needed");
  return scans;
}

block::CameraEstimate Estimate(const Scans& scans, const CameraFile& camera,
                               const std::string& scanner, block::CommonAffinity* common) {
  std::vector<Eigen::Vector2d> start;
  for (const Fiducial& f : camera.fiducials) start.push_back(f.position_mm);
  *common = scanner == "photogrammetric" ? block::CommonAffinity::kSmall
                                         : block::CommonAffinity::kUnknown;
  auto estimate = block::EstimateCamera(scans.scans, start, *common);
  if (estimate && scanner == "auto" &&
      std::hypot(estimate->mean_difference, estimate->mean_shear) < kPhotogrammetricAffinity) {
    *common = block::CommonAffinity::kSmall;
    estimate = block::EstimateCamera(scans.scans, start, *common);
  }
  if (!estimate)
    throw InputError("too few observations: at least three photos must have three marks, " +
                     std::string("and four marks must be seen in two photos or more"));
  return *estimate;
}

void Print(const CameraFile& camera, const block::CameraEstimate& estimate,
           block::CommonAffinity common, int open, std::ostream& out) {
  SummaryTable table({"mark", "x mm", "y mm", "sigma x um", "sigma y um", "moved um"});
  for (size_t i = 0; i < camera.fiducials.size(); ++i) {
    const Eigen::Vector2d& at = estimate.position_mm[i];
    const double moved = 1e3 * (at - camera.fiducials[i].position_mm).norm();
    table.AddRow({camera.fiducials[i].id, Fixed(at.x(), 4), Fixed(at.y(), 4),
                  Fixed(1e3 * estimate.sigma_mm[i].x(), 1),
                  Fixed(1e3 * estimate.sigma_mm[i].y(), 1), Fixed(moved, 1)});
  }
  table.Print(out);
  out << estimate.scans << " scans, " << estimate.measured << " marks measured, "
      << estimate.rejected << " of them rejected; noise " << Fixed(estimate.noise_um, 1)
      << " um, affinity from scan to scan " << Fixed(1e4 * estimate.affinity, 2) << "e-4\n";
  out << "Shift, rotation and scale are those of the start file: scans cannot determine them.\n";
  if (common == block::CommonAffinity::kUnknown)
    out << "The scans have an affinity in common (difference of scales "
        << Fixed(100 * estimate.mean_difference, 3) << " %, shear "
        << Fixed(1e3 * estimate.mean_shear, 2)
        << " mrad), which cannot be separated from the camera's shape: the start file's affine "
           "shape is kept.\n";
  else
    out << "The scanner is assumed to be photogrammetric: its own affinity of 1.5e-4 is in the "
           "sigmas.\n";
  if (open > 0)
    out << "The scan orientation is open in " << open
        << " photos; it is assumed to be the same for all. Give 'orient interior' --orientation if "
           "not.\n";
}

}  // namespace

bool EstimateCameraCommand::Asked() const { return app_ != nullptr && app_->parsed(); }

void EstimateCameraCommand::Setup(CLI::App& interior) {
  app_ = interior.add_subcommand(
      "estimate-camera", "Estimate the mark positions of a camera without calibration certificate");
  app_->add_option("DIR", directories_, "Folders with results of 'orient interior'")->required();
  app_->add_option("--camera", start_,
                   "Camera file, or library name, with which the photos were oriented")
      ->required();
  app_->add_option("--out", out_, "Camera file to write")->required();
  app_->add_option("--scanner", scanner_,
                   "photogrammetric: the scans determine the camera's affine shape")
      ->check(CLI::IsMember({"auto", "photogrammetric", "desktop"}))
      ->capture_default_str();
  AddCameraLibraryOption(*app_, &library_);
  AddOverwriteOption(*app_, &overwrite_);
  app_->preparse_callback([&interior](size_t) {
    for (CLI::Option* option : interior.get_options()) option->required(false);
  });
}

ExitCode EstimateCameraCommand::Run(std::ostream& out) const {
  RefuseToOverwrite({out_}, overwrite_);
  const std::string camera_file = block::FindCameraFile(start_, library_);
  RefuseToReplaceInputs({out_}, {camera_file});
  CameraFile camera = ReadCameraFile(camera_file);
  if (camera.fiducials.empty())
    throw InputError(start_ + ": has no fiducials whose positions could be estimated");
  const Scans scans = ReadScans(directories_, camera);
  block::CommonAffinity common = block::CommonAffinity::kUnknown;
  const block::CameraEstimate estimate = Estimate(scans, camera, scanner_, &common);
  Print(camera, estimate, common, scans.open, out);
  for (const size_t i : estimate.shown) {
    camera.fiducials[i].position_mm = estimate.position_mm[i];
    camera.fiducials[i].sigma_mm = estimate.sigma_mm[i];
  }
  camera.camera.name += fmt::format(", marks estimated from {} scans", estimate.scans);
  WriteCameraFile(out_, camera);
  return ExitCode::kAllDone;
}

}  // namespace orient

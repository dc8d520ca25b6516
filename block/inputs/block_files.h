// Files that a block's run leaves beside its photos' results, by their names in the output folder.
#pragma once

namespace orient::block {

inline constexpr const char* kQuicklookFile = "quicklook.png";
inline constexpr const char* kSeamsFile = "seams.png";
inline constexpr const char* kCalibratedCameraFile = "calibrated_camera.toml";
inline constexpr const char* kPoseCovarianceFile = "pose_covariance.csv";
inline constexpr const char* kExportsFolder = "exports";
// The lock (core/base/folder_lock.h) that a run holds in it, of one stage too.
inline constexpr const char* kBlockLock = ".orient-block.lock";

// Of a photo, after its name: the whole scan where the photo is not ok.
inline constexpr const char* kMarksOverview = ".marks_overview.png";
inline constexpr const char* kPatchesOverview = ".patches_overview.png";
// The scan, small.
inline constexpr const char* kThumbnail = ".thumbnail.png";

}  // namespace orient::block

// Files that a block's run leaves beside its photos' results, by their names in the output folder.
#pragma once

#include <array>
#include <string>
#include <vector>

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

// What runs write or remove in their folder: files that concern it as a whole, and what follows the
// photos' names.
inline constexpr std::array kInteriorFiles = {"interior.csv", "marks.csv", "contact_sheet.png",
                                              "run.json"};
inline constexpr std::array kExteriorFiles = {
    "orientation.csv", "orientation.prj",     "block_camera.toml", "run.json", "block.json",
    kQuicklookFile,    kCalibratedCameraFile, kPoseCovarianceFile, kSeamsFile};
// A block's, beside those of the stages.
inline constexpr std::array kBlockFiles = {"control_points.csv", "block.gpkg", "block.qgz",
                                           "report.html"};
inline constexpr std::array kPhotoFiles = {".interior.json", ".exterior.json", ".marks.png",
                                           ".patches.png",   kMarksOverview,   kPatchesOverview,
                                           kThumbnail};

// Their paths; `photos`: names.
std::vector<std::string> InteriorFiles(const std::string& directory);
std::vector<std::string> ExteriorFiles(const std::string& directory);
std::vector<std::string> BlockFiles(const std::string& directory);  // with those of the stages
std::vector<std::string> PhotoFiles(const std::string& directory,
                                    const std::vector<std::string>& photos);

}  // namespace orient::block

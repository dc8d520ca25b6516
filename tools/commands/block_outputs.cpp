#include "tools/commands/block_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "block/block_folder.h"
#include "block/inputs/block_camera.h"
#include "block/inputs/block_files.h"
#include "block/inputs/measurement_inputs.h"
#include "block/pictures/scan_overview.h"
#include "block/stages/exterior_inputs.h"
#include "block/stages/exterior_stage.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/base/side_by_side.h"
#include "core/raster/raster.h"
#include "tools/commands/ortho_run.h"
#include "tools/commands/shared_options.h"
#include "tools/convert/write_exports.h"
#include "tools/report/block_record.h"
#include "tools/report/gis/block_geopackage.h"
#include "tools/report/report.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::optional<block::Quicklook> MakeQuicklook(const BlockFile& block,
                                              const block::OrientedBlock& oriented) {
  std::vector<block::QuicklookPhoto> photos;
  for (std::size_t i = 0; i < oriented.photos.size(); ++i) {
    const ExteriorResult& result = oriented.results[i];
    if (!result.pose || result.status == Status::kFailed) continue;
    const block::BlockPhotoFile& photo = oriented.photos[i];
    photos.push_back({photo.name,
                      photo.path,
                      {oriented.camera.camera, photo.position.photo_from_pixel, *result.pose,
                       photo.position.film_correction},
                      photo.negative});
  }
  if (photos.empty()) return std::nullopt;
  return block::WriteQuicklook(block.output_directory, photos,
                               block::SurfaceUnder(block, oriented.photos));
}

// Removes what an earlier run left and this one does not write.
void RemoveStale(const BlockFile& block) {
  const fs::path out(block.output_directory);
  std::error_code ignored;
  for (const char* file : {block::kQuicklookFile, block::kSeamsFile})
    fs::remove(out / file, ignored);
  RemoveExportsOf(block.output_directory);
  for (const UnusablePhoto& photo : block.unusable)
    for (const char* file : {".patches.png", ".marks.png", ".interior.json", block::kMarksOverview,
                             block::kPatchesOverview})
      fs::remove(out / (photo.name + file), ignored);
  for (const std::string& path : block.photos)
    fs::remove(out / (PhotoName(path) + block::kThumbnail), ignored);
}

// Writes thumbnails of the scans that can be read.
void WriteThumbnails(const BlockFile& block) {
  SideBySide(block.photos.size(), [&](std::size_t i) {
    const std::string& path = block.photos[i];
    try {
      block::WriteThumbnail(
          (fs::path(block.output_directory) / (PhotoName(path) + block::kThumbnail)).string(),
          Raster::OpenScan(path));
    } catch (const std::exception&) {  // a damaged scan is reported in its photo's own result
      RethrowIfMachineFault();
    }
  });
}

// A picture that cannot be drawn does not affect any result.
std::optional<block::Quicklook> Illustrate(const BlockFile& block, block::OrientedBlock* oriented) {
  try {
    auto quicklook = MakeQuicklook(block, *oriented);
    if (!quicklook) return std::nullopt;
    for (const std::string& photo : quicklook->left_out)
      oriented->findings.push_back({.reason = Reason::kPhotoNotInQuicklook, .where = photo});
    return quicklook;
  } catch (const std::exception& error) {
    RethrowIfMachineFault();
    oriented->findings.push_back({.reason = Reason::kNoQuicklook, .where = error.what()});
    return std::nullopt;
  }
}

void WriteExportsTo(const BlockFile& block, block::OrientedBlock* result) {
  const auto oriented = [](const ExteriorResult& photo) { return photo.pose.has_value(); };
  if (block.formats.empty() ||
      std::none_of(result->results.begin(), result->results.end(), oriented))
    return;
  const std::string& out = block.output_directory;
  try {
    const ExportsOfFolder exports = WriteExportsOf(out, block::BlockCameraPath(out), block.formats);
    result->findings.insert(result->findings.end(), exports.findings.begin(),
                            exports.findings.end());
  } catch (const InputError& error) {
    throw InputError(fmt::format("the block is done and written to {}, but not exported: {}", out,
                                 error.what()));
  }
}

// The photo to which a result file belongs; empty for other files.
std::string PhotoOf(const fs::path& file) {
  const std::string name = file.filename().string();
  for (const std::string suffix : {".exterior.json", ".interior.json"})
    if (name.ends_with(suffix)) return name.substr(0, name.size() - suffix.size());
  return "";
}

// `path`, or where that is taken, path_2, path_3 and so on.
fs::path FreshFolder(const fs::path& path) {
  fs::path fresh = path;
  for (int i = 2; fs::exists(fresh); ++i) fresh = fmt::format("{}_{}", path.string(), i);
  return fresh;
}

// Returns a finding, if anything was moved.
std::optional<Finding> SetOtherPhotosAside(const BlockFile& block,
                                           const block::OrientedBlock& oriented) {
  const fs::path out(block.output_directory);
  std::set<std::string> photos, others;
  // Of a block by image measurements all of them: what was made from scans is none of its results.
  if (!block.ByMeasurementsAlone())
    for (const ExteriorResult& result : oriented.results) photos.insert(result.photo);
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(out, ignored))
    if (const std::string photo = PhotoOf(entry.path()); !photo.empty() && !photos.contains(photo))
      others.insert(photo);
  if (others.empty()) return std::nullopt;
  const fs::path aside = FreshFolder(out / "not_in_block");
  MakeOutputDirectory(aside.string());
  const block::ResultStore stage =
      block::ExteriorStore(block::StageDirectory(block.output_directory, "exterior"));
  for (const std::string& photo : others) {
    for (const char* file : block::kPhotoFiles)
      fs::rename(out / (photo + file), aside / (photo + file), ignored);
    stage.Drop(photo);  // a photo that comes back is oriented, and drawn, again
  }
  return Finding{.reason = Reason::kOtherPhotosSetAside,
                 .value = static_cast<double>(others.size()),
                 .where = fmt::format("{}: {}", aside.string(), fmt::join(others, ", "))};
}

}  // namespace

void WriteBlockReport(const BlockFile& block, const block::OrientedBlock& oriented) {
  BlockRecord record = ReadBlockRecord(block.output_directory, oriented.adjusted);
  record.notes = Sentences(oriented.findings);
  WriteReport(record, Judge(record));
}

std::optional<block::Quicklook> WriteBlockOutputs(const BlockFile& block, bool quicklook,
                                                  block::OrientedBlock* oriented) {
  block::OrientedBlock& result = *oriented;
  const std::string& out = block.output_directory;
  if (const auto told = SetOtherPhotosAside(block, result)) result.findings.push_back(*told);
  RemoveStale(block);
  for (const ExteriorResult& photo : result.results) WriteExteriorResult(out, photo);
  block::WritePoseTable(out, result.results, block.crs);
  block::WriteBlockCamera(out, result.camera);
  std::optional<block::Quicklook> pictures;
  if (quicklook) {
    WriteThumbnails(block);
    pictures = Illustrate(block, &result);
  }
  if (result.adjusted) {
    result.adjusted->findings = result.findings;
    WriteAdjustmentResult(out, *result.adjusted);
  }
  WriteBlockGeopackage(out, block.crs, result.results,
                       result.adjusted ? &*result.adjusted : nullptr);
  WriteBlockReport(block, result);
  WriteExportsTo(block, &result);
  return pictures;
}

void RequireInputsApart(const BlockFile& block, const std::string& path) {
  std::vector<std::string> inputs = block.photos;
  for (const std::string& input :
       {path, block.camera, block.dem, block.patchdb, block.approximations, block.gnss.positions})
    inputs.push_back(input);
  Append(MeasurementFiles(block.measurements), &inputs);
  if (const auto& control = block.control)
    for (const std::string& input : {control->camera, control->orientation, control->dsm})
      inputs.push_back(input);
  const std::string& out = block.output_directory;
  RefuseToReplacePatches(out);
  const std::vector<std::string> photos = block::PhotoNames(block.photos);
  std::vector<std::string> results = block::BlockFiles(out);
  Append(block::PhotoFiles(out, photos), &results);
  if (block.ortho) Append(OrthophotoFiles((fs::path(out) / "ortho").string(), photos), &results);
  RefuseToReplaceInputs(results, inputs);
}

}  // namespace orient

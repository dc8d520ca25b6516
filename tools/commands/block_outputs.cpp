#include "tools/block/block_outputs.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/error.h"
#include "core/files/orientation_table.h"
#include "tools/block_camera.h"
#include "tools/block_files.h"
#include "tools/block_geopackage.h"
#include "tools/convert/write_exports.h"
#include "tools/report/block_record.h"
#include "tools/report/report.h"
#include "tools/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Files of a photo in the output folder.
constexpr const char* kPhotoFiles[] = {".exterior.json", ".interior.json", ".patches.png",
                                       ".marks.png"};

// `results` begins with those of the photos, in their order.
std::optional<Quicklook> MakeQuicklook(const BlockOutputs& outputs,
                                       const std::vector<ExteriorResult>& results) {
  std::vector<QuicklookPhoto> photos;
  for (std::size_t i = 0; i < outputs.photos.size(); ++i) {
    if (!results[i].pose || results[i].status == Status::kFailed) continue;
    const BlockPhotoFile& photo = outputs.photos[i];
    photos.push_back({photo.name,
                      photo.path,
                      {outputs.camera.camera, photo.position.photo_from_pixel, *results[i].pose,
                       photo.position.film_correction},
                      photo.negative});
  }
  if (photos.empty()) return std::nullopt;
  return WriteQuicklook(outputs.block.output_directory, photos,
                        SurfaceUnder(outputs.block, outputs.photos));
}

// What an earlier run left and this one does not write.
void RemoveStale(const BlockFile& block) {
  const fs::path out(block.output_directory);
  std::error_code ignored;
  for (const char* file : {kQuicklookFile, kSeamsFile, kExportsFolder})
    fs::remove_all(out / file, ignored);
  for (const UnusablePhoto& photo : block.unusable)
    for (const char* file : {".patches.png", ".marks.png", ".interior.json"})
      fs::remove(out / (photo.name + file), ignored);
}

// A picture that cannot be drawn costs no result.
void Illustrate(const BlockOutputs& outputs, BlockRunResult* result) {
  try {
    result->quicklook = MakeQuicklook(outputs, result->results);
    if (!result->quicklook) return;
    for (const std::string& photo : result->quicklook->left_out)
      result->messages.push_back("photo " + photo + " could not be read for the quicklook");
  } catch (const std::exception& error) {
    result->messages.push_back(std::string("no quicklook: ") + error.what());
  }
}

void WriteExportsTo(const BlockFile& block, BlockRunResult* result) {
  const auto oriented = [](const ExteriorResult& photo) { return photo.pose.has_value(); };
  if (block.formats.empty() ||
      std::none_of(result->results.begin(), result->results.end(), oriented))
    return;
  const std::string& out = block.output_directory;
  try {
    const ExportsOfFolder exports = WriteExportsOf(out, BlockCameraPath(out), block.formats);
    result->messages.insert(result->messages.end(), exports.messages.begin(),
                            exports.messages.end());
  } catch (const InputError& error) {
    throw InputError("the block is done and written to " + out +
                     ", but not exported: " + error.what());
  }
}

// The photo that a result file is of; empty for other files.
std::string PhotoOf(const fs::path& file) {
  const std::string name = file.filename().string();
  for (const std::string suffix : {".exterior.json", ".interior.json"})
    if (name.ends_with(suffix)) return name.substr(0, name.size() - suffix.size());
  return "";
}

// `path`, or where that is taken, path_2, path_3 and so on.
fs::path FreshFolder(const fs::path& path) {
  fs::path fresh = path;
  for (int i = 2; fs::exists(fresh); ++i) fresh = path.string() + "_" + std::to_string(i);
  return fresh;
}

}  // namespace

std::optional<std::string> SetOtherPhotosAside(const BlockFile& block) {
  const fs::path out(block.output_directory);
  std::set<std::string> photos, others;
  for (const std::string& path : block.photos) photos.insert(PhotoName(path));
  for (const UnusablePhoto& photo : block.unusable) photos.insert(photo.name);
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(out, ignored))
    if (const std::string photo = PhotoOf(entry.path()); !photo.empty() && !photos.contains(photo))
      others.insert(photo);
  if (others.empty()) return std::nullopt;
  const fs::path aside = FreshFolder(out / "not_in_block");
  MakeOutputDirectory(aside.string());
  std::string names;
  for (const std::string& photo : others) {
    names.append(names.empty() ? "" : ", ").append(photo);
    for (const char* file : kPhotoFiles)
      fs::rename(out / (photo + file), aside / (photo + file), ignored);
  }
  return (others.size() == 1 ? "what an earlier run left of a photo that is not in the block ("
                             : "what an earlier run left of " + std::to_string(others.size()) +
                                   " photos that are not in the block (") +
         names + ") was moved to " + aside.string();
}

void WriteBlockOutputs(const BlockOutputs& outputs, BlockRunResult* written) {
  BlockRunResult& result = *written;
  const BlockFile& block = outputs.block;
  const std::string& out = block.output_directory;
  RemoveStale(block);
  OrientationTable table;
  table.crs = block.crs;
  for (const ExteriorResult& photo : result.results) {
    WriteExteriorResult(out, photo);
    if (photo.pose)
      table.rows.push_back(
          {photo.photo, *photo.pose, Vector6d(photo.covariance->diagonal().cwiseSqrt())});
  }
  WriteOrientationTable((fs::path(out) / "orientation.csv").string(), table);
  WriteBlockCamera(out, outputs.camera);
  if (outputs.quicklook) Illustrate(outputs, &result);
  if (result.adjusted) {
    result.adjusted->messages = result.messages;
    WriteAdjustmentResult(out, *result.adjusted);
  }
  WriteBlockGeopackage(out, block.crs, result.results,
                       result.adjusted ? &*result.adjusted : nullptr);
  BlockRecord record = ReadBlockRecord(out, result.adjusted);
  record.notes = result.messages;
  WriteReport(record);
  WriteExportsTo(block, &result);
}

}  // namespace orient

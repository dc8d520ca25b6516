#include "tools/commands/block/block_control.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>

#include "block/inputs/camera_library.h"
#include "block/inputs/digest.h"
#include "block/stages/harvest_stage.h"
#include "core/base/atomic_write.h"
#include "core/base/output_directory.h"
#include "core/files/inputs.h"
#include "patchdb/store/patch_database.h"
#include "tools/commands/harvested.h"
#include "tools/commands/progress.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Beside the database, in the form of every result's "made_from".
std::string RecordPath(const BlockFile& block) { return block.patchdb + ".json"; }

Inputs InputsOf(const BlockFile& block) {
  const ControlChoice& control = *block.control;
  Inputs inputs = {{"crs", block.crs.Wkt()},
                   {"dem", block::DigestOfRaster(block.dem)},
                   {"dem_sigma_m", fmt::format("{}", control.dem_sigma_m.value_or(0))},
                   {"date", control.date.value_or("")}};
  if (!control.dsm.empty()) inputs["dsm"] = block::DigestOfRaster(control.dsm);
  for (const std::string& path : control.orthophotos)
    inputs["orthophoto " + path] = block::DigestOfRaster(path);
  for (const std::string& path : control.photos)
    inputs["photo " + path] = block::DigestOfFile(path);
  if (!control.orientation.empty()) {
    inputs["orientation"] = block::DigestOfFile(control.orientation);
    inputs["camera"] = control.camera + block::DigestOfFile(control.camera);
    inputs["interior"] = control.interior;
  }
  return inputs;
}

void WriteRecord(const BlockFile& block, const Inputs& inputs) {
  const nlohmann::ordered_json json = {{"made_from", inputs}};
  WriteFileAtomically(RecordPath(block), json.dump(2) + "\n");
}

block::HarvestRun RunOf(const BlockFile& block) {
  const ControlChoice& control = *block.control;
  block::HarvestRun run{.dem = block.dem, .dsm = control.dsm, .about = {}, .options = {}};
  if (!control.orthophotos.empty()) run.options = patchdb::OrthoHarvestOptions();
  run.options.max_further_views = 0;
  run.options.dem_sigma_m = control.dem_sigma_m;
  if (control.date) run.about.date = *control.date;
  return run;
}

}  // namespace

bool NeedsBlockControl(const BlockFile& block) {
  return block.control &&
         (!fs::exists(block.patchdb) || ReadMadeFrom(RecordPath(block)) != InputsOf(block));
}

void MakeBlockControl(const BlockFile& block, const std::string& camera_library,
                      std::ostream& out) {
  if (!block.control || !NeedsBlockControl(block)) return;
  const ControlChoice& control = *block.control;
  MakeOutputDirectory(block.output_directory);
  for (const char* suffix : {"", "-wal", "-shm", ".json"}) fs::remove(block.patchdb + suffix);
  const block::HarvestRun run = RunOf(block);
  std::vector<block::HarvestedSource> sources;
  patchdb::PatchDatabase::Create(block.patchdb, block.crs, [&](patchdb::PatchDatabase& database) {
    ShownProgress progress;
    if (!control.orthophotos.empty()) {
      sources = block::HarvestOrthophotos(database, run, control.orthophotos, &progress);
      return;
    }
    block::PhotosToHarvest photos;
    photos.orientation_path = control.orientation;
    photos.interior_folder = control.interior;
    photos.earth = block.earth;
    ReadPhotosToHarvest(block::FindCameraFile(control.camera, camera_library), control.photos,
                        block.patchdb, database, &photos);
    sources = block::HarvestPhotos(database, run, photos, &progress);
  });
  WriteRecord(block, InputsOf(block));
  out << "control " << block.patchdb << "\n";
  PrintHarvest(sources, !run.dsm.empty(), out);
  out << "\n";
}

}  // namespace orient

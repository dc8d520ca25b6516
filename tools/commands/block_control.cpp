#include "tools/commands/block_control.h"

#include <fmt/format.h>

#include <filesystem>
#include <ostream>

#include "block/inputs/camera_library.h"
#include "block/inputs/digest.h"
#include "block/stages/harvest_stage.h"
#include "core/base/folder_lock.h"
#include "core/base/output_directory.h"
#include "core/files/camera_file.h"
#include "core/files/inputs.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "patchdb/store/patch_database.h"
#include "tools/commands/harvested.h"
#include "tools/commands/progress.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Adds the photos' poses and what determines how their scans lie.
void AddPhotos(const ControlChoice& control, const std::string& camera_library, Inputs* inputs) {
  const std::string folder = fs::path(control.orientation).parent_path().string();
  (*inputs)["orientation"] = block::DigestOfContents(control.orientation);
  (*inputs)["crs of the orientation"] =
      block::DigestOfContents(fs::path(control.orientation).replace_extension(".prj").string());
  (*inputs)["camera"] =
      block::DigestOfCamera(ReadCameraFile(block::FindCameraFile(control.camera, camera_library)));
  for (std::size_t i = 0; i < control.photos.size(); ++i) {
    const std::string name = PhotoName(control.photos[i]);
    (*inputs)[fmt::format("photo {}", i)] = name + block::DigestOfFile(control.photos[i]);
    (*inputs)[fmt::format("interior {}", i)] =
        block::DigestOfContents(InteriorResultPath(control.interior, name));
    (*inputs)[fmt::format("exterior {}", i)] =
        block::DigestOfContents(ExteriorResultPath(folder, name));
  }
}

// Files by their place in the list and their content: the working directory does not matter.
Inputs InputsOf(const BlockFile& block, const std::string& camera_library) {
  const ControlChoice& control = *block.control;
  Inputs inputs = {{"crs", block.crs.Wkt()},
                   {"dem", block::DigestOfRaster(block.dem)},
                   {"dem_sigma_m", fmt::format("{}", control.dem_sigma_m.value_or(0))},
                   {"earth", fmt::format("{}", static_cast<int>(block.earth))},
                   {"date", control.date.value_or("")}};
  if (control.chip_px) inputs["chip_px"] = fmt::format("{}", *control.chip_px);
  if (!control.dsm.empty()) inputs["dsm"] = block::DigestOfRaster(control.dsm);
  for (std::size_t i = 0; i < control.orthophotos.size(); ++i)
    inputs[fmt::format("orthophoto {}", i)] =
        PhotoName(control.orthophotos[i]) + block::DigestOfRaster(control.orthophotos[i]);
  if (!control.photos.empty()) AddPhotos(control, camera_library, &inputs);
  return inputs;
}

block::HarvestRun RunOf(const BlockFile& block) {
  const ControlChoice& control = *block.control;
  block::HarvestRun run{.dem = block.dem, .dsm = control.dsm, .about = {}, .options = {}};
  if (!control.orthophotos.empty()) run.options = patchdb::OrthoHarvestOptions();
  run.options.max_further_views = 0;
  run.options.dem_sigma_m = control.dem_sigma_m;
  if (control.chip_px) run.options.chip_px = *control.chip_px;
  if (control.date) run.about.date = *control.date;
  return run;
}

}  // namespace

bool FindBlockControl(const std::string& camera_library, BlockFile* block) {
  if (!block->control) return true;
  const std::string digest = block::DigestOf(InputsOf(*block, camera_library));
  block->patchdb =
      (fs::path(block->output_directory) / fmt::format("control_{}.gpkg", digest)).string();
  return fs::exists(block->patchdb);
}

void MakeBlockControl(const std::string& camera_library, const BlockFile& block,
                      std::ostream& out) {
  const ControlChoice& control = *block.control;
  MakeOutputDirectory(block.output_directory);
  const FolderLock lock(block.output_directory, ".orient-control.lock");
  if (fs::exists(block.patchdb)) return;  // made meanwhile
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
  out << "control " << block.patchdb << "\n";
  PrintHarvest(sources, !run.dsm.empty(), out);
  out << "\n";
}

}  // namespace orient

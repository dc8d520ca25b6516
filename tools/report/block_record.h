// Everything an output folder says about a block: what the report and block.gpkg are made from.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/files/adjustment_result.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/geometry/camera.h"
#include "core/terrain/crs.h"
#include "tools/report/figures/ortho_figures.h"
#include "tools/report/run_record.h"

namespace orient {

struct PhotoRecord {
  std::string name;
  std::optional<InteriorResult> interior;
  std::optional<ExteriorResult> exterior;
  std::optional<OrientationRow> table_row;  // of orientation.csv
  std::string marks_picture;                // file names in the folder, empty where absent
  std::string patches_picture;
  std::string marks_overview, patches_overview;  // of the whole scan, where the photo was not ok
  std::string thumbnail;                         // of the scan
  std::vector<std::string> unreadable;           // what is wrong with a damaged result file
};

struct BlockRecord {
  std::string directory;
  std::string title;                             // from the folder's name
  std::optional<Crs> crs;                        // of orientation.prj
  std::optional<Camera> camera;                  // of block_camera.toml
  std::vector<PhotoRecord> photos;               // by name
  std::optional<AdjustmentResult> adjusted;      // of block.json
  std::optional<OrthoFolder> ortho;              // of orthophotos, where there are any
  std::string quicklook_picture, seams_picture;  // file names in the folder, empty where absent
  std::map<std::string, RunRecord> runs;         // of run.json, by stage
  std::vector<std::string> notes;                // about the block as a whole
  std::vector<std::string> unreadable;  // about orientation.csv, orientation.prj and block.json

  bool HasExterior() const;  // whether any photo went through exterior orientation
};

// A damaged file is noted in `unreadable`; the others are read. `adjusted`: what block.json says,
// where the caller has it (and it is not read then). Throws InputError where `directory`
// is not a folder or holds no result of any photo.
BlockRecord ReadBlockRecord(const std::string& directory,
                            std::optional<AdjustmentResult> adjusted = std::nullopt);

// The exterior results alone, for block.gpkg; taken from the photos, since they are most of what is
// in memory.
std::vector<ExteriorResult> TakeExteriorResults(BlockRecord* block);

}  // namespace orient

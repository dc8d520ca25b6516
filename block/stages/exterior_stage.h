// Exterior orientation of many photos from files: what `orient exterior` and `orient block` share.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "block/stages/exterior_setting.h"
#include "core/files/results.h"
#include "core/terrain/crs.h"

namespace orient::block {

// Orients the photos side by side, writes each photo's <photo>.exterior.json as soon as it is done
// and at the end orientation.csv with its .prj (photos that are ok or weak). A resumed run does
// those again whose inputs have changed; `orient exterior` refuses to where camera, DEM or options
// have. `done` is called once per photo, from one thread at a time. `changed`: the photos that were
// done again, with the names of the inputs that had changed. A photo that cannot be read fails, the
// others go on. Throws InputError for what concerns all photos: camera, tables, DEM, database, CRS,
// results made with others; UsageError where two photos share a name.
std::vector<ExteriorResult> RunExterior(
    const ExteriorRunOptions& options, const std::function<void()>& done = {},
    std::map<std::string, std::vector<std::string>>* changed = nullptr);

// The photos whose results a resumed run would keep. Reads what all photos share; throws as
// RunExterior does.
std::set<std::string> ExteriorsThatStay(const ExteriorRunOptions& options);

// The table of a folder's poses, orientation.csv, and its writing: of the photos that have one.
std::string PoseTablePath(const std::string& directory);
void WritePoseTable(const std::string& directory, const std::vector<ExteriorResult>& results,
                    const Crs& crs);

}  // namespace orient::block

// What a run of interior orientations leaves beside the photos' own results.
#pragma once

#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"

namespace orient::block {

// Names in DIR, beside contact_sheet.png.
inline constexpr const char* kInteriorTable = "interior.csv";
inline constexpr const char* kMarkTable = "marks.csv";

// Compares the photos with one another (block/roll/roll.h), writes the results of those that change
// anew, and then DIR/interior.csv, DIR/marks.csv and the contact sheet, which show `earlier`
// results of the same camera too. Where the photos have no camera in common (null) they are not
// compared and there is no marks.csv. Everything is derived from the photos' results: after a crash
// a resumed run writes it as if nothing had happened.
void WriteInteriorOutputs(const std::string& directory, const CameraFile* camera,
                          const std::vector<InteriorResult>& earlier,
                          std::vector<InteriorResult>* results);

// DIR/Ori-InterneScan: MeasuresCamera.xml and MeasuresIm-<image>.xml for every photo with a
// transform. `photos` are the scans' paths, in the order of the results.
void WriteMicmacOutputs(const std::string& directory, const CameraFile& camera,
                        const std::vector<std::string>& photos,
                        const std::vector<InteriorResult>& results);

}  // namespace orient::block

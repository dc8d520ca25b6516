// What results of exterior orientation are made from.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "block/stages/exterior_setting.h"
#include "block/stages/result_store.h"
#include "core/files/inputs.h"

namespace orient::block {

// <directory>/<photo>.exterior.json
ResultStore ExteriorStore(const std::string& directory);

// "camera", "dem", "options": what all results in a folder of `orient exterior` have in common. A
// run that goes on there keeps them, and states that all of them hold with its own camera.
Inputs InputsOfRun(const ExteriorRunOptions& options);

// The photos whose results a run over `paths` goes on from: its own where any is there, otherwise
// all of the folder.
std::vector<std::string> OwnResultsFirst(const ResultStore& results,
                                         const std::vector<std::string>& paths);

// Throws InputError where one of these photos' results was made from another of the run's inputs,
// naming them and what to do.
void RequireSameInputs(const ResultStore& results, const std::vector<std::string>& photos,
                       const Inputs& of_run);

// What the run that made these photos' results added to the camera file's lens: more photos, or
// other heights of them, would change it. Empty where no result says.
std::optional<double> EarthK1Of(const ResultStore& results, const std::vector<std::string>& photos);

// A photo's inputs: its run's (ExteriorRunOptions::inputs) and its own "scan", "approximation",
// "accuracy" and, of film, "interior". Scans and interior orientations that cannot be read have
// empty digests.
Inputs InputsOfPhoto(const ExteriorRunOptions& options, const OrientationTable& approximations,
                     const std::string& path);

}  // namespace orient::block

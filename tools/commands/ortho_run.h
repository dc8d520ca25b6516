// Orthophotos of a block's photos and their mosaic, as `orient ortho` and `orient block` make them.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "tools/commands/ortho_photos.h"
#include "tools/report/run_record.h"

namespace orient {

struct OrthoRunOptions {
  OrthoSource source = {};
  std::string out = {};               // folder
  std::vector<RunInput> inputs = {};  // that the seamlines' metadata name
  std::string seams = {};             // file of seamlines; empty: by nearest nadir
  std::optional<double> gsd_m = {};   // empty: what the photos' pixels show
  std::optional<double> border_mm = {};
  double dem_sigma_m = 0;
  int jobs = 0;
  bool mosaic = false;
  bool least_difference = false;  // the seamlines, where none are given
  bool balance = false;           // the photos' tones in the mosaic
  bool overwrite = false;
  bool plan = false;    // only tell what would be done
  bool resume = false;  // keep what was made from the same, and the seamlines that are there
};

// All files that runs with such an output folder may write: the photos' (names), the mosaic's.
std::vector<std::string> OrthophotoFiles(const std::string& folder,
                                         const std::vector<std::string>& photos);

// Tells on `out` what was made, and what not. Returns whether all photos have their orthophoto.
// Throws UsageError where results would be replaced without being asked for, InputError for what
// concerns all photos.
bool MakeOrthophotos(const OrthoRunOptions& options, std::ostream& out);

}  // namespace orient

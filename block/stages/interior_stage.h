// Interior orientation of many scans from files: what `orient interior` and `orient block` share.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/measurements/measurements.h"
#include "interior/interior.h"

namespace orient::block {

// In place of a camera file: find out which camera of the library each scan is from.
inline constexpr const char* kAutoCamera = "auto";

struct InteriorRunOptions {
  std::vector<std::string> photos;  // paths
  std::string camera;               // path of its file, or kAutoCamera
  std::string camera_library;       // folder; for kAutoCamera alone, where empty the program's own
  std::string out;
  interior::InteriorOptions scan;
  Measurements measurements;  // what people said of the photos
  bool resume = false;        // keep results that are there
  // Results made from something else are done again, tables of other results replaced: no error.
  bool redo_changed = false;
  bool alone = false;   // refused where another program writes into `out`; a block sees to that
  int jobs = 0;         // photos at a time; 0: one per core
  bool micmac = false;  // also write MicMac's Ori-InterneScan
  // A part of a run: each photo's own result, and nothing of the photos together.
  bool results_only = false;
  // Photos lie alike on the scanner: together they decide what single ones leave open.
  bool roll_lies_alike = false;
};

// The photos whose results a resumed run would keep. Throws as RunInterior does.
std::set<std::string> InteriorsThatStay(const InteriorRunOptions& options);

// Orients the scans side by side; writes each photo's <photo>.interior.json and <photo>.marks.png
// as soon as it is done, then what the run leaves as a whole (interior_outputs.h). `done` is
// called once per photo, from one thread at a time. A damaged scan fails its photo only. `notes`
// become what a user should know about the run as a whole. Throws UsageError where two photos share
// a name, a result to be kept was made from another camera, scan or other options, a photo's marks
// were clicked but its camera is to be found out or was decided to be another one, or tables in the
// folder are of none of this run's results nor of any that they can join; InputError
// for what concerns all photos.
std::vector<InteriorResult> RunInterior(const InteriorRunOptions& options,
                                        const std::function<void()>& done = {},
                                        std::vector<std::string>* notes = nullptr);

}  // namespace orient::block

// A run's output folder, put into object storage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/progress.h"

namespace orient {

struct UploadOptions {
  bool overwrite = false;  // objects that lie there, but for those of an interrupted upload
  int jobs = 4;            // files sent at a time
};

struct UploadSummary {
  std::size_t sent = 0, kept = 0;  // files; `kept` were there already
  std::uint64_t bytes_sent = 0;
};

// All files of `folder` and of those below it become objects of the same names under `place` (a
// GDAL name, IsStore): all but a cluster's scripts and logs (slurm/), locks, and what a killed
// program has left half written. Links to files are followed. Their list (uploaded_files.h) is
// written first, names what is to come, and says at last that all of it is there: a reader knows
// what is complete, and the same call goes on after whatever ended it. What the list has with the
// file's size and digest, and the store with that size, is not sent again.
//
// Throws UsageError where another object would be replaced; InputError where the folder cannot be
// read as a whole, changes meanwhile, or another upload writes to the place; EnvironmentError where
// the store does not answer or take a file.
UploadSummary Upload(const std::string& folder, const std::string& place,
                     const UploadOptions& options, ProgressListener* progress);

}  // namespace orient

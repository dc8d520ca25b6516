// A run's output folder, put into object storage.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace orient {

struct UploadOptions {
  bool overwrite = false;  // what lies there otherwise than an interrupted upload left it
  int jobs = 4;            // files sent at a time
};

struct UploadSummary {
  std::size_t sent = 0, kept = 0;  // files; `kept` were there already
  std::uint64_t bytes_sent = 0;
};

// Whether files can be put there: "/vsis3/bucket/folder" and the like (core/base/remote_files.h).
bool IsStore(const std::string& gdal_name);
// The error of a place that is none.
UsageError NoStore(const std::string& place);

// All files of `folder` and of those below it, but for what is half written, as objects of the same
// names under `place` (a GDAL name). An object appears whole. Their list (uploaded_files.h) says
// from the first object to the last that more is to come, so that a reader knows what is complete
// and the same call goes on after whatever ended it: what the list says is there is not sent again.
// Throws UsageError where another object would be replaced, InputError where the folder cannot be
// read or a file changes meanwhile, or the store has no list where one should be;
// EnvironmentError where the store does not take a file.
UploadSummary Upload(const std::string& folder, const std::string& place,
                     const UploadOptions& options, ProgressListener* progress);

}  // namespace orient

// orient upload: a run's output folder, put into object storage.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "block/block_folder.h"
#include "block/inputs/block_files.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/remote_files.h"
#include "tools/cluster/store_object.h"
#include "tools/cluster/upload.h"
#include "tools/commands/commands.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"

namespace orient {
namespace {

class UploadCommand : public Command {
 public:
  std::string Name() const override { return "upload"; }
  std::string Summary() const override { return "Put a run's output folder into object storage"; }

  void Setup(CLI::App& app) override {
    app.add_option("DIR", folder_, "Output folder of a run that has ended")->required();
    app.add_option("PLACE", place_, "s3://bucket/folder, gs:// or az://")->required();
    app.add_option("--jobs", options_.jobs, "Files sent at a time")
        ->check(CLI::Range(1, 64))
        ->capture_default_str();
    app.add_flag("--overwrite", options_.overwrite,
                 "Replace existing objects, also those of an earlier upload");
  }

  ExitCode Run(std::ostream& out) override {
    const std::string place = GdalName(place_);
    if (!IsStore(place)) throw NoStore(place_);
    std::error_code ignored;
    if (!std::filesystem::is_directory(folder_, ignored))
      throw InputError(folder_ + " is not a folder; name the output folder of a run");
    const FolderLock lock(folder_, block::kBlockLock);
    if (block::IsUnfinished(folder_))
      throw InputError("the run into " + folder_ +
                       " has not ended; continue it with --resume, then upload");
    ShownProgress progress;
    const UploadSummary summary = Upload(folder_, place, options_, &progress);
    out << fmt::format("sent {} of {} files, {:.1f} MB\n", summary.sent,
                       summary.sent + summary.kept, static_cast<double>(summary.bytes_sent) / 1e6);
    return ExitCode::kAllDone;
  }

 private:
  std::string folder_, place_;
  UploadOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeUploadCommand() { return std::make_unique<UploadCommand>(); }

}  // namespace orient

// orient cameras: what is in the camera library, and cameras that are not.
#include <CLI/CLI.hpp>
#include <ostream>

#include "block/inputs/camera_library.h"
#include "interior/camera_choice.h"
#include "tools/commands/cameras/new_camera_command.h"
#include "tools/commands/cameras/try_camera_command.h"
#include "tools/commands/commands.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

bool IsTried(const block::LibraryCamera& camera) {
  return !camera.format_only && camera.file.fiducials.size() <= interior::kMostMarksOfUnknownCamera;
}

class CamerasCommand : public Command {
 public:
  std::string Name() const override { return "cameras"; }
  std::string Summary() const override {
    return "List the camera library; make a camera file from a scan, try one on a scan";
  }

  void Setup(CLI::App& app) override {
    AddCameraLibraryOption(app, &library_);
    new_.Setup(app);
    try_.Setup(app);
    app.require_subcommand(0, 1);
  }

  ExitCode Run(std::ostream& out) override {
    if (new_.Asked()) return new_.Run(out);
    if (try_.Asked()) return try_.Run(library_, out);
    const std::string folder = block::CameraLibraryFolder(library_);
    SummaryTable table({"name", "marks", "c mm", "auto", "camera"});
    for (const block::LibraryCamera& camera : block::ReadCameraLibrary(folder))
      table.AddRow({camera.name, std::to_string(camera.file.fiducials.size()),
                    Fixed(camera.file.camera.principal_distance_mm, 1),
                    IsTried(camera) ? "yes" : "no", camera.file.camera.name});
    table.Print(out);
    out << "\nlibrary  " << folder << "\n";
    return ExitCode::kAllDone;
  }

 private:
  std::string library_;
  NewCameraCommand new_;
  TryCameraCommand try_;
};

}  // namespace

std::unique_ptr<Command> MakeCamerasCommand() { return std::make_unique<CamerasCommand>(); }

}  // namespace orient

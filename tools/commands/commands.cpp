#include "tools/commands/commands.h"

namespace orient {

// In the order of the path; `orient --help` shows them so.
CommandList MakeCommands() {
  CommandList commands;
  commands.push_back(MakeInteriorCommand());
  commands.push_back(MakePatchdbCommand());
  commands.push_back(MakeExteriorCommand());
  commands.push_back(MakeBlockCommand());
  commands.push_back(MakeSlurmCommand());
  commands.push_back(MakeOrthoCommand());
  commands.push_back(MakeConvertCommand());
  commands.push_back(MakeSimulateCommand());
  commands.push_back(MakeReportCommand());
  commands.push_back(MakeReviewCommand());
  commands.push_back(MakeCamerasCommand());
  commands.push_back(MakeMeasurementsCommand());
  commands.push_back(MakeUploadCommand());
  return commands;
}

}  // namespace orient

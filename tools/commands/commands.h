// The subcommands of `orient`. To add one: write tools/orient_<stage>.cpp, declare its Make
// function here, list it in commands.cpp, and write its page docs/<stage>.md.
#pragma once

#include "tools/commands/command.h"

namespace orient {

std::unique_ptr<Command> MakeBlockCommand();
std::unique_ptr<Command> MakeCamerasCommand();
std::unique_ptr<Command> MakeMeasurementsCommand();
std::unique_ptr<Command> MakeConvertCommand();
std::unique_ptr<Command> MakeExteriorCommand();

CommandList MakeCommands();

std::unique_ptr<Command> MakeInteriorCommand();
std::unique_ptr<Command> MakeOrthoCommand();
std::unique_ptr<Command> MakePatchdbCommand();
std::unique_ptr<Command> MakeSimulateCommand();
std::unique_ptr<Command> MakeReportCommand();
std::unique_ptr<Command> MakeReviewCommand();
std::unique_ptr<Command> MakeSlurmCommand();
std::unique_ptr<Command> MakeUploadCommand();

}  // namespace orient

// The frame around every subcommand of `orient`: one main, one set of exit codes, one place that
// turns exceptions into them.
//
// A subcommand lives in one file, tools/orient_<stage>.cpp: a class derived from Command and a
// function Make<Stage>Command() that tools/commands/commands.cpp lists. Setup() binds options and
// may not open files; Run() works and may not parse. Results go to files or standard output,
// messages to the error stream.
#pragma once

#include <iosfwd>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/commands/record_run.h"

namespace CLI {
class App;
}

namespace orient {

enum class ExitCode {
  kAllDone = 0,
  kBadUsage = 1,
  kBadInput = 2,
  kSomeNotOriented = 3,
  kMachineRefused = 4
};

class Command {
 public:
  virtual ~Command() = default;

  virtual std::string Name() const = 0;     // "interior"
  virtual std::string Summary() const = 0;  // one line of `orient --help`

  // Declares options: name, help and variable in one statement. Defaults are shown by themselves.
  // Nested subcommands (`patchdb create`) are added here as well.
  virtual void Setup(CLI::App& app) = 0;

  // Throws UsageError, InputError. `out` is standard output.
  virtual ExitCode Run(std::ostream& out) = 0;

  // Before Run(): how the program was called.
  void Begin(Invocation invocation) { invocation_ = std::move(invocation); }

 protected:
  const Invocation& Invoked() const { return invocation_; }

 private:
  Invocation invocation_;
};

// "0.1.0".
std::string ProgramVersion();

using CommandList = std::vector<std::unique_ptr<Command>>;

// Parses, runs, and says on `err` what went wrong. Returns the process's exit code.
int RunProgram(const CommandList& commands, const std::vector<std::string>& arguments,
               std::ostream& out, std::ostream& err);

// Parses and runs nothing: the commands then know what was asked of them. Throws UsageError.
void Parse(const CommandList& commands, const std::vector<std::string>& arguments);

// The options that these arguments give a command, as its Options() returns them.
template <typename OneCommand>
auto OptionsOf(const std::vector<std::string>& arguments) {
  auto command = std::make_unique<OneCommand>();
  const OneCommand& asked = *command;
  CommandList commands;
  commands.push_back(std::move(command));
  Parse(commands, arguments);
  return asked.Options();
}

// The whole command line's parser, as RunProgram builds it: for tests of help and options.
std::unique_ptr<CLI::App> MakeParser(const CommandList& commands);

}  // namespace orient

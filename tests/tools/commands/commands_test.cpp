#include "tools/commands/commands.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <set>
#include <sstream>

namespace orient {
namespace {

// Every command and nested command, as the words that call it.
void CollectPaths(const CLI::App& app, const std::vector<std::string>& path,
                  std::vector<std::vector<std::string>>* paths) {
  for (const CLI::App* nested : app.get_subcommands(nullptr)) {
    std::vector<std::string> words = path;
    words.push_back(nested->get_name());
    paths->push_back(words);
    CollectPaths(*nested, words, paths);
  }
}

TEST(Commands, EachAnswersHelpWithOptionsExplained) {
  const CommandList commands = MakeCommands();
  std::vector<std::vector<std::string>> paths;
  CollectPaths(*MakeParser(commands), {}, &paths);
  for (std::vector<std::string> words : paths) {
    for (const std::string flag : {"-h", "--help"}) {
      std::vector<std::string> arguments = words;
      arguments.push_back(flag);
      std::ostringstream out, err;
      EXPECT_EQ(RunProgram(MakeCommands(), arguments, out, err), 0) << words.back();
      EXPECT_NE(out.str().find("Usage:"), std::string::npos) << words.back();
      EXPECT_EQ(err.str(), "") << words.back();
    }
  }
}

void ExpectDescriptions(const CLI::App& app) {
  EXPECT_FALSE(app.get_description().empty()) << app.get_name();
  for (const CLI::Option* option : app.get_options())
    EXPECT_FALSE(option->get_description().empty()) << app.get_name() << " " << option->get_name();
  for (const CLI::App* nested : app.get_subcommands(nullptr)) ExpectDescriptions(*nested);
}

TEST(Commands, EveryOptionSaysWhatItIs) {
  const CommandList commands = MakeCommands();
  ExpectDescriptions(*MakeParser(commands));
}

TEST(Commands, OverwriteAndResumeContradictOneAnother) {
  const CommandList commands = MakeCommands();
  const auto parser = MakeParser(commands);
  for (const char* command : {"interior", "exterior", "block", "ortho"}) {
    CLI::App* app = parser->get_subcommand(command);
    EXPECT_TRUE(
        app->get_option("--resume")->get_excludes().contains(app->get_option("--overwrite")))
        << command;
  }
}

TEST(Commands, NamesAreUnique) {
  std::set<std::string> names;
  for (const auto& command : MakeCommands())
    EXPECT_TRUE(names.insert(command->Name()).second) << command->Name();
}

}  // namespace
}  // namespace orient

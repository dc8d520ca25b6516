#include "tools/commands/command.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// `orient measure FILE [--scale S] [--limit L] [--fast]` and `orient store create DB`.
class MeasureCommand : public Command {
 public:
  explicit MeasureCommand(std::function<ExitCode()> run) : run_(std::move(run)) {}
  std::string Name() const override { return "measure"; }
  std::string Summary() const override { return "Measure a file"; }
  void Setup(CLI::App& app) override {
    app.add_option("FILE", file_, "What to measure")->required();
    app.add_option("--scale", scale_, "Scale of the measurement");
    app.add_option("--limit", limit_, "Where to stop");
    app.add_flag("--fast", fast_, "Hurry");
  }
  ExitCode Run(std::ostream& out) override {
    out << "measured " << file_ << "\n";
    return run_();
  }

 private:
  std::function<ExitCode()> run_;
  std::string file_;
  double scale_ = 2.5;
  std::optional<double> limit_;
  bool fast_ = false;
};

class StoreCommand : public Command {
 public:
  std::string Name() const override { return "store"; }
  std::string Summary() const override { return "Keep things"; }
  void Setup(CLI::App& app) override {
    app.require_subcommand(1);
    CLI::App* create = app.add_subcommand("create", "Make a store");
    create->add_option("DB", database_, "The store")->required();
  }
  ExitCode Run(std::ostream& out) override {
    out << "created " << database_ << "\n";
    return ExitCode::kAllDone;
  }

 private:
  std::string database_;
};

struct Outcome {
  int code = -1;
  std::string out, err;
};

Outcome RunWith(
    const std::vector<std::string>& arguments,
    std::function<ExitCode()> run = [] { return ExitCode::kAllDone; }) {
  CommandList commands;
  commands.push_back(std::make_unique<MeasureCommand>(std::move(run)));
  commands.push_back(std::make_unique<StoreCommand>());
  std::ostringstream out, err;
  const int code = RunProgram(commands, arguments, out, err);
  return {code, out.str(), err.str()};
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Command, QuietPrintsErrorsOnly) {
  const Outcome well = RunWith({"measure", "a.txt", "--quiet"});
  EXPECT_EQ(well.code, 0);
  EXPECT_EQ(well.out + well.err, "");
  EXPECT_EQ(RunWith({"store", "create", "a.db", "--quiet"}).out, "");
  const Outcome wrong = RunWith({"measure", "a.txt", "--quiet"},
                                []() -> ExitCode { throw InputError("a.txt is empty"); });
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(wrong.err, "orient: a.txt is empty\n");
}

TEST(Command, TheLogHasTheCommandWhatWasSaidAndTheExitCodeWithTimes) {
  const TemporaryFolder folder;
  const std::string log = folder / "run.log";
  RunWith({"measure", "my file.txt", "--quiet", "--log", log});
  const Outcome wrong = RunWith({"measure", "b.txt", "--log", log},
                                []() -> ExitCode { throw InputError("b.txt is empty"); });
  EXPECT_EQ(wrong.err, "orient: b.txt is empty\n") << "it is shown as well";
  std::istringstream lines(ReadFile(log));
  const std::string time = "^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}Z ";
  for (const char* expected :
       {"orient [0-9.]+: orient measure 'my file.txt' --quiet --log .*", "measured my file.txt",
        "ended with exit code 0 after 0 s", "orient [0-9.]+: orient measure b.txt --log .*",
        "measured b.txt", "orient: b.txt is empty", "ended with exit code 2 after 0 s"}) {
    std::string line;
    ASSERT_TRUE(std::getline(lines, line)) << expected;
    EXPECT_TRUE(std::regex_match(line, std::regex(time + expected))) << line;
  }
}

TEST(Command, TheLogForProgramsHasAnObjectALine) {
  const TemporaryFolder folder;
  const std::string log = folder / "run.jsonl";
  RunWith({"measure", "a \"quoted\".txt", "--log-json", log});
  RunWith({"measure", "b.txt", "--log-json", log},
          []() -> ExitCode { throw InputError("b.txt is empty"); });
  std::istringstream lines(ReadFile(log));
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"command", "orient measure 'a \"quoted\".txt'"},
      {"said", "measured a \"quoted\".txt"},
      {"end", "exit code 0"},
      {"command", "measure b.txt"},
      {"said", "measured b.txt"},
      {"error", "orient: b.txt is empty"},
      {"end", "exit code 2"}};
  for (const auto& [event, text] : expected) {
    std::string line;
    ASSERT_TRUE(std::getline(lines, line)) << text;
    const auto json = nlohmann::json::parse(line);
    EXPECT_EQ(json.at("event"), event) << line;
    EXPECT_TRUE(Contains(json.at("text").get<std::string>(), text)) << line;
    EXPECT_EQ(json.at("time").get<std::string>().size(), 20u) << line;
    EXPECT_EQ(json.contains("exit_code"), event == "end") << line;
  }
  const Outcome other = RunWith({"measure", "a.txt", "--log", log});
  EXPECT_TRUE(Contains(other.err, "is no log of orient; choose another file for --log"))
      << other.err;
}

TEST(Command, ALogMayBeADevice) {
  const Outcome outcome = RunWith({"measure", "a.txt", "--log", "/dev/zero"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST(Command, AFileThatIsNoLogIsNotAddedTo) {
  const TemporaryFolder folder;
  const std::string table = folder / "table.csv";
  WriteFileAtomically(table, "filename,x,y,z,omega,phi,kappa\n");
  const Outcome outcome = RunWith({"measure", "a.txt", "--log", table});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(Contains(outcome.err, "table.csv exists and is no log of orient")) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(ReadFile(table), "filename,x,y,z,omega,phi,kappa\n");
  const Outcome nowhere = RunWith({"measure", "a.txt", "--log", folder / "none/run.log"});
  EXPECT_EQ(nowhere.code, 2);
  EXPECT_TRUE(Contains(nowhere.err, "none/run.log: the log cannot be written")) << nowhere.err;
}

TEST(Command, ARunThatGoesWellPrintsNothingOnTheErrorStream) {
  const Outcome outcome = RunWith({"measure", "a.txt"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out, "measured a.txt\n");
  EXPECT_EQ(outcome.err, "");
}

TEST(Command, HelpAndVersionGoToStandardOutputWithCodeZero) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--help"}, {"-h"}, {"--version"}, {"measure", "--help"}, {"store", "create", "-h"}}) {
    const Outcome outcome = RunWith(arguments);
    EXPECT_EQ(outcome.code, 0) << arguments.front();
    EXPECT_FALSE(outcome.out.empty()) << arguments.front();
    EXPECT_EQ(outcome.err, "") << arguments.front();
  }
  EXPECT_TRUE(Contains(RunWith({"--help"}).out, "measure"));
  EXPECT_TRUE(Contains(RunWith({"measure", "-h"}).out, "2.5")) << "defaults show by themselves";
}

TEST(Command, HelpThatCannotBeWrittenIsAnError) {
  std::ofstream full("/dev/full");
  std::ostringstream err;
  CommandList commands;
  commands.push_back(std::make_unique<StoreCommand>());
  EXPECT_EQ(RunProgram(commands, {"store", "create", "--help"}, full, err), 2);
  EXPECT_NE(err.str().find("cannot write to standard output"), std::string::npos) << err.str();
}

TEST(Command, BadUsageIsCodeOneAndNamesWhatIsWrongAndWhereHelpIs) {
  EXPECT_EQ(RunWith({}).code, 1);
  const Outcome unknown = RunWith({"measure", "a.txt", "--scael", "3"});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_TRUE(Contains(unknown.err, "--scael")) << unknown.err;
  EXPECT_TRUE(Contains(unknown.err, "orient measure --help")) << unknown.err;
  const Outcome wrong = RunWith({"measure", "a.txt", "--scale", "big"});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_TRUE(Contains(wrong.err, "big")) << wrong.err;
  for (const char* number : {"nan", "inf", "-1e999"})
    EXPECT_EQ(RunWith({"measure", "a.txt", std::string("--scale=") + number}).code, 1) << number;
  EXPECT_EQ(RunWith({"measure"}).code, 1) << "a required argument is missing";
  EXPECT_EQ(RunWith({"juggle"}).code, 1) << "no such command";
  EXPECT_EQ(unknown.out, "") << "nothing ran";
}

TEST(Command, HelpIsACommandToo) {
  EXPECT_EQ(RunWith({"help"}).out, RunWith({"--help"}).out);
  EXPECT_EQ(RunWith({"help", "store", "create"}).out, RunWith({"store", "create", "--help"}).out);
  EXPECT_EQ(RunWith({"help", "measure"}).code, 0);
  const auto unknown = RunWith({"help", "store", "craete"});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_TRUE(Contains(unknown.err, "'craete': did you mean create?")) << unknown.err;
}

TEST(Command, WhatIsWrittenNearlyRightIsNamed) {
  EXPECT_TRUE(Contains(RunWith({"measur", "a.txt"}).err, "did you mean measure?"));
  EXPECT_TRUE(Contains(RunWith({"store", "craete", "x"}).err, "did you mean create?"));
  const Outcome option = RunWith({"measure", "a.txt", "--scael=3"});
  EXPECT_TRUE(Contains(option.err, "'--scael=3': did you mean --scale?")) << option.err;
  EXPECT_FALSE(Contains(RunWith({"juggle"}).err, "did you mean")) << "nothing is like it";
  EXPECT_FALSE(Contains(RunWith({"measure", "fats", "--scale", "big"}).err, "did you mean"))
      << "a file's name is no option";
}

TEST(Command, AWordThatIsNoCommandIsNamedWithThoseThereAre) {
  const Outcome one = RunWith({"juggle", "x"});
  EXPECT_EQ(one.code, 1);
  EXPECT_TRUE(Contains(one.err, "there is no command 'juggle'; the commands are ")) << one.err;
  EXPECT_TRUE(Contains(one.err, "measure, ")) << one.err;
  EXPECT_TRUE(Contains(RunWith({"help", "juggle"}).err, "the commands are")) << "told the same way";
  const Outcome nested = RunWith({"store", "juggle"});
  EXPECT_EQ(nested.code, 1);
  EXPECT_TRUE(Contains(nested.err, "no command 'juggle'; the commands are create")) << nested.err;
}

TEST(Command, ACommandThatIsMissingIsMissedByItsNameWithThoseThereAre) {
  const Outcome nested = RunWith({"store"});
  EXPECT_EQ(nested.code, 1);
  EXPECT_TRUE(Contains(nested.err, "no command follows 'orient store'; the commands are create"))
      << nested.err;
  EXPECT_TRUE(Contains(nested.err, "Try 'orient store --help'")) << nested.err;
  const Outcome none = RunWith({});
  EXPECT_EQ(none.code, 1);
  EXPECT_TRUE(Contains(none.err, "no command follows 'orient'; the commands are ")) << none.err;
}

TEST(Command, OptionsBeforeTheCommandAreRefusedWithAWord) {
  for (const std::string option : {"--log-json=x.json", "--quiet", "--scale"}) {
    const Outcome run = RunWith({option, "measure", "a.txt"});
    EXPECT_EQ(run.code, 1);
    EXPECT_TRUE(Contains(run.err, "options follow the command: orient COMMAND ... " +
                                      option.substr(0, option.find('='))))
        << run.err;
  }
  EXPECT_FALSE(Contains(RunWith({"--juggle", "measure", "a.txt"}).err, "follow the command"));
}

TEST(Command, EveryExceptionHasItsExitCodeAndOneLine) {
  const Outcome usage =
      RunWith({"measure", "a"}, []() -> ExitCode { throw UsageError("no such locator"); });
  EXPECT_EQ(usage.code, 1);
  EXPECT_EQ(usage.err, "orient: no such locator\n");
  const Outcome input =
      RunWith({"measure", "a"}, []() -> ExitCode { throw InputError("a is torn"); });
  EXPECT_EQ(input.code, 2);
  EXPECT_EQ(input.err, "orient: a is torn\n");
  const Outcome defect =
      RunWith({"measure", "a"}, []() -> ExitCode { throw std::invalid_argument("n < 0"); });
  EXPECT_EQ(defect.code, 2);
  EXPECT_TRUE(Contains(defect.err, "internal error")) << defect.err;
}

TEST(Command, SomePhotosNotOrientedIsCodeThree) {
  EXPECT_EQ(RunWith({"measure", "a"}, [] { return ExitCode::kSomeNotOriented; }).code, 3);
}

TEST(Command, VerbosePrintsEveryOptionsEffectiveValueFirst) {
  const Outcome outcome = RunWith({"measure", "a.txt", "--verbose", "--fast"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(Contains(outcome.err, "FILE        a.txt\n")) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "--scale     2.5  (default)\n")) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "--limit     (not given)\n")) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "--fast      yes\n")) << outcome.err;
  const Outcome given = RunWith({"measure", "a.txt", "--verbose", "--scale=7", "--limit", "9"});
  EXPECT_TRUE(Contains(given.err, "--scale     7\n")) << given.err;
  EXPECT_TRUE(Contains(given.err, "--limit     9\n")) << given.err;
  EXPECT_TRUE(Contains(given.err, "--fast      no\n")) << given.err;
}

TEST(Command, VerboseReachesNestedCommands) {
  const Outcome outcome = RunWith({"store", "create", "a.gpkg", "--verbose"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(Contains(outcome.err, "orient store create\n  DB  a.gpkg\n")) << outcome.err;
  EXPECT_EQ(outcome.out, "created a.gpkg\n");
}

}  // namespace
}  // namespace orient

#include "tools/commands/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <new>
#include <optional>
#include <ostream>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/files/toml_fields.h"
#include "tools/console/interruption.h"
#include "tools/console/progress_watcher.h"
#include "tools/console/run_output.h"

namespace orient {
namespace {

constexpr const char* kVerbose = "--verbose";
constexpr const char* kQuiet = "--quiet";
constexpr const char* kLog = "--log";
constexpr const char* kLogJson = "--log-json";
constexpr const char* kOutputLost = "cannot write to standard output; is the disk full?";

// Description of `orient`, for those who type its name alone.
constexpr const char* kDescription =
    "Orients scans of aerial film photos automatically: interior orientation from fiducial marks,\n"
    "exterior orientation from patches of known ground position, then the whole block.";

// CLI11's ranges let nan through.
std::string WhyNotFinite(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool finite =
      std::isfinite(value) || end == text.c_str();  // not a number at all: reported as such
  return finite ? "" : text + " is not a finite number";
}

void RefuseInfinities(CLI::App& app) {
  for (CLI::Option* option : app.get_options())
    if (option->get_type_name().starts_with("FLOAT")) option->check(WhyNotFinite);
}

// One recomputes everything, the other keeps what is there.
void RefuseOverwriteWithResume(CLI::App& app) {
  CLI::Option* resume = app.get_option_no_throw("--resume");
  CLI::Option* overwrite = app.get_option_no_throw("--overwrite");
  if (resume != nullptr && overwrite != nullptr) resume->excludes(overwrite);
}

void PrepareSubcommands(CLI::App& app) {
  RefuseInfinities(app);
  RefuseOverwriteWithResume(app);
  for (CLI::App* nested : app.get_subcommands(nullptr)) {
    nested->fallthrough();  // so that `patchdb create DB --verbose` works
    PrepareSubcommands(*nested);
  }
}

std::string ValueText(const CLI::Option& option) {
  const bool is_flag = option.get_items_expected_max() == 0;
  if (option.count() == 0)
    return is_flag                            ? "no"
           : option.get_default_str().empty() ? "(not given)"
                                              : option.get_default_str() + "  (default)";
  if (is_flag) return "yes";
  std::string text;
  for (const std::string& value : option.results()) text += (text.empty() ? "" : " ") + value;
  return text;
}

// Every option's effective value, so that a log says what was really run.
void PrintOptions(const CLI::App& app, const std::string& title, std::ostream& err) {
  err << title << "\n";
  const std::vector<const CLI::Option*> options =
      app.get_options([&app](const CLI::Option* option) { return option != app.get_help_ptr(); });
  size_t width = 0;
  for (const CLI::Option* option : options) width = std::max(width, option->get_name().size());
  for (const CLI::Option* option : options)
    err << "  " << option->get_name() << std::string(width - option->get_name().size() + 2, ' ')
        << ValueText(*option) << "\n";
  for (const CLI::App* nested : app.get_subcommands())
    PrintOptions(*nested, title + " " + nested->get_name(), err);
}

// The command that was asked for, e.g. `orient patchdb create`: whose help to look at.
std::string AskedCommand(const CLI::App& app) {
  std::string name = app.get_name();
  for (const CLI::App* nested : app.get_subcommands()) name += " " + AskedCommand(*nested);
  return name;
}

const CLI::App& AskedApp(const CLI::App& app) {
  const auto nested = app.get_subcommands();
  return nested.empty() ? app : AskedApp(*nested.front());
}

std::vector<std::string> CommandsOf(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* nested : app.get_subcommands(nullptr)) names.push_back(nested->get_name());
  return names;
}

// Suggests a known option that is spelt nearly like one of these; empty if there is none.
std::string DidYouMean(const CLI::App& parser, const std::vector<std::string>& arguments) {
  std::vector<std::string> names;
  for (const CLI::Option* option : AskedApp(parser).get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  for (const std::string& argument : arguments) {
    const std::string word = argument.substr(0, argument.find('='));
    if (!word.starts_with("--") || std::find(names.begin(), names.end(), word) != names.end())
      continue;
    const std::string nearest = NearestWord(word, {names.begin(), names.end()});
    if (!nearest.empty()) return fmt::format("'{}': did you mean {}?", argument, nearest);
  }
  return "";
}

std::string ListOfCommands(const CLI::App& app) {
  return fmt::format("; the commands are {}", fmt::join(CommandsOf(app), ", "));
}

std::string NoCommand(const std::string& word, const CLI::App& app) {
  const std::vector<std::string> names = CommandsOf(app);
  const std::string nearest = NearestWord(word, {names.begin(), names.end()});
  return fmt::format("there is no command '{}'", word) +
         (nearest.empty() ? ListOfCommands(app) : ": did you mean " + nearest + "?");
}

bool TakesWords(const CLI::App& app) {
  const std::vector<const CLI::Option*> options = app.get_options();
  return std::any_of(options.begin(), options.end(),
                     [](const CLI::Option* option) { return option->get_positional(); });
}

// Error message for a word that is no command where a command or subcommand is expected, or for an
// option of the commands that precedes the command. Empty if neither occurs.
std::string WrongCommand(const CLI::App& parser, const std::vector<std::string>& arguments) {
  const CLI::App* app = &parser;
  for (const std::string& argument : arguments) {
    const std::string word = argument.substr(0, argument.find('='));
    if (word.starts_with("-")) {
      const auto commands = parser.get_subcommands(nullptr);
      const bool known = std::any_of(commands.begin(), commands.end(), [&](const CLI::App* one) {
        return one->get_option_no_throw(word) != nullptr;
      });
      if (app != &parser || !known || parser.get_option_no_throw(word) != nullptr) return "";
      return fmt::format("options follow the command: orient COMMAND ... {}", word);
    }
    const std::vector<std::string> names = CommandsOf(*app);
    if (std::find(names.begin(), names.end(), argument) == names.end()) {
      const bool meant = !NearestWord(argument, {names.begin(), names.end()}).empty();
      return !names.empty() && (meant || !TakesWords(*app)) ? NoCommand(argument, *app) : "";
    }
    app = app->get_subcommand(argument);
  }
  return "";
}

// Empty where the command line has all the commands that it needs.
std::string MissingCommand(const CLI::App& parser, const std::vector<std::string>& arguments) {
  const CLI::App& app = AskedApp(parser);
  if (app.get_require_subcommand_min() == 0) return "";
  std::string missing = fmt::format("no command follows '{}'", AskedCommand(parser));
  for (const std::string& argument : arguments) {
    const std::string word = argument.substr(0, argument.find('='));
    if (!word.starts_with("-") || app.get_option_no_throw(word) != nullptr) continue;
    missing += fmt::format(", which has no option {}", word);
    break;
  }
  return missing + ListOfCommands(app);
}

int ReportParseError(const CLI::App& parser, const CLI::ParseError& error,
                     const std::vector<std::string>& arguments, std::ostream& out,
                     std::ostream& err) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {  // --help, --version
    const int code = parser.exit(error, out, err);
    if (out.flush()) return code;
    err << "orient: " << kOutputLost << "\n";
    return static_cast<int>(ExitCode::kBadInput);
  }
  // For a misspelt word, CLI11 reports only what is missing because of it.
  std::string wrong = WrongCommand(parser, arguments);
  if (wrong.empty()) wrong = DidYouMean(parser, arguments);
  if (wrong.empty()) wrong = MissingCommand(parser, arguments);
  err << "orient: " << (wrong.empty() ? error.what() : wrong) << "\nTry '" << AskedCommand(parser)
      << " --help'.\n";
  return static_cast<int>(ExitCode::kBadUsage);
}

// Throws UsageError if X in `orient help X` is no command: CLI11 would show the help of what it
// does know.
void RequireKnown(const CLI::App& parser, const std::vector<std::string>& arguments) {
  if (arguments.empty() || arguments.front() != "help") return;
  const CLI::App* app = &parser;
  for (std::size_t i = 1; i < arguments.size() && !arguments[i].starts_with("-"); ++i) {
    const std::vector<std::string> names = CommandsOf(*app);
    if (std::find(names.begin(), names.end(), arguments[i]) == names.end())
      throw UsageError(NoCommand(arguments[i], *app));
    app = app->get_subcommand(arguments[i]);
  }
}

// `orient help patchdb create` is `orient patchdb create --help`.
std::vector<std::string> WithoutHelpCommand(std::vector<std::string> arguments) {
  if (arguments.empty() || arguments.front() != "help") return arguments;
  arguments.erase(arguments.begin());
  arguments.emplace_back("--help");
  return arguments;
}

RunOutputOptions OutputOf(const CLI::App& parser) {
  const CLI::App* asked = parser.get_subcommands().front();
  RunOutputOptions options;
  options.quiet = asked->count(kQuiet) > 0;
  if (asked->count(kLog) > 0) options.log = asked->get_option(kLog)->results().back();
  if (asked->count(kLogJson) > 0) options.log_json = asked->get_option(kLogJson)->results().back();
  return options;
}

// "orient block 'my block.toml'".
std::string CommandText(const std::vector<std::string>& arguments) {
  std::string text = "orient";
  for (const std::string& argument : arguments)
    text += argument.find_first_of(" '\"*?") == std::string::npos && !argument.empty()
                ? " " + argument
                : " '" + argument + "'";
  return text;
}

// What to do after a run that was ended half-way.
std::string HowToGoOn(const CLI::App& parser) {
  const CLI::App& app = AskedApp(parser);
  const auto has = [&](const char* name) { return app.get_option_no_throw(name) != nullptr; };
  if (has("--resume"))
    return std::string("what is finished is kept; the same command with --resume") +
           (app.count("--overwrite") > 0 ? " instead of --overwrite" : "") + " goes on";
  if (has("--overwrite")) return "repeat the command with --overwrite";
  return "what is finished is kept, nothing stays half done; repeat the command";
}

ExitCode RunCommand(const CLI::App& parser, const CommandList& commands,
                    const Invocation& invocation, std::ostream& out, std::ostream& err) {
  const CLI::App* asked = parser.get_subcommands().front();
  if (asked->count(kVerbose) > 0) PrintOptions(*asked, "orient " + asked->get_name(), err);
  const auto command = std::find_if(commands.begin(), commands.end(), [&](const auto& candidate) {
    return candidate->Name() == asked->get_name();
  });
  (*command)->Begin(invocation);
  const ExitCode code = (*command)->Run(out);
  out.flush();
  if (!out) throw InputError(kOutputLost);
  return code;
}

}  // namespace

std::string ProgramVersion() { return ORIENT_VERSION; }

std::unique_ptr<CLI::App> MakeParser(const CommandList& commands) {
  auto parser = std::make_unique<CLI::App>(kDescription, "orient");
  parser->option_defaults()->always_capture_default();
  parser->set_version_flag("--version", "orient " + ProgramVersion());
  parser->require_subcommand(1);
  parser->footer(
      "Exit codes: 0 all done, 1 bad usage, 2 bad input, 3 done but some photos not\n"
      "oriented, 4 disk or memory full: run it again when there is room.\n"
      "'orient help COMMAND' explains a command.");
  for (const auto& command : commands) {
    CLI::App* app = parser->add_subcommand(command->Name(), command->Summary());
    command->Setup(*app);
    app->add_flag(kVerbose)->description("Print every option's effective value first");
    app->add_flag(kQuiet)->description("Print errors only");
    app->add_option(kLog)->type_name("FILE")->description(
        "Append all messages, with times, to this file");
    app->add_option(kLogJson)->type_name("FILE")->description(
        "The same for programs: one JSON object per line");
    PrepareSubcommands(*app);
  }
  return parser;
}

namespace {

void ParseWith(CLI::App* parser, std::vector<std::string> arguments) {
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants it
  parser->parse(std::move(arguments));
}

// Returns what `work` returns, or the exit code of its exception, which is reported on the stream
// that `err` returns then.
int Guarded(const CLI::App& parser, const std::vector<std::string>& arguments, std::ostream& out,
            const std::function<std::ostream&()>& err, const std::function<int()>& work) {
  const auto fail = [&err](const std::string& message, ExitCode code) {
    err() << "orient: " << message << "\n";
    return static_cast<int>(code);
  };
  try {
    try {
      return work();
    } catch (const std::exception&) {
      RethrowIfMachineFault();
      throw;
    }
  } catch (const EnvironmentError& error) {
    return fail(error.what(), ExitCode::kMachineRefused);
  } catch (const CLI::ParseError& error) {
    return ReportParseError(parser, error, arguments, out, err());
  } catch (const UsageError& error) {
    return fail(error.what(), ExitCode::kBadUsage);
  } catch (const InputError& error) {
    return fail(error.what(), ExitCode::kBadInput);
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(error.path1().string() + ": " + error.code().message(), ExitCode::kBadInput);
  } catch (const Stopped&) {
    constexpr int kInterrupted = 130;  // the exit code of shells for Ctrl-C
    err() << "orient: stopped\n";
    return kInterrupted;
  } catch (const std::exception& error) {
    return fail(std::string("internal error, please report it: ") + error.what(),
                ExitCode::kBadInput);
  }
}

}  // namespace

void Parse(const CommandList& commands, const std::vector<std::string>& arguments) {
  const std::unique_ptr<CLI::App> parser = MakeParser(commands);
  try {
    ParseWith(parser.get(), arguments);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
}

int RunProgram(const CommandList& commands, const std::vector<std::string>& arguments,
               std::ostream& out, std::ostream& err) {
  const std::unique_ptr<CLI::App> parser = MakeParser(commands);
  std::optional<RunOutput> output;  // set once the command line says where output goes
  const int code = Guarded(
      *parser, arguments, out, [&]() -> std::ostream& { return output ? output->Err() : err; },
      [&] {
        RequireKnown(*parser, arguments);
        ParseWith(parser.get(), WithoutHelpCommand(arguments));
        const Invocation invocation{"orient " + ProgramVersion(), CommandText(arguments), arguments,
                                    std::time(nullptr)};
        output.emplace(OutputOf(*parser), invocation.program + ": " + invocation.command, out, err);
        SetWhatToDoAfterInterruption(HowToGoOn(*parser));
        return static_cast<int>(
            RunCommand(*parser, commands, invocation, output->Out(), output->Err()));
      });
  SetWhatToDoAfterInterruption("");
  if (output) output->End(code);
  return code;
}

}  // namespace orient

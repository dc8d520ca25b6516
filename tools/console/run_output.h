// Where a run's messages go: to standard output and the error stream as they come, and with their
// times into a log (--log), or nowhere else (--quiet).
#pragma once

#include <memory>
#include <ostream>
#include <string>
#include <string_view>

namespace orient {

struct RunOutputOptions {
  std::string log = {};       // a file to append to; empty: none
  bool quiet = false;         // standard output and progress are not shown; errors are
  std::string log_json = {};  // as `log` for programs: a JSON object a line
};

// Of one run of a command, from its construction to the end of its life.
class RunOutput {
 public:
  // `command`: the command line, for the log's first line. Throws UsageError where the log is a
  // file of another kind, InputError where it cannot be written.
  RunOutput(const RunOutputOptions& options, const std::string& command, std::ostream& out,
            std::ostream& err);
  ~RunOutput();
  RunOutput(const RunOutput&) = delete;
  RunOutput& operator=(const RunOutput&) = delete;

  std::ostream& Out();
  std::ostream& Err();
  // Writes the log's last line; reports on `err` if the log could not be written.
  void End(int exit_code);

 private:
  struct Streams;
  std::unique_ptr<Streams> streams_;
};

// Erases the terminal's current line.
inline constexpr const char* kEraseLine = "\r\033[K";

// "1 h 3 min", "2 min 5 s", "12 s".
std::string DurationText(double seconds);

// For the current run (a process has one at a time): a line for the logs alone, nothing if
// there is none; from any thread.
void LogLine(std::string_view text);
// How far a task is; `text` says it in words.
void LogProgress(std::string_view text, const std::string& task, int done, int total);
bool RunIsQuiet();

}  // namespace orient

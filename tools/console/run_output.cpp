#include "tools/console/run_output.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <streambuf>

#include "core/base/error.h"

namespace orient {
namespace {

// "2026-11-25T06:33:12Z ": every line begins so, and a log's first line goes on with kProgram.
constexpr std::size_t kTimeLength = 21;
constexpr std::string_view kProgram = "orient ";

std::string TimeText() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ} ", fmt::gmtime(std::time(nullptr)));
}

// Lines with their times at the end of a file.
class Log {
 public:
  explicit Log(const std::string& path) : path_(path) {
    RefuseOtherFiles();
    file_.open(path, std::ios::app);
    if (!file_)
      throw InputError(path + ": the log cannot be written; name a file in a folder that exists");
  }
  void Line(std::string_view text) {
    const std::lock_guard lock(mutex_);
    file_ << TimeText() << text << '\n' << std::flush;
  }
  bool Failed() const { return !file_; }
  const std::string& Path() const { return path_; }

 private:
  // A log is added to: a scan or a table of the same name must not be.
  void RefuseOtherFiles() const {
    std::ifstream there(path_);
    std::string line;
    if (!there || !std::getline(there, line)) return;
    if (line.size() > kTimeLength && line.compare(kTimeLength, kProgram.size(), kProgram) == 0)
      return;
    throw UsageError(path_ + " exists and is no log of orient; choose another file for --log");
  }

  std::string path_;
  std::ofstream file_;
  std::mutex mutex_;
};

std::mutex current_mutex;
Log* current_log = nullptr;
bool current_quiet = false;

// Passes what is written on to `shown` (null: to nobody) and its lines to the log.
class Tee : public std::streambuf {
 public:
  Tee(std::streambuf* shown, Log* log) : shown_(shown), log_(log) {}
  ~Tee() override {
    if (!line_.empty()) log_->Line(line_);
  }

 protected:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char character = traits_type::to_char_type(c);
    Keep(character);
    if (shown_ == nullptr) return c;
    return shown_->sputc(character);
  }
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    for (std::streamsize i = 0; i < size && log_ != nullptr; ++i) Keep(text[i]);
    return shown_ == nullptr ? size : shown_->sputn(text, size);
  }
  int sync() override { return shown_ == nullptr ? 0 : shown_->pubsync(); }

 private:
  void Keep(char character) {
    if (log_ == nullptr) return;
    if (character != '\n') {
      line_ += character;
      return;
    }
    log_->Line(line_);
    line_.clear();
  }

  std::streambuf* shown_;
  Log* log_;
  std::string line_;
};

}  // namespace

std::string DurationText(double seconds) {
  const long whole = std::lround(seconds);
  if (whole >= 3600) return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
  if (whole >= 60) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return std::to_string(whole) + " s";
}

struct RunOutput::Streams {
  Streams(const RunOutputOptions& options, std::ostream& shown_out, std::ostream& shown_err)
      : log(options.log.empty() ? nullptr : std::make_unique<Log>(options.log)),
        out_tee(options.quiet ? nullptr : shown_out.rdbuf(), log.get()),
        err_tee(shown_err.rdbuf(), log.get()),
        out(&out_tee),
        err(&err_tee),
        told(shown_err) {}

  std::unique_ptr<Log> log;
  Tee out_tee, err_tee;
  std::ostream out, err;
  std::ostream& told;  // the error stream itself
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
};

RunOutput::RunOutput(const RunOutputOptions& options, const std::string& command, std::ostream& out,
                     std::ostream& err)
    : streams_(std::make_unique<Streams>(options, out, err)) {
  if (streams_->log) streams_->log->Line(command);
  const std::lock_guard lock(current_mutex);
  current_log = streams_->log.get();
  current_quiet = options.quiet;
}

RunOutput::~RunOutput() {
  const std::lock_guard lock(current_mutex);
  current_log = nullptr;
  current_quiet = false;
}

std::ostream& RunOutput::Out() { return streams_->out; }
std::ostream& RunOutput::Err() { return streams_->err; }

void RunOutput::End(int exit_code) {
  Log* log = streams_->log.get();
  if (log == nullptr) return;
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - streams_->begin;
  log->Line(
      fmt::format("ended with exit code {} after {}", exit_code, DurationText(passed.count())));
  if (log->Failed())
    streams_->told << "orient: " << log->Path()
                   << ": the log could not be written to its end; is the disk full?\n";
}

void LogLine(std::string_view text) {
  const std::lock_guard lock(current_mutex);
  if (current_log != nullptr) current_log->Line(text);
}

bool RunIsQuiet() {
  const std::lock_guard lock(current_mutex);
  return current_quiet;
}

}  // namespace orient

#include "tools/console/run_output.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <streambuf>
#include <vector>

#include "core/base/error.h"

namespace orient {
namespace {

// "2026-11-25T06:33:12Z ": every line begins so, and a log's first line goes on with kProgram.
constexpr std::size_t kTimeLength = 21;
constexpr std::string_view kProgram = "orient ";
constexpr std::string_view kJsonBegin = "{\"time\":\"";
constexpr std::size_t kLongestBegin = 64;

std::string TimeText() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ} ", fmt::gmtime(std::time(nullptr)));
}

// What a line of a log says. In JSON, whatever is not there is left out.
struct Entry {
  std::string_view event;  // command, said, error, progress, end
  std::string_view text;
  std::string task = {};  // of progress
  std::optional<int> done = {}, total = {}, exit_code = {};
  std::optional<double> seconds = {};
};

std::string Json(const Entry& entry) {
  std::string time = TimeText();
  time.pop_back();
  nlohmann::ordered_json json = {{"time", time}, {"event", entry.event}};
  if (!entry.task.empty()) json["task"] = entry.task;
  if (entry.done) json["done"] = *entry.done;
  if (entry.total) json["total"] = *entry.total;
  if (entry.exit_code) json["exit_code"] = *entry.exit_code;
  if (entry.seconds) json["seconds"] = *entry.seconds;
  json["text"] = entry.text;
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

// Lines with their times at the end of a file.
class Log {
 public:
  Log(const std::string& path, bool json) : path_(path), json_(json) {
    RefuseOtherFiles();
    file_.open(path, std::ios::app);
    if (!file_)
      throw InputError(path + ": the log cannot be written; name a file in a folder that exists");
  }
  void Write(const Entry& entry) {
    const std::string line = json_ ? Json(entry) : TimeText() + std::string(entry.text);
    const std::lock_guard lock(mutex_);
    file_ << line << '\n' << std::flush;
  }
  bool Failed() const { return !file_; }
  const std::string& Path() const { return path_; }

 private:
  // Logs are appended to; a scan or a table of the same name must not be. A pipe or a device has
  // nothing to be kept, and reading one might not end.
  void RefuseOtherFiles() const {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path_, error)) return;
    std::ifstream there(path_);
    std::string line(kLongestBegin, '\0');
    there.read(line.data(), static_cast<std::streamsize>(line.size()));
    line.resize(static_cast<std::size_t>(there.gcount()));
    if (line.empty()) return;
    if (json_ ? line.starts_with(kJsonBegin)
              : line.size() > kTimeLength &&
                    line.compare(kTimeLength, kProgram.size(), kProgram) == 0)
      return;
    throw UsageError(fmt::format("{} exists and is no log of orient; choose another file for {}",
                                 path_, json_ ? "--log-json" : "--log"));
  }

  std::string path_;
  bool json_;
  std::ofstream file_;
  std::mutex mutex_;
};

using Logs = std::vector<std::unique_ptr<Log>>;

Logs OpenLogs(const RunOutputOptions& options) {
  Logs logs;
  if (!options.log.empty()) logs.push_back(std::make_unique<Log>(options.log, false));
  if (!options.log_json.empty()) logs.push_back(std::make_unique<Log>(options.log_json, true));
  return logs;
}

void WriteTo(const Logs& logs, const Entry& entry) {
  for (const auto& log : logs) log->Write(entry);
}

std::mutex current_mutex;
const Logs* current_logs = nullptr;
bool current_quiet = false;

// Passes what is written on to `shown` (null: to nobody) and its lines to the logs.
class Tee : public std::streambuf {
 public:
  Tee(std::streambuf* shown, const Logs& logs, std::string_view event)
      : shown_(shown), logs_(logs), event_(event) {}
  ~Tee() override {
    try {
      if (!line_.empty()) WriteTo(logs_, {event_, line_});
    } catch (const std::exception&) {  // no memory: the run has ended all the same
    }
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
    for (std::streamsize i = 0; i < size && !logs_.empty(); ++i) Keep(text[i]);
    return shown_ == nullptr ? size : shown_->sputn(text, size);
  }
  int sync() override { return shown_ == nullptr ? 0 : shown_->pubsync(); }

 private:
  void Keep(char character) {
    if (logs_.empty()) return;
    if (character != '\n') {
      line_ += character;
      return;
    }
    WriteTo(logs_, {event_, line_});
    line_.clear();
  }

  std::streambuf* shown_;
  const Logs& logs_;
  std::string_view event_;
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
      : logs(OpenLogs(options)),
        out_tee(options.quiet ? nullptr : shown_out.rdbuf(), logs, "said"),
        err_tee(shown_err.rdbuf(), logs, "error"),
        out(&out_tee),
        err(&err_tee),
        told(shown_err) {}

  Logs logs;
  Tee out_tee, err_tee;
  std::ostream out, err;
  std::ostream& told;  // the error stream itself
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
};

RunOutput::RunOutput(const RunOutputOptions& options, const std::string& command, std::ostream& out,
                     std::ostream& err)
    : streams_(std::make_unique<Streams>(options, out, err)) {
  WriteTo(streams_->logs, {"command", command});
  const std::lock_guard lock(current_mutex);
  current_logs = &streams_->logs;
  current_quiet = options.quiet;
}

RunOutput::~RunOutput() {
  const std::lock_guard lock(current_mutex);
  current_logs = nullptr;
  current_quiet = false;
}

std::ostream& RunOutput::Out() { return streams_->out; }
std::ostream& RunOutput::Err() { return streams_->err; }

void RunOutput::End(int exit_code) {
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - streams_->begin;
  const std::string text =
      fmt::format("ended with exit code {} after {}", exit_code, DurationText(passed.count()));
  WriteTo(streams_->logs,
          {.event = "end", .text = text, .exit_code = exit_code, .seconds = passed.count()});
  for (const auto& log : streams_->logs)
    if (log->Failed())
      streams_->told << "orient: " << log->Path()
                     << ": the log could not be written to its end; is the disk full?\n";
}

void LogLine(std::string_view text) {
  const std::lock_guard lock(current_mutex);
  if (current_logs != nullptr) WriteTo(*current_logs, {"error", text});
}

void LogProgress(std::string_view text, const std::string& task, int done, int total) {
  const std::lock_guard lock(current_mutex);
  if (current_logs == nullptr) return;
  WriteTo(*current_logs,
          {.event = "progress", .text = text, .task = task, .done = done, .total = total});
}

bool RunIsQuiet() {
  const std::lock_guard lock(current_mutex);
  return current_quiet;
}

}  // namespace orient

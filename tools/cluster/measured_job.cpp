#include "tools/cluster/measured_job.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

std::string PathIn(const std::string& folder) {
  return (fs::path(folder) / "measured.json").string();
}

json Measured(const std::string& folder) {
  if (!fs::exists(PathIn(folder))) return json::object();
  const json read = json::parse(ReadFile(PathIn(folder)), nullptr, /*allow_exceptions=*/false);
  return read.is_object() ? read : json::object();
}

}  // namespace

MeasuredJob RunMeasured(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0)
    throw EnvironmentError(fmt::format("cannot run {}: {}", words.front(), std::strerror(errno)));
  if (child == 0) {
    execv(arguments.front(), arguments.data());
    _exit(127);
  }
  int status = 0;
  struct rusage used {};
  while (wait4(child, &status, 0, &used) < 0)
    if (errno != EINTR)
      throw EnvironmentError(
          fmt::format("cannot wait for {}: {}", words.front(), std::strerror(errno)));
  constexpr double kMegabyte_kB = 1024;
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          static_cast<double>(used.ru_maxrss) / kMegabyte_kB,
          WIFEXITED(status) ? WEXITSTATUS(status) : -1};
}

void WriteStageNeeds(const std::string& folder, const std::string& stage, const StageNeeds& needs) {
  MakeOutputDirectory(folder);
  json all = Measured(folder);
  all[stage] = {{"seconds_per_photo", needs.seconds}, {"megabytes", needs.megabytes}};
  WriteFileAtomically(PathIn(folder), all.dump(2) + "\n");
}

std::optional<StageNeeds> ReadStageNeeds(const std::string& folder, const std::string& stage) {
  const json all = Measured(folder);
  if (!all.contains(stage) || !all[stage].is_object()) return std::nullopt;
  const json& of_stage = all[stage];
  const auto number = [&](const char* key) {
    return of_stage.contains(key) && of_stage[key].is_number() ? of_stage[key].get<double>() : 0.0;
  };
  const StageNeeds needs{number("seconds_per_photo"), number("megabytes")};
  constexpr double kDay_s = 86400, kMost_MB = 1e6;  // plausible, whoever wrote the file
  if (!(needs.seconds > 0 && needs.seconds < kDay_s)) return std::nullopt;
  if (!(needs.megabytes > 0 && needs.megabytes < kMost_MB)) return std::nullopt;
  return needs;
}

std::string OwnProgram() {
  const fs::path own = fs::read_symlink("/proc/self/exe");
  if (own.filename() == "orient") return own.string();
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path program = fs::path(folder) / "orient";
        access(program.c_str(), X_OK) == 0 && !fs::is_directory(program))
      return fs::absolute(program).string();
  throw UsageError("this is " + own.string() +
                   ", and there is no orient in PATH that jobs could run; add its folder");
}

}  // namespace orient

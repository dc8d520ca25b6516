#include "tools/commands/review/recorded_stages.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>

#include "block/stages/exterior_stage.h"
#include "core/base/error.h"
#include "core/files/adjustment_result.h"
#include "tools/commands/stage_runs.h"
#include "tools/report/run_record.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kMeasurements = "--measurements";

// The command's arguments without --measurements, whose folder goes to `folder`.
std::vector<std::string> WithoutMeasurements(const std::vector<std::string>& arguments,
                                             std::string* folder) {
  std::vector<std::string> others;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == kMeasurements && i + 1 < arguments.size())
      *folder = arguments[++i];
    else if (argument.starts_with(fmt::format("{}=", kMeasurements)))
      *folder = argument.substr(argument.find('=') + 1);
    else
      others.push_back(argument);
  }
  return others;
}

void RequireRepeatable(const std::string& directory, const RunRecord& run) {
  if (run.arguments.empty())
    throw UsageError(fmt::format(
        "run.json in {} does not hold the arguments that it was made with: it was written by an "
        "earlier program",
        directory));
  std::error_code ignored;
  if (fs::current_path(ignored) != run.directory)
    throw UsageError(
        fmt::format("{} was made in {}: start orient review there", directory, run.directory));
}

// The options of the folder's run of a stage, parsed by `read` from its arguments; empty if there
// was none.
template <typename Options>
std::optional<Options> AskedFor(const std::string& directory,
                                const std::map<std::string, RunRecord>& runs, const char* stage,
                                Options (*read)(const std::vector<std::string>&),
                                std::string* measurements) {
  const auto run = runs.find(stage);
  if (run == runs.end()) return std::nullopt;
  RequireRepeatable(directory, run->second);
  Options options = read(WithoutMeasurements(run->second.arguments, measurements));
  std::error_code ignored;
  if (!fs::equivalent(directory, options.out, ignored))
    throw UsageError(fmt::format("run.json in {} belongs to {}", directory, options.out));
  return options;
}

void ReadStages(const std::string& directory, RecordedStages* stages) {
  const auto runs = ReadRunRecords(directory);
  if (runs.contains("block") || fs::exists(AdjustmentResultPath(directory)))
    throw UsageError(fmt::format("{} is a block's folder: name its file with --block", directory));
  stages->interior = AskedFor(directory, runs, "interior", InteriorRunOf, &stages->measurements);
  stages->exterior = AskedFor(directory, runs, "exterior", ExteriorRunOf, &stages->measurements);
  if (!stages->interior && !stages->exterior)
    throw UsageError(fmt::format(
        "{} has no run.json of orient interior or orient exterior, which says what was done",
        directory));
}

}  // namespace

RecordedStages ReadRecordedStages(const std::string& directory) {
  RecordedStages stages;
  try {
    ReadStages(directory, &stages);
  } catch (const UsageError& error) {
    stages.why_not = error.what();
  } catch (const InputError& error) {
    stages.why_not = error.what();
  }
  return stages;
}

void DoAgain(const RecordedStages& stages, const Measurements& measurements, bool learn, int jobs,
             ProgressListener* listener) {
  std::optional<block::ExteriorRunOptions> exterior = stages.exterior;
  if (exterior) {
    exterior->measurements = measurements;
    exterior->learn = learn;
    exterior->resume = true;
    exterior->jobs = jobs;
    exterior->alone = true;
    // Refuses now what would otherwise be refused only after interior orientation.
    if (stages.interior) block::ExteriorsThatStay(*exterior);
  }
  if (auto interior = stages.interior) {
    interior->measurements = measurements;
    interior->resume = true;
    interior->redo_changed = false;
    interior->jobs = jobs;
    interior->alone = true;
    ProgressTask progress(listener, "interior orientation",
                          static_cast<int>(interior->photos.size()));
    block::RunInterior(*interior, [&] { progress.Advance(); });
  }
  if (exterior) {
    ProgressTask progress(listener, "exterior orientation",
                          static_cast<int>(exterior->photos.size()));
    block::RunExterior(*exterior, [&] { progress.Advance(); });
  }
}

}  // namespace orient

// What a job of the block needs, found out by running a small one.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace orient {

struct MeasuredJob {
  double seconds = 0;    // from its beginning to its end
  double megabytes = 0;  // the most memory that it held
  int exit_code = 0;
};

// Runs a program in a process of its own, whose output goes where this one's does. Throws
// EnvironmentError where no process can be made.
MeasuredJob RunMeasured(const std::vector<std::string>& words);

// Times and memory of one photo in a stage.
struct StageNeeds {
  double seconds = 0, megabytes = 0;
};
// <folder>/measured.json. Reading is empty where it is not there, or says nothing credible.
void WriteStageNeeds(const std::string& folder, const std::string& stage, const StageNeeds& needs);
std::optional<StageNeeds> ReadStageNeeds(const std::string& folder, const std::string& stage);

// The program that jobs are to run: this one, or where it is within another (Python) the `orient`
// of PATH. Throws UsageError where there is none.
std::string OwnProgram();

}  // namespace orient

#include "tools/cluster/job_scripts.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <span>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/embedded_file.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "tools/report/template.h"

namespace orient {

std::span<const EmbeddedFile> ClusterFiles();  // data/cluster; made by orient_embed()

namespace {
namespace fs = std::filesystem;

std::string_view ScriptTemplate(const std::string& name) {
  for (const EmbeddedFile& file : ClusterFiles())
    if (file.name == name) return file.contents;
  throw std::logic_error("there is no data/cluster/" + name);
}

// `fillings` must be shell text, or already quoted as shell words.
std::string Filled(const std::string& name,
                   const std::vector<std::pair<std::string_view, std::string>>& fillings) {
  std::vector<Markup> texts;
  texts.reserve(fillings.size());
  std::vector<Filling> filled;
  for (const auto& [place, text] : fillings) filled.emplace_back(place, texts.emplace_back(text));
  return FillText(name, ScriptTemplate(name), filled).Text() + "\n";
}

// Slurm parses these lines itself: no shell removes quotes there.
std::string MoreLines(const BlockJobs& jobs) {
  std::string lines;
  if (!jobs.partition.empty()) lines += "\n#SBATCH --partition=" + jobs.partition;
  if (!jobs.account.empty()) lines += "\n#SBATCH --account=" + jobs.account;
  return lines;
}

// Escaped for the quotes of Slurm's own line, in which % is special.
std::string LogFolder(const BlockJobs& jobs) {
  std::string escaped;
  for (const char c : (fs::path(jobs.folder) / "logs").string()) {
    if (static_cast<unsigned char>(c) < ' ' || c == '"' || c == '\\' || c == '\x7f')
      throw InputError(
          fmt::format("the name of the output folder {} has a character that Slurm does "
                      "not take for its logs; name another one",
                      jobs.folder));
    escaped += c == '%' ? "%%" : std::string(1, c);
  }
  return escaped;
}

std::string BlockWords(const BlockJobs& jobs, const std::string& options, int cpus) {
  const std::string library =
      jobs.camera_library.empty() ? "" : " --camera-library " + ShellWord(jobs.camera_library);
  return fmt::format("block {}{} {} --jobs {}", ShellWord(jobs.block), library, options, cpus);
}

// What one job does; a job array if there are tasks.
struct Work {
  std::string name;
  int tasks = 0;
  std::string what, words;  // for a person; for the program
  int cpus = 1;
  JobNeeds needs;
  bool after_success = false;
};

JobScript ScriptOf(const BlockJobs& jobs, const Work& work) {
  const bool array = work.tasks > 0;
  const std::string tasks = array ? fmt::format("\n#SBATCH --array=1-{}", work.tasks) : "";
  return {work.name + ".sh", work.tasks, work.after_success,
          Filled("job.sh", {{"name", work.name},
                            {"cpus", std::to_string(work.cpus)},
                            {"megabytes", std::to_string(work.needs.megabytes)},
                            {"minutes", SlurmTime(work.needs.minutes)},
                            {"logs", LogFolder(jobs)},
                            {"log", work.name + (array ? "_%a" : "")},
                            {"more", MoreLines(jobs) + tasks},
                            {"what", work.what},
                            {"orient", ShellWord(jobs.program)},
                            {"words", work.words}})};
}

JobScript Part(const BlockJobs& jobs, const std::string& stage, const JobNeeds& needs) {
  const std::string what = fmt::format(
      "Task K processes photos K, K + {0}, K + 2 x {0} ... of the block. What is done is kept,\n"
      "# whoever did it: a task may be repeated at any time, and what a lost one has left the next "
      "job does.",
      jobs.parts);
  const std::string options =
      fmt::format("--stage {} --part \"$SLURM_ARRAY_TASK_ID/{}\"", stage, jobs.parts);
  return ScriptOf(jobs, {stage, jobs.parts, what, BlockWords(jobs, options, 1), 1, needs});
}

JobScript Whole(const BlockJobs& jobs, const std::string& name, const std::string& what,
                const std::string& options, const JobNeeds& needs) {
  return ScriptOf(jobs, {name, 0, what, BlockWords(jobs, options, jobs.cpus), jobs.cpus, needs});
}

std::string Submitted(const JobScript& script) {
  return "submit " + script.file + (script.after_success ? " afterok" : "");
}

std::string SubmitScript(const std::vector<JobScript>& chain) {
  std::string jobs;
  for (const JobScript& script : chain) jobs += (jobs.empty() ? "" : "\n") + Submitted(script);
  return Filled("submit.sh", {{"jobs", jobs}});
}

std::string LocalScript(const BlockJobs& plan, const std::vector<JobScript>& chain) {
  std::string jobs;
  for (const JobScript& script : chain) {
    if (!jobs.empty()) jobs += "\n";
    jobs += script.tasks > 0 ? fmt::format("array {} {}", script.file, script.tasks)
                             : Submitted(script);
  }
  return Filled("local.sh", {{"jobs", jobs}, {"at_once", std::to_string(plan.cpus)}});
}

}  // namespace

std::string ShellWord(const std::string& text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
      "0123456789_-./,:=+@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string SlurmTime(int minutes) {
  const int days = minutes / (24 * 60), hours = minutes / 60 % 24;
  return fmt::format("{}-{:02}:{:02}:00", days, hours, minutes % 60);
}

std::vector<JobScript> JobChain(const BlockJobs& jobs) {
  std::vector<JobScript> chain;
  if (jobs.control)
    chain.push_back(Whole(jobs, "control", "The control patches that the block file asks for.",
                          "--stage control", jobs.whole));
  if (jobs.film) {
    chain.push_back(Part(jobs, "interior", jobs.interior));
    chain.push_back(Whole(jobs, "roll",
                          "What is left of interior orientation, and the photos of the roll "
                          "compared with each other.",
                          "--stage interior", jobs.roll));
  }
  for (int i = 0; i < jobs.rounds; ++i) chain.push_back(Part(jobs, "exterior", jobs.exterior));
  chain.push_back(Whole(jobs, "whole", "What is left: neighbours, ties, adjustment, report.",
                        jobs.learn ? "--resume --learn" : "--resume", jobs.whole));
  if (!jobs.place.empty()) {
    const std::string out = fs::path(jobs.folder).parent_path().string();
    chain.push_back(
        ScriptOf(jobs, {"upload", 0, "The output folder, once the block has been oriented.",
                        "upload " + ShellWord(out) + " " + ShellWord(jobs.place) +
                            (jobs.overwrite ? " --overwrite" : ""),
                        1, jobs.upload,
                        /*after_success=*/true}));
  }
  return chain;
}

std::vector<std::string> JobScriptPaths(const BlockJobs& jobs) {
  std::set<std::string> files = {"submit.sh", "local.sh"};
  for (const JobScript& script : JobChain(jobs)) files.insert(script.file);
  std::vector<std::string> paths;
  for (const std::string& file : files) paths.push_back((fs::path(jobs.folder) / file).string());
  return paths;
}

std::vector<std::string> WriteJobScripts(const BlockJobs& jobs) {
  MakeOutputDirectory((fs::path(jobs.folder) / "logs").string());
  const std::vector<JobScript> chain = JobChain(jobs);
  const auto write = [&](const std::string& file, const std::string& text) {
    const fs::path path = fs::path(jobs.folder) / file;
    WriteFileAtomically(path.string(), text);
    constexpr auto kExecutable =
        fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec;
    fs::permissions(path, kExecutable, fs::perm_options::add);
  };
  for (const JobScript& script : chain) write(script.file, script.text);
  write("submit.sh", SubmitScript(chain));
  write("local.sh", LocalScript(jobs, chain));
  return JobScriptPaths(jobs);
}

}  // namespace orient

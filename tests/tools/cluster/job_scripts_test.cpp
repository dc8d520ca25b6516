#include "tools/cluster/job_scripts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/shared_data.h"
#include "tools/cluster/measured_job.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

BlockJobs ExampleJobs(const std::string& folder) {
  BlockJobs jobs;
  jobs.program = "/usr/bin/orient";
  jobs.block = "/data/block.toml";
  jobs.folder = folder;
  jobs.film = true;
  jobs.parts = 7;
  return jobs;
}

std::vector<std::string> Files(const std::vector<JobScript>& chain) {
  std::vector<std::string> files;
  for (const JobScript& script : chain) files.push_back(script.file);
  return files;
}

// What a shell with no Slurm and a program that notes its words makes of the scripts.
std::string WordsOfLocalRun(BlockJobs jobs, const std::string& folder) {
  const fs::path program = fs::path(folder) / "a program's place" / "orient";
  fs::create_directories(program.parent_path());
  std::ofstream(program) << "#!/bin/bash\nprintf '<%s>' \"$@\" >>'" << folder << "/words'\necho >>'"
                         << folder << "/words'\n";
  fs::permissions(program, fs::perms::owner_all);
  jobs.program = program.string();
  WriteJobScripts(jobs);
  EXPECT_EQ(std::system(("bash " + ShellWord(jobs.folder + "/local.sh")).c_str()), 0);
  return ReadFile(folder + "/words");
}

TEST(JobScripts, FilmGoesFromMarksToTheWholeBlock) {
  BlockJobs jobs = ExampleJobs("/data/out/slurm");
  jobs.control = true;
  jobs.rounds = 2;
  EXPECT_EQ(Files(JobChain(jobs)),
            (std::vector<std::string>{"control.sh", "interior.sh", "roll.sh", "exterior.sh",
                                      "exterior.sh", "whole.sh"}));
}

TEST(JobScripts, TheRunOfTheWholeBlockAloneLearns) {
  BlockJobs jobs = ExampleJobs("/data/out/slurm");
  jobs.learn = true;
  for (const JobScript& script : JobChain(jobs))
    EXPECT_EQ(script.text.find("--learn") != std::string::npos, script.file == "whole.sh")
        << script.text;
  jobs.learn = false;
  EXPECT_EQ(JobChain(jobs).back().text.find("--learn"), std::string::npos);
}

TEST(JobScripts, DigitalPhotosHaveNoInteriorStage) {
  BlockJobs jobs = ExampleJobs("/data/out/slurm");
  jobs.film = false;
  EXPECT_EQ(Files(JobChain(jobs)), (std::vector<std::string>{"exterior.sh", "whole.sh"}));
}

TEST(JobScripts, AskForWhatTheyAreToldTo) {
  BlockJobs jobs = ExampleJobs("/data/out/slurm");
  jobs.exterior = {90, 750};
  jobs.partition = "long";
  jobs.account = "archive";
  const std::string text = JobChain(jobs)[2].text;
  for (const char* line :
       {"#SBATCH --array=1-7\n", "#SBATCH --time=0-01:30:00\n", "#SBATCH --mem=750M\n",
        "#SBATCH --partition=long\n", "#SBATCH --account=archive\n", "#SBATCH --requeue\n",
        "#SBATCH --output=\"/data/out/slurm/logs/exterior_%a.log\"\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
}

TEST(JobScripts, RunEveryPartOnceOnOneMachine) {
  const TemporaryFolder folder;
  std::string words = WordsOfLocalRun(ExampleJobs(folder / "out/slurm"), folder.Path());
  for (int part = 1; part <= 7; ++part)
    for (const std::string stage : {"interior", "exterior"}) {
      const std::string line = "<block></data/block.toml><--stage><" + stage + "><--part><" +
                               std::to_string(part) + "/7><--jobs><1>\n";
      const auto at = words.find(line);
      ASSERT_NE(at, std::string::npos) << line << "in\n" << words;
      words.erase(at, line.size());
    }
  EXPECT_EQ(words,
            "<block></data/block.toml><--stage><interior><--jobs><1>\n"
            "<block></data/block.toml><--resume><--jobs><1>\n");
}

TEST(JobScripts, KeepNamesWithBlanksAndQuotesWhole) {
  const TemporaryFolder folder;
  BlockJobs jobs = ExampleJobs(folder / "my 50 % of Nuri's $HOME/slurm");
  jobs.block = "/data/it's `mine` \"$HOME\".toml";
  jobs.camera_library = "/cameras of\tus";
  const std::string words = WordsOfLocalRun(jobs, folder.Path());
  EXPECT_NE(words.find("<block><" + jobs.block + "><--camera-library><" + jobs.camera_library +
                       "><--stage><interior><--part><3/7>"),
            std::string::npos)
      << words;
}

TEST(JobScripts, UploadTheOutputFolderOfABlockThatIsDone) {
  const TemporaryFolder folder;
  BlockJobs jobs = ExampleJobs(folder / "my out/slurm");
  jobs.cpus = 128;
  jobs.place = "s3://archive/roll 7";
  EXPECT_EQ(Files(JobChain(jobs)).back(), "upload.sh");
  const std::string words = WordsOfLocalRun(jobs, folder.Path());
  EXPECT_TRUE(words.ends_with("<--resume><--jobs><128>\n<upload><" + (folder / "my out") +
                              "><s3://archive/roll 7>\n"))
      << words;
  EXPECT_NE(ReadFile(folder / "my out/slurm/submit.sh").find("submit upload.sh afterok\n"),
            std::string::npos);
}

TEST(JobScripts, UploadNothingOfABlockThatIsNotDone) {
  const TemporaryFolder folder;
  std::ofstream(folder / "orient") << "#!/bin/bash\n"
                                   << "[ $1 != upload ] || touch '" << folder.Path()
                                   << "/uploaded'\n[[ $* != *--resume* ]] || exit 2\n";
  fs::permissions(folder / "orient", fs::perms::owner_all);
  BlockJobs jobs = ExampleJobs(folder / "slurm");
  jobs.program = folder / "orient";
  jobs.place = "s3://archive/roll 7";
  WriteJobScripts(jobs);
  EXPECT_NE(std::system(("bash " + ShellWord(folder / "slurm/local.sh") + " 2>/dev/null").c_str()),
            0);
  EXPECT_FALSE(fs::exists(folder / "uploaded"));
}

TEST(JobScripts, AFolderThatSlurmCannotNameIsRefused) {
  BlockJobs jobs = ExampleJobs("/data/50 % # of us/slurm");
  EXPECT_NE(
      JobChain(jobs)[0].text.find("--output=\"/data/50 %% # of us/slurm/logs/interior_%a.log\""),
      std::string::npos);
  for (const char* folder : {"/o\n$(touch x)\n/slurm", "/a\"b/slurm", "/a\\b/slurm"}) {
    jobs.folder = folder;
    EXPECT_THROW(JobChain(jobs), InputError) << folder;
  }
}

TEST(JobScripts, NoJobOfSomebodyElseIsRepeated) {
  const TemporaryFolder folder;
  std::ofstream(folder / "scontrol")
      << "#!/bin/bash\necho \"$@\" >>'" << folder.Path() << "/repeated'\n";
  std::ofstream(folder / "orient") << "#!/bin/bash\nkill -KILL $$\n";
  for (const char* file : {"scontrol", "orient"})
    fs::permissions(folder / file, fs::perms::owner_all);
  BlockJobs jobs = ExampleJobs(folder / "slurm");
  jobs.program = folder / "orient";
  WriteJobScripts(jobs);
  const std::string run = "SLURM_JOB_ID=777 PATH=" + folder.Path() + ":$PATH bash " +
                          ShellWord(folder / "slurm/local.sh") + " 2>/dev/null";
  EXPECT_NE(std::system(run.c_str()), 0) << "the last job was killed";
  EXPECT_FALSE(fs::exists(folder / "repeated"));
}

TEST(JobScripts, HalfAChainIsNotLeftInTheQueue) {
  const TemporaryFolder folder;
  std::ofstream(folder / "sbatch") << "#!/bin/bash\n[[ $* != *roll.sh ]] && echo 101\n";
  std::ofstream(folder / "scancel")
      << "#!/bin/bash\necho \"$@\" >'" << folder.Path() << "/cancelled'\n";
  for (const char* file : {"sbatch", "scancel"})
    fs::permissions(folder / file, fs::perms::owner_all);
  WriteJobScripts(ExampleJobs(folder / "slurm"));
  const std::string run = "PATH=" + folder.Path() + ":$PATH bash " +
                          ShellWord(folder / "slurm/submit.sh") + " >/dev/null 2>&1";
  EXPECT_NE(std::system(run.c_str()), 0);
  EXPECT_EQ(ReadFile(folder / "cancelled"), "101\n");
}

TEST(JobScripts, ALostTaskDoesNotEndTheChain) {
  const TemporaryFolder folder;
  BlockJobs jobs = ExampleJobs(folder / "slurm");
  WriteJobScripts(jobs);
  const std::string submit = ReadFile(folder / "slurm/submit.sh");
  EXPECT_NE(submit.find("--dependency=${2:-afterany}:$after"), std::string::npos);
  EXPECT_EQ(submit.find("afterok"), std::string::npos);
}

TEST(JobScripts, TimesAreSlurms) {
  EXPECT_EQ(SlurmTime(5), "0-00:05:00");
  EXPECT_EQ(SlurmTime(26 * 60 + 30), "1-02:30:00");
}

TEST(MeasuredJob, KnowsTimeMemoryAndExitCode) {
  const MeasuredJob job = RunMeasured({"/bin/bash", "-c", "sleep 0.2; exit 3"});
  EXPECT_EQ(job.exit_code, 3);
  EXPECT_GT(job.seconds, 0.15);
  EXPECT_GT(job.megabytes, 0.5);
  EXPECT_EQ(RunMeasured({"/no/such/program"}).exit_code, 127);
}

TEST(MeasuredJob, IsRememberedPerStage) {
  const TemporaryFolder folder;
  EXPECT_FALSE(ReadStageNeeds(folder.Path(), "interior"));
  WriteStageNeeds(folder.Path(), "interior", {2.5, 300});
  WriteStageNeeds(folder.Path(), "exterior", {1.5, 200});
  EXPECT_EQ(ReadStageNeeds(folder.Path(), "interior")->seconds, 2.5);
  EXPECT_EQ(ReadStageNeeds(folder.Path(), "exterior")->megabytes, 200);
  std::ofstream(folder / "measured.json") << "{";
  EXPECT_FALSE(ReadStageNeeds(folder.Path(), "exterior")) << "a damaged one is measured again";
}

}  // namespace
}  // namespace orient

// A block's work as jobs of Slurm: scripts that run `orient block` stage by stage and part by part.
#pragma once

#include <string>
#include <vector>

namespace orient {

// Of the scripts and their logs, in the block's output folder.
inline constexpr const char* kJobsFolder = "slurm";

// What a job asks for.
struct JobNeeds {
  int minutes = 60;
  int megabytes = 2000;
};

struct BlockJobs {
  std::string program, block;  // absolute paths
  std::string camera_library;  // the same; empty: the program's own
  std::string folder;          // absolute: kJobsFolder of the output folder
  bool control = false;        // the block file makes its own control
  bool film = false;           // there is interior orientation to do
  int parts = 1;               // of a stage, at most Slurm's largest array
  int rounds = 1;  // of exterior orientation, where photos wait for those of other parts
  int cpus = 1;    // of the run of the whole block
  JobNeeds interior, exterior;     // of one part
  JobNeeds roll, whole, upload;    // of all photos
  std::string place;               // object storage that takes the output folder; empty: none
  bool overwrite = false;          // what lies there
  bool learn = false;              // the run of the whole block records in the patch database
  std::string partition, account;  // empty: Slurm's own choice
};

// One job of the chain, in its order; each waits for the one before it.
struct JobScript {
  std::string file;            // "exterior.sh"
  int tasks = 0;               // of an array; 0: one job
  bool after_success = false;  // of the one before it, not after any end of it
  std::string text;
};

// control, interior and roll of film, exterior as often as there are rounds, whole, upload. Scripts
// that occur several times have the same text. Throws InputError if Slurm does not accept the
// folder's name.
std::vector<JobScript> JobChain(const BlockJobs& jobs);

// Writes the chain's scripts, submit.sh and local.sh into `jobs.folder`, all executable; returns
// their paths. Throws InputError where they cannot be written.
std::vector<std::string> WriteJobScripts(const BlockJobs& jobs);
std::vector<std::string> JobScriptPaths(const BlockJobs& jobs);

// As one word of a shell: quoted where it has to be.
std::string ShellWord(const std::string& text);

// Minutes as Slurm takes them: "1-02:30:00".
std::string SlurmTime(int minutes);

}  // namespace orient

// run.json: which commands made an output folder, when, and from what.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace orient {

struct RunInput {
  std::string what, path;  // "DEM", as the user named it
  std::string digest;      // tells contents apart (block/inputs/digest.h); empty: cannot be read
};

struct RunRecord {
  std::string program;  // "orient 0.1.0"
  std::string command;  // as typed
  std::string started;  // UTC, ISO 8601
  double seconds = 0;
  std::vector<RunInput> inputs;
  std::string directory = {};               // in which it was typed; names may be relative to it
  std::vector<std::string> arguments = {};  // the command's, without the program's name
};

// As run.json and report.json hold it.
nlohmann::ordered_json JsonOf(const RunRecord& record);
// As the metadata of GeoPackages hold it: JSON without times and without how the command was typed,
// so that the same inputs give the same file. Invalid UTF-8 is replaced.
std::string ProgramAndInputs(const RunRecord& record);

// Replaces the record of an earlier run of the same stage ("interior", "exterior", "block",
// "ortho").
void WriteRunRecord(const std::string& directory, const std::string& stage,
                    const RunRecord& record);

// By stage. Empty where there is no such file, and for a damaged one: results do not depend on it.
std::map<std::string, RunRecord> ReadRunRecords(const std::string& directory);

}  // namespace orient

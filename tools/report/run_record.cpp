#include "tools/report/run_record.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string PathIn(const std::string& directory) {
  return (fs::path(directory) / "run.json").string();
}

RunRecord RecordOf(const Json& json) {
  RunRecord record{
      json.at("program"), json.at("command"), json.at("started"), json.at("seconds"), {}, {}, {}};
  record.directory = json.value("directory", std::string());  // older ones have neither
  record.arguments = json.value("arguments", std::vector<std::string>());
  for (const Json& input : json.at("inputs"))
    record.inputs.push_back({input.at("what"), input.at("path"), input.at("digest")});
  return record;
}

}  // namespace

nlohmann::ordered_json JsonOf(const RunRecord& record) {
  Json inputs = Json::array();
  for (const RunInput& input : record.inputs)
    inputs.push_back({{"what", input.what}, {"path", input.path}, {"digest", input.digest}});
  return {
      {"program", record.program},    {"command", record.command}, {"started", record.started},
      {"seconds", record.seconds},    {"inputs", inputs},          {"directory", record.directory},
      {"arguments", record.arguments}};
}

std::string ProgramAndInputs(const RunRecord& record) {
  const Json json = JsonOf(record);
  return Json{{"program", json.at("program")}, {"inputs", json.at("inputs")}}.dump(
      -1, ' ', false, Json::error_handler_t::replace);
}

void WriteRunRecord(const std::string& directory, const std::string& stage,
                    const RunRecord& record) {
  Json json = Json::object();
  for (const auto& [name, earlier] : ReadRunRecords(directory)) json[name] = JsonOf(earlier);
  json[stage] = JsonOf(record);
  WriteFileAtomically(PathIn(directory),
                      json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::map<std::string, RunRecord> ReadRunRecords(const std::string& directory) {
  const std::string path = PathIn(directory);
  std::map<std::string, RunRecord> records;
  if (!fs::is_regular_file(path)) return records;
  try {
    const Json json = Json::parse(ReadFile(path));
    for (const auto& item : json.items()) records[item.key()] = RecordOf(item.value());
  } catch (const Json::exception&) {
    return {};
  }
  return records;
}

}  // namespace orient

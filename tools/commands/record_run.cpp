#include "tools/commands/record_run.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <filesystem>

#include "block/inputs/digest.h"
#include "core/base/error.h"
#include "core/base/remote_files.h"
#include "patchdb/regions/region_index.h"

namespace orient {
namespace {

std::string WorkingDirectory() {
  std::error_code ignored;
  return std::filesystem::current_path(ignored).string();
}

}  // namespace

RunInput FileInput(const std::string& what, const std::string& path) {
  return {what, path, path.empty() ? "" : block::DigestOfFile(path)};
}

RunInput PatchesInput(const std::string& patchdb) {
  return FileInput("patch database",
                   patchdb::IsRegionFolder(patchdb) ? patchdb::RegionIndexPath(patchdb) : patchdb);
}

RunInput RasterInput(const std::string& what, const std::string& path) {
  return {what, path, path.empty() ? "" : block::DigestOfRaster(path)};
}

void RecordRun(const Invocation& invocation, const std::string& directory, const std::string& stage,
               const std::vector<RunInput>& inputs) {
  RunRecord record{invocation.program,
                   WithoutSecrets(invocation.command),
                   fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(invocation.started)),
                   std::difftime(std::time(nullptr), invocation.started),
                   {},
                   WorkingDirectory(),
                   {}};
  for (const std::string& argument : invocation.arguments)
    record.arguments.push_back(WithoutSecrets(argument));
  for (const RunInput& input : inputs)
    if (!input.path.empty()) record.inputs.push_back(input);
  try {
    WriteRunRecord(directory, stage, record);
  } catch (const InputError&) {  // no result depends on it
  }
}

}  // namespace orient

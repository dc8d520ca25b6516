#include "tools/commands/patchdb_to_write.h"

#include <ostream>

#include "core/base/error.h"
#include "patchdb/regions/region_index.h"
#include "patchdb/store/older_file.h"

namespace orient {

patchdb::PatchDatabase OpenToWrite(const std::string& path, std::ostream& out) {
  const auto older = patchdb::OlderVersion(path);
  patchdb::PatchDatabase database =
      patchdb::PatchDatabase::Open(path, patchdb::PatchDatabase::Mode::kWrite);
  if (older)
    out << path << ": upgraded from schema version " << *older << " to "
        << database.Info().schema_version << "\n";
  return database;
}

void BringUpToDateToLearn(const std::string& path, std::ostream& out) {
  std::vector<std::string> files = {path};
  if (patchdb::IsRegionFolder(path))
    files = patchdb::RegionFiles(path, patchdb::ReadRegionIndex(path));
  try {
    for (const std::string& file : files)
      if (patchdb::OlderVersion(file)) OpenToWrite(file, out);
  } catch (const InputError& error) {
    throw InputError(
        std::string(error.what()) +
        "; the patch database cannot be written: leave out --learn, or give a writable copy");
  }
}

}  // namespace orient

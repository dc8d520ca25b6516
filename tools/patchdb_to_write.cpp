#include "tools/patchdb_to_write.h"

#include <ostream>

#include "patchdb/older_file.h"

namespace orient {

PatchDatabase OpenToWrite(const std::string& path, std::ostream& out) {
  const auto older = OlderVersion(path);
  PatchDatabase database = PatchDatabase::Open(path, PatchDatabase::Mode::kWrite);
  if (older)
    out << path << ": brought up to date, from schema version " << *older << " to "
        << database.Info().schema_version << "\n";
  return database;
}

}  // namespace orient

#include "patchdb/store/is_patch_database.h"

#include <filesystem>

#include "core/base/error.h"
#include "patchdb/store/connection.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {

bool IsPatchDatabase(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  try {
    Connection connection(path, Connection::Mode::kRead);
    return WithFile(path, "opening the file",
                    [&] { return connection.Number(sql::kHasSchemaTable) == 1; });
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace orient::patchdb

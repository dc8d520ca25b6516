#include "patchdb/store/older_file.h"

#include <filesystem>

#include "patchdb/store/connection.h"
#include "patchdb/store/migration.h"
#include "patchdb/store/schema.h"

namespace orient::patchdb {

std::optional<int> OlderVersion(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  Connection connection(path, Connection::Mode::kRead);
  return WithFile(connection, "opening the database", [&]() -> std::optional<int> {
    const int version = CheckedSchemaVersion(connection, path);
    if (version == CurrentSchemaVersion()) return std::nullopt;
    return version;
  });
}

}  // namespace orient::patchdb

#include "patchdb/older_file.h"

#include <filesystem>

#include "patchdb/connection.h"
#include "patchdb/migration.h"
#include "patchdb/schema.h"

namespace orient {

std::optional<int> OlderVersion(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  return WithFile(path, "opening the database", [&]() -> std::optional<int> {
    Connection connection(path, Connection::Mode::kRead);
    const int version = CheckedSchemaVersion(connection, path);
    if (version == CurrentSchemaVersion()) return std::nullopt;
    return version;
  });
}

}  // namespace orient

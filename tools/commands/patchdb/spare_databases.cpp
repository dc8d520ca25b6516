#include "tools/commands/patchdb/spare_databases.h"

#include <fstream>
#include <string_view>

#include "core/base/error.h"

namespace orient {

void RefuseToReplaceDatabase(const std::vector<std::string>& outputs) {
  static constexpr char kText[] = "SQLite format 3";
  constexpr std::string_view kSignature(kText, sizeof kText);  // with its zero
  for (const std::string& path : outputs) {
    std::string start(kSignature.size(), ' ');
    std::ifstream file(path, std::ios::binary);
    if (!file.read(start.data(), static_cast<std::streamsize>(start.size()))) continue;
    if (start == kSignature)
      throw UsageError(path + " is a database and would be lost; give the output another name");
  }
}

}  // namespace orient

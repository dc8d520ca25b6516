// Schema version 6: the file itself states how a GIS is to draw its patches, and which program made
// it or upgraded it to this version. A style that a user has given the patches is kept.

#include <span>
#include <utility>

#include "core/base/embedded_file.h"
#include "core/base/geopackage/self_description.h"
#include "patchdb/store/schema.h"

namespace orient {
std::span<const EmbeddedFile> PatchdbFiles();  // made by orient_embed()
}

namespace orient::patchdb {

std::vector<std::string> SelfDescription() {
  std::vector<std::string> statements =
      StatementsOfStyles({{"patches", std::string(PatchdbFiles().front().contents), "by state"}});
  for (std::string& statement :
       StatementsOfMetadata({{"orient_patchdb", R"({"program":"orient )" ORIENT_VERSION R"("})"}}))
    statements.push_back(std::move(statement));
  return statements;
}

const SchemaStep kSchemaStep6 = {6, "how patches are drawn, and the program that made the file", "",
                                 true, &SelfDescription};

}  // namespace orient::patchdb

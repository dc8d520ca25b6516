#include "patchdb/store/content_digest.h"

#include "core/base/error.h"
#include "patchdb/store/connection.h"
#include "patchdb/store/schema.h"
#include "patchdb/store/statements.h"

namespace orient::patchdb {
namespace {

// Maintained by triggers (patchdb/store/schema/step_4.cpp), whichever program changes the patches.
constexpr const char* kToken = "SELECT hex(token) FROM orient_content";
constexpr const char* kKeepers =
    "SELECT count(*) FROM sqlite_master WHERE name IN ('orient_content', 'orient_content_insert', "
    "'orient_content_delete', 'orient_content_update', 'orient_content_state')";
constexpr int kAllKeepers = 5;

}  // namespace

std::string ContentOf(const PatchDatabase& database) {
  return WithFile(database.Sql(), "read", [&] {
    Connection& connection = database.Sql();
    if (connection.Number(sql::kSchemaVersion) < kFirstSchemaWithToken)
      return connection.Database().execAndGet("SELECT hex(randomblob(16))").getString();
    std::optional<std::string> token;
    if (connection.Number(kKeepers) == kAllKeepers)
      if (const Query row = connection.Prepare(kToken); row->executeStep())
        token = row->getColumn(0).getString();
    if (!token)
      throw InputError(database.Path() +
                       " is damaged: it does not record changes of patches; 'orient patchdb check "
                       "--repair' repairs that");
    return *token + database.GroundCrs().Wkt();
  });
}

}  // namespace orient::patchdb

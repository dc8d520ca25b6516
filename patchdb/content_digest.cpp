#include "patchdb/content_digest.h"

#include "core/error.h"
#include "patchdb/connection.h"

namespace orient {
namespace {

// Kept by triggers (patchdb/schema/step_4.cpp), whoever changes the patches.
constexpr const char* kToken = "SELECT hex(token) FROM orient_content";

}  // namespace

std::string ContentOf(const PatchDatabase& database) {
  return WithFile(database.Path(), "read", [&] {
    const Query row = database.Sql().Prepare(kToken);
    if (!row->executeStep())
      throw InputError(database.Path() +
                       " is damaged: table orient_content is empty; 'orient patchdb "
                       "check --repair' fills it");
    return row->getColumn(0).getString() + database.GroundCrs().Wkt();
  });
}

}  // namespace orient

// Schema version 5: every change of a patch's state changes the token. Learning from attempts does
// not (it makes no photo's orientation out of date): it restores the previous token
// (patchdb/store/learn.cpp), whereas version 4 recognised its retirements by their reason's words.

#include "patchdb/store/schema.h"

namespace orient::patchdb {
namespace {

constexpr const char* kSql = R"sql(
DROP TRIGGER IF EXISTS orient_content_state;
CREATE TRIGGER orient_content_state AFTER UPDATE OF state ON patches WHEN OLD.state <> NEW.state
  BEGIN UPDATE orient_content SET token = randomblob(16); END;
)sql";

}  // namespace

const SchemaStep kSchemaStep5 = {5, "the token changes with every change of a state", kSql, true};

}  // namespace orient::patchdb

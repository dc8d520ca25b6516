// Schema version 5: every change of a patch's state changes the token. What attempts teach does not
// (they make no photo's orientation old): who learns puts the token back that was there before
// (patchdb/store/learn.cpp), where version 4 told a retirement by learning from its reason's words.

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

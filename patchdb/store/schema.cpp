#include "patchdb/store/schema.h"

namespace orient::patchdb {

const std::vector<SchemaStep>& SchemaSteps() {
  static const std::vector<SchemaStep> kSteps = {kSchemaStep1, kSchemaStep2, kSchemaStep3,
                                                 kSchemaStep4, kSchemaStep5, kSchemaStep6};
  return kSteps;
}

int CurrentSchemaVersion() { return SchemaSteps().back().version; }

}  // namespace orient::patchdb

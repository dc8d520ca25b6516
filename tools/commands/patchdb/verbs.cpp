#include "tools/commands/patchdb/verb.h"

namespace orient {

std::vector<std::unique_ptr<PatchdbVerb>> MakeMaintenanceVerbs() {
  std::vector<std::unique_ptr<PatchdbVerb>> verbs;
  for (const auto& make :
       {MakeListVerb, MakeQueryVerb, MakeShowVerb, MakeStatsVerb, MakeRetireVerb, MakeRestoreVerb,
        MakePruneVerb, MakeMergeVerb, MakeUpdateVerb, MakeDivideVerb, MakeIndexVerb, MakeExportVerb,
        MakeCheckVerb, MakeCompactVerb})
    verbs.push_back(make());
  return verbs;
}

}  // namespace orient

// One `orient patchdb <verb>`: declares its options, then works. A verb lives in one file of
// tools/patchdb/ and is listed in verbs.cpp.
#pragma once

#include <iosfwd>
#include <memory>
#include <vector>

namespace CLI {
class App;
}

namespace orient {

class PatchdbVerb {
 public:
  virtual ~PatchdbVerb() = default;
  virtual CLI::App* Declare(CLI::App& app) = 0;
  virtual void Run(std::ostream& out) = 0;
};

std::unique_ptr<PatchdbVerb> MakeAddGcpVerb();
std::unique_ptr<PatchdbVerb> MakeHarvestVerb();
std::unique_ptr<PatchdbVerb> MakeHarvestOrthoVerb();
std::unique_ptr<PatchdbVerb> MakeListVerb();
std::unique_ptr<PatchdbVerb> MakeQueryVerb();
std::unique_ptr<PatchdbVerb> MakeShowVerb();
std::unique_ptr<PatchdbVerb> MakeStatsVerb();
std::unique_ptr<PatchdbVerb> MakeRetireVerb();
std::unique_ptr<PatchdbVerb> MakeRestoreVerb();
std::unique_ptr<PatchdbVerb> MakePruneVerb();
std::unique_ptr<PatchdbVerb> MakeMergeVerb();
std::unique_ptr<PatchdbVerb> MakeUpdateVerb();
std::unique_ptr<PatchdbVerb> MakeDivideVerb();
std::unique_ptr<PatchdbVerb> MakeIndexVerb();
std::unique_ptr<PatchdbVerb> MakeExportVerb();
std::unique_ptr<PatchdbVerb> MakeCheckVerb();
std::unique_ptr<PatchdbVerb> MakeCompactVerb();

// What looks after a database that exists; making one is orient_patchdb.cpp's, filling
// one harvest_verbs.cpp's.
std::vector<std::unique_ptr<PatchdbVerb>> MakeMaintenanceVerbs();

}  // namespace orient

// orient patchdb list: every patch as a line of CSV, so that it can be piped.

#include <CLI/CLI.hpp>
#include <ostream>

#include "tools/commands/patchdb/filter_options.h"
#include "tools/commands/patchdb/summary_csv.h"
#include "tools/commands/patchdb/verb.h"

namespace orient {
namespace {

class ListVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("list", "Print every patch as a line of CSV");
    verb->add_option("DB", path_, "Patch database")->required();
    choice_.DeclareState(*verb);
    return verb;
  }
  void Run(std::ostream& out) override {
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    PrintSummaryHeader(out);
    out << "\n";
    patchdb::VisitPatches(database, choice_.Filter(database),
                          [&](const patchdb::PatchSummary& patch) {
                            PrintSummary(patch, out);
                            out << "\n";
                          });
  }

 private:
  std::string path_;
  FilterOptions choice_{"all"};
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeListVerb() { return std::make_unique<ListVerb>(); }

}  // namespace orient

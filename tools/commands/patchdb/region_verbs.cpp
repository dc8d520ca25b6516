// orient patchdb divide, index: folders of databases, each of a region.

#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>

#include "patchdb/regions/divide.h"
#include "tools/commands/patchdb/region_table.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/progress.h"

namespace orient {
namespace {

class DivideVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb =
        app.add_subcommand("divide", "Copy a database into databases of square regions");
    verb->add_option("DB", path_, "Patch database")->required();
    verb->add_option("FOLDER", folder_, "Folder to make")->required();
    verb->add_option("--cell-m", cell_m_, "Side of a region in metres (default 10000)")
        ->check(CLI::Range(1, 10'000'000));
    return verb;
  }
  void Run(std::ostream& out) override {
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    std::unique_ptr<ProgressLine> progress;
    const patchdb::RegionIndex index =
        patchdb::DivideDatabase(database, folder_, cell_m_, [&](int, int total) {
          if (!progress) progress = std::make_unique<ProgressLine>("regions", total);
          progress->Advance();
        });
    progress.reset();
    PrintRegions(index, out);
  }

 private:
  std::string path_, folder_;
  int cell_m_ = 10'000;
};

class IndexVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb =
        app.add_subcommand("index", "List what the databases of a folder of regions hold");
    verb->add_option("FOLDER", folder_, "Folder of patch databases (*.gpkg)")->required();
    return verb;
  }
  void Run(std::ostream& out) override { PrintRegions(patchdb::IndexRegions(folder_), out); }

 private:
  std::string folder_;
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeDivideVerb() { return std::make_unique<DivideVerb>(); }
std::unique_ptr<PatchdbVerb> MakeIndexVerb() { return std::make_unique<IndexVerb>(); }

}  // namespace orient

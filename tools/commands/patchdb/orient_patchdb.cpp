// orient patchdb: make and fill the database of control patches; what looks after it is in
// tools/patchdb/.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "patchdb/store/patch_database.h"
#include "tools/commands/commands.h"
#include "tools/commands/patchdb/region_table.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

class CreateVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("create", "Create an empty patch database");
    verb->add_option("DB", path_, "GeoPackage to create")->required();
    verb->add_option("--crs", crs_, "Ground CRS: EPSG:32635, WKT, a PROJ string, or a .prj file")
        ->required();
    return verb;
  }
  void Run(std::ostream& out) override {
    std::error_code error;  // WKT is longer than any file's name may be
    const bool is_file = std::filesystem::is_regular_file(crs_, error);
    const Crs crs = is_file ? Crs::FromFile(crs_) : Crs::Parse(crs_, "--crs");
    patchdb::PatchDatabase::Create(path_, crs);
    out << path_ << " created, CRS " << crs.Name() << "\n";
  }

 private:
  std::string path_, crs_;
};

class InfoVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("info", "Summarise a patch database");
    verb->add_option("DB", path_, "Patch database, or a folder of them")->required();
    return verb;
  }
  void Run(std::ostream& out) override {
    if (patchdb::IsRegionFolder(path_)) {
      const patchdb::RegionIndex index = patchdb::ReadRegionIndex(path_);
      patchdb::RequireCurrent(path_, index);
      return PrintRegions(index, out);
    }
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    const patchdb::PatchDatabaseInfo info = database.Info();
    out << "CRS       " << info.crs_name << "\nschema    version " << info.schema_version
        << "\npatches   " << info.patches << "\nretired   " << info.retired << "\nattempts  "
        << info.attempts << "\nsources   " << info.sources << "\n";
    if (info.patches > 0)
      out << "extent    " << Fixed(info.extent.min_x, 1) << " " << Fixed(info.extent.min_y, 1)
          << " to " << Fixed(info.extent.max_x, 1) << " " << Fixed(info.extent.max_y, 1) << "\n";
    if (info.sources == 0) return;
    SummaryTable table({"source", "kind", "date", "gsd [m]"});
    for (const patchdb::PatchSource& source : database.Sources())
      table.AddRow(
          {source.name, Name(source.kind), source.date.value_or("-"), Fixed(source.gsd_m, 3)});
    out << "\n";
    table.Print(out);
  }

 private:
  std::string path_;
};

class PatchdbCommand : public Command {
 public:
  PatchdbCommand() {
    verbs_.push_back(std::make_unique<CreateVerb>());
    verbs_.push_back(MakeHarvestVerb());
    verbs_.push_back(MakeHarvestOrthoVerb());
    verbs_.push_back(MakeAddGcpVerb());
    verbs_.push_back(std::make_unique<InfoVerb>());
    for (auto& verb : MakeMaintenanceVerbs()) verbs_.push_back(std::move(verb));
  }
  std::string Name() const override { return "patchdb"; }
  std::string Summary() const override {
    return "Create, fill and maintain the database of control patches";
  }
  void Setup(CLI::App& app) override {
    app.require_subcommand(1);
    parsers_.clear();
    for (const auto& verb : verbs_) parsers_.push_back(verb->Declare(app));
  }
  ExitCode Run(std::ostream& out) override {
    for (std::size_t i = 0; i < verbs_.size(); ++i)
      if (parsers_[i]->parsed()) verbs_[i]->Run(out);
    return ExitCode::kAllDone;
  }

 private:
  std::vector<std::unique_ptr<PatchdbVerb>> verbs_;
  std::vector<CLI::App*> parsers_;  // in the order of verbs_
};

}  // namespace

std::unique_ptr<Command> MakePatchdbCommand() { return std::make_unique<PatchdbCommand>(); }

}  // namespace orient

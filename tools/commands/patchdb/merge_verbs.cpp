// orient patchdb merge, update: patches of another database.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "core/base/error.h"
#include "patchdb/maintenance/merge.h"
#include "tools/commands/patchdb/filter_options.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/progress.h"

namespace orient {
namespace {

class TakeVerb : public PatchdbVerb {
 public:
  TakeVerb(const char* name, const char* summary) : name_(name), summary_(summary) {}

  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand(name_, summary_);
    verb->add_option("DB", path_, "Patch database to add to")->required();
    verb->add_option("OTHER", other_, "Patch database to read")->required();
    DeclareMore(*verb);
    return verb;
  }
  void Run(std::ostream& out) override {
    std::error_code error;
    if (std::filesystem::equivalent(path_, other_, error))
      throw UsageError("DB and OTHER are the same file; give two");
    const patchdb::PatchDatabase other =
        patchdb::PatchDatabase::Open(other_, patchdb::PatchDatabase::Mode::kRead);
    patchdb::PatchDatabase database = OpenToWrite(path_, out);
    std::unique_ptr<ProgressLine> progress;
    const patchdb::MergeResult result =
        patchdb::MergeDatabase(database, other, Options(), [&](int, int total) {
          if (!progress) progress = std::make_unique<ProgressLine>(name_, total);
          progress->Advance();
        });
    progress.reset();
    Print(result, out);
  }

 protected:
  virtual void DeclareMore(CLI::App&) {}
  virtual patchdb::MergeOptions Options() const = 0;

 private:
  static void Print(const patchdb::MergeResult& result, std::ostream& out) {
    out << result.added << " patches of " << result.sources << " new sources added\n";
    const auto also = [&](std::int64_t count, const char* text) {
      if (count > 0) out << count << text << "\n";
    };
    also(result.duplicates, " were there already; their histories were joined");
    also(result.improved, " of these got the better view");
    also(result.superseded, " older ones retired, superseded by a newer view");
    also(result.not_newer, " left out: the view here is as new");
    also(result.elsewhere, " left out: no coordinates in this CRS");
    also(result.attempts, " attempts taken over");
  }
  const char* name_;
  const char* summary_;
  std::string path_, other_;
};

class MergeVerb : public TakeVerb {
 public:
  MergeVerb() : TakeVerb("merge", "Add the patches of another database") {}

 protected:
  patchdb::MergeOptions Options() const override { return {}; }
};

class UpdateVerb : public TakeVerb {
 public:
  UpdateVerb() : TakeVerb("update", "Take over newer views of the same places") {}

 protected:
  void DeclareMore(CLI::App& verb) override {
    verb.add_flag("--add", add_, "Keep the older views in use beside the newer ones");
  }
  patchdb::MergeOptions Options() const override {
    patchdb::MergeOptions options;
    options.policy = add_ ? patchdb::MergePolicy::kAdd : patchdb::MergePolicy::kReplace;
    return options;
  }

 private:
  bool add_ = false;
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeMergeVerb() { return std::make_unique<MergeVerb>(); }
std::unique_ptr<PatchdbVerb> MakeUpdateVerb() { return std::make_unique<UpdateVerb>(); }

}  // namespace orient

// orient patchdb check, compact.

#include <CLI/CLI.hpp>
#include <ostream>

#include "core/base/error.h"
#include "patchdb/maintenance/check.h"
#include "patchdb/maintenance/compact.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/progress.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

class CheckVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb =
        app.add_subcommand("check", "Check for damage: file, index, references, chips");
    verb->add_option("DB", path_, "Patch database")->required();
    verb->add_flag("--repair", repair_, "Repair what can be repaired; no patch is deleted");
    verb->add_flag("--quick", quick_, "Skip the chips");
    return verb;
  }
  void Run(std::ostream& out) override {
    patchdb::PatchDatabase database =
        repair_ ? OpenToWrite(path_, out)
                : patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    const auto before = Look(database, repair_);
    const auto after = repair_ && !before.empty() ? Look(database, false) : before;
    for (const patchdb::CheckFinding& finding : before) Print(finding, out);
    if (before.empty()) out << path_ << " is intact\n";
    if (!before.empty() && after.empty()) out << path_ << " is repaired\n";
    if (!after.empty())
      throw InputError(
          path_ + " is damaged: " + after.front().what +
          (repair_ ? "; this cannot be repaired: save what 'orient patchdb export' can still read"
                   : "; 'orient patchdb check --repair' repairs what can be repaired"));
  }

 private:
  std::vector<patchdb::CheckFinding> Look(patchdb::PatchDatabase& database, bool repair) const {
    patchdb::CheckOptions options;
    options.repair = repair;
    options.chips = !quick_;
    std::unique_ptr<ProgressLine> progress;
    std::int64_t shown = 0;
    return patchdb::CheckDatabase(database, options, [&](std::int64_t done, std::int64_t total) {
      if (!progress) progress = std::make_unique<ProgressLine>("patches", static_cast<int>(total));
      progress->Advance(static_cast<int>(done - shown));
      shown = done;
    });
  }
  static void Print(const patchdb::CheckFinding& finding, std::ostream& out) {
    if (finding.count > 1) out << finding.count << " ";
    out << finding.what;
    if (!finding.repair.empty()) out << " (repair: " << finding.repair << ")";
    out << "\n";
  }
  std::string path_;
  bool repair_ = false, quick_ = false;
};

class CompactVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("compact", "Rewrite the file without gaps");
    verb->add_option("DB", path_, "Patch database")->required();
    return verb;
  }
  void Run(std::ostream& out) override {
    patchdb::PatchDatabase database = OpenToWrite(path_, out);
    const patchdb::CompactResult result = patchdb::CompactDatabase(database);
    const auto mega = [](std::uintmax_t bytes) {
      return Fixed(static_cast<double>(bytes) / 1e6, 1);
    };
    out << path_ << ": " << mega(result.before) << " MB before, " << mega(result.after)
        << " MB now\n";
    if (result.old_pages)
      out << "The page size is unchanged: another program has the file open. Compact it again when "
             "none has.\n";
  }

 private:
  std::string path_;
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeCheckVerb() { return std::make_unique<CheckVerb>(); }
std::unique_ptr<PatchdbVerb> MakeCompactVerb() { return std::make_unique<CompactVerb>(); }

}  // namespace orient

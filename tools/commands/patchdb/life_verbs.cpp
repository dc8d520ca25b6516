// orient patchdb retire, restore, prune: by number or by rule. Without --apply they only say what
// they would do.

#include <CLI/CLI.hpp>
#include <ostream>

#include "core/base/error.h"
#include "patchdb/maintenance/life.h"
#include "tools/commands/patchdb/filter_options.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/patchdb_to_write.h"

namespace orient {
namespace {

class LifeVerb : public PatchdbVerb {
 public:
  LifeVerb(const char* name, const char* summary, patchdb::PatchLife before)
      : name_(name), summary_(summary), before_(before) {}

  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand(name_, summary_);
    verb->add_option("DB", path_, "Patch database")->required();
    choice_.DeclarePlace(*verb);
    choice_.DeclareRules(*verb);
    if (before_ == patchdb::PatchLife::kRetired) choice_.DeclareRetired(*verb);
    verb->add_flag("--apply", apply_, "Do it; otherwise only report what would be done");
    DeclareMore(*verb);
    return verb;
  }
  void Run(std::ostream& out) override {
    patchdb::PatchDatabase database =
        apply_ ? OpenToWrite(path_, out)
               : patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    patchdb::PatchFilter filter = choice_.Filter(database, Absent());
    if (!filter.HasRule())
      throw UsageError(std::string(name_) + " needs --id or a rule that chooses patches");
    filter.life = before_;
    const std::vector<std::int64_t> ids = patchdb::ChooseIds(database, filter);
    if (!apply_) {
      out << ids.size() << " patches would be " << Done() << "; give --apply to do it\n";
      PrintIds(ids, out);
      return;
    }
    out << Change(database, ids) << " patches " << Done() << "\n";
  }

 protected:
  virtual void DeclareMore(CLI::App&) {}
  virtual AbsentIds Absent() const { return AbsentIds::kRefuse; }
  virtual const char* Done() const = 0;
  virtual int Change(patchdb::PatchDatabase& database, const std::vector<std::int64_t>& ids) = 0;

 private:
  static void PrintIds(const std::vector<std::int64_t>& ids, std::ostream& out) {
    constexpr std::size_t kShown = 20;
    if (ids.empty()) return;
    out << "ids";
    for (std::size_t i = 0; i < std::min(kShown, ids.size()); ++i) out << " " << ids[i];
    out << (ids.size() > kShown ? " ...\n" : "\n");
  }

  const char* name_;
  const char* summary_;
  patchdb::PatchLife before_;
  std::string path_;
  FilterOptions choice_{"all"};
  bool apply_ = false;
};

class RetireVerb : public LifeVerb {
 public:
  RetireVerb()
      : LifeVerb("retire", "Take patches out of use; they stay in the database",
                 patchdb::PatchLife::kActive) {}

 protected:
  void DeclareMore(CLI::App& verb) override {
    verb.add_option("--reason", reason_, "Reason, kept with the patches");
  }
  const char* Done() const override { return "retired"; }
  int Change(patchdb::PatchDatabase& database, const std::vector<std::int64_t>& ids) override {
    return patchdb::RetirePatches(database, ids, reason_);
  }

 private:
  std::string reason_ = "by hand";
};

class RestoreVerb : public LifeVerb {
 public:
  RestoreVerb()
      : LifeVerb("restore", "Return retired patches to use", patchdb::PatchLife::kRetired) {}

 protected:
  const char* Done() const override { return "restored"; }
  int Change(patchdb::PatchDatabase& database, const std::vector<std::int64_t>& ids) override {
    return patchdb::RestorePatches(database, ids);
  }
};

class PruneVerb : public LifeVerb {
 public:
  PruneVerb()
      : LifeVerb("prune", "Delete retired patches permanently", patchdb::PatchLife::kRetired) {}

 protected:
  AbsentIds Absent() const override { return AbsentIds::kIgnore; }
  const char* Done() const override { return "deleted"; }
  int Change(patchdb::PatchDatabase& database, const std::vector<std::int64_t>& ids) override {
    return patchdb::DeleteRetiredPatches(database, ids);
  }
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeRetireVerb() { return std::make_unique<RetireVerb>(); }
std::unique_ptr<PatchdbVerb> MakeRestoreVerb() { return std::make_unique<RestoreVerb>(); }
std::unique_ptr<PatchdbVerb> MakePruneVerb() { return std::make_unique<PruneVerb>(); }

}  // namespace orient

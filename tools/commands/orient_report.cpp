#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "block/block_folder.h"
#include "core/base/error.h"
#include "tools/commands/commands.h"
#include "tools/commands/shared_options.h"
#include "tools/report/gis/block_geopackage.h"
#include "tools/report/gis/block_project.h"
#include "tools/report/html_text.h"
#include "tools/report/report.h"
#include "tools/report/report_json.h"
#include "tools/report/verdict.h"

namespace orient {
namespace {

class ReportCommand : public Command {
 public:
  std::string Name() const override { return "report"; }
  std::string Summary() const override {
    return "Write report.html, block.gpkg and block.qgz of a finished block";
  }

  void Setup(CLI::App& app) override {
    app.add_option("DIR", directory_, "Output folder of orient interior, exterior or block")
        ->required();
    app.add_flag("--json", json_, "Also write the figures for programs, report.json");
  }

  ExitCode Run(std::ostream& out) override {
    RefuseToReplacePatches(directory_);
    BlockRecord block = ReadBlockRecord(directory_);
    if (const auto note = block::UnfinishedNote(directory_)) block.notes.push_back(*note);
    const BlockVerdict verdict = Judge(block);
    out << WriteReport(block, verdict) << "\n";
    if (json_) out << WriteReportJson(block, verdict) << "\n";
    if (block.crs) {
      const std::vector<PhotoWithoutResult> others = WithoutExterior(block, verdict);
      out << WriteBlockGeopackage(directory_, *block.crs, TakeExteriorResults(&block),
                                  block.adjusted ? &*block.adjusted : nullptr, others)
          << "\n";
    }
    if (const std::string project = WriteBlockProject(directory_); !project.empty())
      out << project << "\n";
    RefuseDamaged(block);
    return ExitCode::kAllDone;
  }

 private:
  // Photos without exterior orientation, with what the report says of them.
  static std::vector<PhotoWithoutResult> WithoutExterior(const BlockRecord& block,
                                                         const BlockVerdict& verdict) {
    std::vector<PhotoWithoutResult> photos;
    for (std::size_t i = 0; i < block.photos.size(); ++i)
      if (!block.photos[i].exterior)
        photos.push_back(
            {block.photos[i].name, verdict.photos[i].status, Joined(verdict.photos[i].reasons)});
    return photos;
  }

  // The report shows what it can; that some files could not be read must not pass unnoticed.
  static void RefuseDamaged(const BlockRecord& block) {
    std::vector<std::string> problems = block.unreadable;
    for (const PhotoRecord& photo : block.photos)
      problems.insert(problems.end(), photo.unreadable.begin(), photo.unreadable.end());
    if (problems.empty()) return;
    std::string message = problems.front();
    if (problems.size() > 1)
      message += fmt::format(" (and {} more; the report lists them)", problems.size() - 1);
    throw InputError(message);
  }

  std::string directory_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeReportCommand() { return std::make_unique<ReportCommand>(); }

}  // namespace orient

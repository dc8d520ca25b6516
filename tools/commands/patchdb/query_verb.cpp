// orient patchdb query: the patches in a box, in a polygon, or that a photo should see.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <ostream>

#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/terrain/photo_view.h"
#include "tools/commands/patchdb/filter_options.h"
#include "tools/commands/patchdb/summary_csv.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

class QueryVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb =
        app.add_subcommand("query", "Print the patches of an area, or those a photo should show");
    verb->add_option("DB", path_, "Patch database")->required();
    choice_.DeclarePlace(*verb);
    choice_.DeclareRules(*verb);
    choice_.DeclareState(*verb);
    auto* photo =
        verb->add_option("--photo", photo_, "In the frame of this photo of the orientation table");
    auto* camera = verb->add_option("--camera", camera_, "Camera file of the photo");
    auto* table = verb->add_option("--orientation", orientation_, "Orientation table (OPK CSV)");
    photo->needs(camera)->needs(table);
    camera->needs(photo);
    table->needs(photo);
    return verb;
  }
  void Run(std::ostream& out) override {
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    patchdb::PatchFilter filter = choice_.Filter(database);
    PrintSummaryHeader(out);
    if (photo_.empty()) {
      out << "\n";
      return patchdb::VisitPatches(database, filter, [&](const patchdb::PatchSummary& patch) {
        PrintSummary(patch, out);
        out << "\n";
      });
    }
    out << ",photo_x_mm,photo_y_mm\n";
    const Camera camera = ReadCameraFile(camera_).camera;
    const Pose pose = PoseOf(database);
    Narrow(camera, pose, &filter);
    patchdb::VisitPatches(database, filter, [&](const patchdb::PatchSummary& patch) {
      const auto photo = PhotoFromGround(camera, pose, patch.ground_m);
      if (!photo || !camera.InFrame(*photo)) return;
      PrintSummary(patch, out);
      out << "," << Fixed(photo->x(), 4) << "," << Fixed(photo->y(), 4) << "\n";
    });
  }

 private:
  Pose PoseOf(const patchdb::PatchDatabase& database) const {
    const OrientationTable table = ReadOrientationTable(orientation_);
    if (table.crs && !table.crs->SameAs(database.GroundCrs()))
      throw InputError(fmt::format("{} is in {}, {} in {}; both must be in one CRS", orientation_,
                                   table.crs->Name(), path_, database.GroundCrs().Name()));
    const OrientationRow* row = table.Find(PhotoName(photo_));
    if (row == nullptr)
      throw InputError(orientation_ + " has no row for photo '" + PhotoName(photo_) + "'");
    return row->pose;
  }
  // Restricts the filter to what the frame can show at all, so that the spatial index can help.
  void Narrow(const Camera& camera, const Pose& pose, patchdb::PatchFilter* filter) const {
    const auto seen = FootprintBounds(camera, pose, kLowestGround_m,
                                      std::min(kHighestGround_m, pose.position_m.z() - 1));
    if (!seen)
      throw InputError(orientation_ + ": photo '" + photo_ + "' does not point at the ground; " +
                       "check its height and angles");
    if (!filter->bounds) {
      filter->bounds = seen;
      return;
    }
    Bounds& box = *filter->bounds;
    box = {std::max(box.min_x, seen->min_x), std::max(box.min_y, seen->min_y),
           std::min(box.max_x, seen->max_x), std::min(box.max_y, seen->max_y)};
  }

  std::string path_, photo_, camera_, orientation_;
  FilterOptions choice_{"active"};
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeQueryVerb() { return std::make_unique<QueryVerb>(); }

}  // namespace orient

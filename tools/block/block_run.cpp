#include "tools/block/block_run.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "core/files/orientation_table.h"
#include "patchdb/content_digest.h"
#include "tools/approximations.h"
#include "tools/block/adjustment_summary.h"
#include "tools/block/calibrated_camera.h"
#include "tools/block/neighbour_stage.h"
#include "tools/block/stage_folder.h"
#include "tools/block/tie_stage.h"
#include "tools/block_camera.h"
#include "tools/block_geopackage.h"
#include "tools/convert/write_exports.h"
#include "tools/exterior_run.h"
#include "tools/interior_run.h"
#include "tools/made_from.h"
#include "tools/progress.h"
#include "tools/report/report.h"
#include "tools/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string StagePath(const std::string& out, const std::string& stage) {
  return (fs::path(out) / "stages" / stage).string();
}

std::string UnfinishedPath(const std::string& out) { return StagePath(out, "unfinished"); }

// One run: what its stages share.
class BlockRun {
 public:
  explicit BlockRun(const BlockRunOptions& options)
      : options_(options),
        block_(options.block),
        camera_(ReadCameraFile(options.block.camera)),
        film_(camera_.camera.kind == CameraKind::kFilm),
        exterior_(StagePath(block_.output_directory, "exterior"), ".exterior.json") {
    if (film_) marks_ = LoadMarkShapes(camera_);
  }

  BlockRunResult Run() {
    const std::string& out = block_.output_directory;
    MakeOutputDirectory(out);
    if (!options_.resume) fs::remove_all(fs::path(out) / "stages");
    MakeOutputDirectory(StagePath(out, ""));
    WriteFileAtomically(UnfinishedPath(out), "an interrupted run goes on with --resume\n");
    if (film_) OrientInteriors();
    OrientExteriors();
    ReadPhotos();
    BlockRunResult result;
    if (block_.adjustment.ties && photos_.size() > 1) Adjust(&result);
    if (!result.adjusted) {
      result.results = OwnResults(photos_);
      fs::remove(AdjustmentResultPath(out));
      fs::remove(CalibratedCameraPath(out));
    }
    AddUnusable(&result.results);
    NameNeedlessApproximations(&result.messages);
    WriteOutputs(&result);
    fs::remove(UnfinishedPath(out));
    return result;
  }

  std::vector<std::string> Plan() {
    std::vector<std::string> lines;
    const auto line = [&](bool keep, const std::string& what) {
      lines.push_back((keep ? "keep  " : "do    ") + what);
    };
    if (options_.resume) PrepareDigests();
    for (const UnusablePhoto& photo : block_.unusable)
      lines.push_back("cannot  " + photo.name + ": " + photo.reason);
    for (const std::string& path : block_.photos) {
      const std::string name = PhotoName(path);
      const bool interior =
          fs::exists(InteriorResultPath(block_.output_directory, name)) && options_.resume;
      if (film_) line(interior, "interior  " + name);
      line(options_.resume && (interior || !film_) &&
               exterior_.IsCurrent(name, DigestOfExterior(path)),
           "exterior  " + name);
    }
    if (block_.adjustment.ties && block_.photos.size() > 1) {
      line(false, "ties      between all photos that overlap (kept where nothing changed)");
      line(false, "adjust    the block");
    }
    line(false,
         "write     " + block_.output_directory + "/orientation.csv, block.gpkg, report.html");
    return lines;
  }

 private:
  void OrientInteriors() const {
    InteriorRunOptions options;
    options.photos = block_.photos;
    options.camera = block_.camera;
    options.out = block_.output_directory;
    options.scan = {block_.pixel_size_um, block_.polarity, block_.orientation};
    options.resume = options_.resume;
    options.redo_changed = true;
    options.jobs = options_.jobs;
    Progress progress("interior orientation", static_cast<int>(block_.photos.size()));
    RunInterior(options, [&] { progress.Advance(); });
  }

  ExteriorRunOptions ExteriorOptions() const {
    ExteriorRunOptions options;
    options.photos = block_.photos;
    options.camera = block_.camera;
    options.approximations = block_.approximations;
    options.dem = block_.dem;
    options.patchdb = block_.patchdb;
    options.out = exterior_.Directory();
    options.pictures = block_.output_directory;
    if (film_) options.interior = block_.output_directory;
    options.crs = block_.crs;
    options.position_sigma_m = block_.position_sigma_m;
    options.attitude_sigma_rad = block_.attitude_sigma_rad;
    options.earth = block_.earth;
    options.earth_k1 = earth_k1_;
    options.feedback = options_.feedback;
    options.jobs = options_.jobs;
    return options;
  }

  // What all photos' results depend on, and the table that each has a row of.
  void PrepareDigests() {
    const auto sigma = [](const std::optional<double>& value) {
      return value ? std::to_string(*value) : std::string("-");
    };
    approximations_ = ReadApproximations(block_.approximations, block_.crs);
    DecideOnTheEarth();
    shared_ = Digest("block 2" + DigestOfCamera(camera_) + DigestOfRaster(block_.dem) +
                     block_.crs.Wkt() + std::to_string(static_cast<int>(block_.earth)) +
                     sigma(block_.position_sigma_m) + sigma(block_.attitude_sigma_rad));
    patches_ = ContentOf(PatchDatabase::Open(block_.patchdb, PatchDatabase::Mode::kRead));
  }

  // Every stage uses the same camera; that a photo's height changes by metres makes no other one.
  void DecideOnTheEarth() {
    if (earth_k1_) return;
    char rounded[32];
    std::snprintf(rounded, sizeof rounded, "%.2e", CameraOfRun(ExteriorOptions()).k1);
    earth_k1_ = std::strtod(rounded, nullptr);
    if (*earth_k1_ != 0) camera_.camera = WithCubic(camera_.camera, *earth_k1_);
  }

  std::string DigestOfExterior(const std::string& path) const {
    const std::string name = PhotoName(path);
    std::string text = shared_ + patches_ + DigestOfFile(path);
    if (const OrientationRow* row = approximations_.Find(name)) {
      if (!row->attitude_known) text += "position alone ";
      const Vector6d sigma = row->sigma.value_or(Vector6d::Zero());
      for (int i = 0; i < 6; ++i)
        text += std::to_string(row->pose.AsVector()[i]) + " " + std::to_string(sigma[i]) + " ";
    }
    if (film_) text += DigestOfFile(InteriorResultPath(block_.output_directory, name));
    return Digest(text);
  }

  void OrientExteriors() {
    PrepareDigests();
    std::map<std::string, std::string> digests;
    for (const std::string& path : block_.photos) {
      const std::string name = PhotoName(path);
      digests[name] = DigestOfExterior(path);
      if (!exterior_.IsCurrent(name, digests[name])) exterior_.Drop(name);
    }
    ExteriorRunOptions options = ExteriorOptions();
    options.resume = true;  // what is not of now was dropped
    Progress progress("exterior orientation", static_cast<int>(block_.photos.size()));
    RunExterior(options, [&](const ExteriorResult& result) {
      exterior_.Note(result.photo, digests.at(result.photo));
      progress.Advance();
    });
  }

  void ReadPhotos() {
    for (const std::string& path : block_.photos)
      photos_.push_back(ReadBlockPhoto(path, exterior_.ResultPath(PhotoName(path)), camera_, marks_,
                                       block_.output_directory));
    // An earlier run's picture of a photo that has no patches any more.
    std::error_code ignored;
    for (const BlockPhotoFile& photo : photos_)
      if (!photo.HasPose())
        fs::remove(fs::path(block_.output_directory) / (photo.name + ".patches.png"), ignored);
  }

  GroundSurface SurfaceUnderPhotos() const {
    Bounds all = Bounds::OfNothing();
    for (const BlockPhotoFile& photo : photos_) {
      if (photo.footprint.Empty()) continue;
      all.Include(photo.footprint.min_x, photo.footprint.min_y);
      all.Include(photo.footprint.max_x, photo.footprint.max_y);
    }
    return GroundSurface::FromFile(block_.dem, block_.crs, all);
  }

  bool AnyPose() const {
    return std::any_of(photos_.begin(), photos_.end(),
                       [](const BlockPhotoFile& photo) { return photo.HasPose(); });
  }

  std::vector<TieRecord> MeasureTies(const GroundSurface& surface, BlockRunResult* result) {
    const auto posed = std::count_if(photos_.begin(), photos_.end(),
                                     [](const auto& photo) { return photo.HasPose(); });
    Progress progress("tie points", static_cast<int>(posed));
    const TieStage stage{photos_,
                         camera_.camera,
                         surface,
                         shared_,
                         StageFolder(StagePath(block_.output_directory, "ties"), ".ties.json"),
                         options_.jobs};
    return RunTieStage(
        stage, [&] { progress.Advance(); }, &result->messages);
  }

  void Adjust(BlockRunResult* result) {
    if (!AnyPose()) return;
    {
      const GroundSurface surface = SurfaceUnderPhotos();
      RunNeighbourStage({ExteriorOptions(), camera_, marks_, surface, block_.output_directory,
                         StagePath(block_.output_directory, "neighbours"), shared_},
                        &photos_, &result->messages);
    }
    const GroundSurface surface = SurfaceUnderPhotos();
    const std::vector<TieRecord> ties = MeasureTies(surface, result);
    if (ties.empty()) return;
    const AdjustmentInputs inputs{photos_, ties,           camera_.camera,
                                  surface, block_.patchdb, block_.adjustment};
    const AdjustedBlock adjusted = AdjustPhotos(inputs);
    result->results = FinalResults(inputs, adjusted);
    WriteCalibratedCamera(block_.output_directory, camera_, earth_k1_.value_or(0), adjusted.result);
    if (adjusted.result.converged && !adjusted.result.cameras.empty())
      camera_.camera = adjusted.result.cameras.front();
    result->messages.insert(result->messages.end(), adjusted.result.messages.begin(),
                            adjusted.result.messages.end());
    AdjustmentResult summary = SummaryOf(adjusted, result->messages);
    result->summary = Summarize(summary);
    result->adjusted = std::move(summary);
  }

  // `results` begins with those of photos_, in their order.
  std::optional<Quicklook> MakeQuicklook(const std::vector<ExteriorResult>& results) const {
    std::vector<QuicklookPhoto> photos;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!results[i].pose || results[i].status == Status::kFailed) continue;
      const BlockPhotoFile& photo = photos_[i];
      photos.push_back({photo.name,
                        photo.path,
                        {camera_.camera, photo.position.photo_from_pixel, *results[i].pose,
                         photo.position.film_correction},
                        photo.negative});
    }
    if (photos.empty()) return std::nullopt;
    return WriteQuicklook(block_.output_directory, photos, SurfaceUnderPhotos());
  }

  void AddUnusable(std::vector<ExteriorResult>* results) const {
    for (const UnusablePhoto& photo : block_.unusable) {
      ExteriorResult failed;
      failed.photo = photo.name;
      failed.messages = {photo.reason};
      results->push_back(std::move(failed));
    }
  }

  void NameNeedlessApproximations(std::vector<std::string>* messages) const {
    std::set<std::string> photos;
    for (const std::string& path : block_.photos) photos.insert(PhotoName(path));
    for (const UnusablePhoto& photo : block_.unusable) photos.insert(photo.name);
    std::vector<std::string> needless;
    for (const OrientationRow& row : approximations_.rows)
      if (!photos.contains(row.photo)) needless.push_back(row.photo);
    if (needless.empty()) return;
    constexpr std::size_t kMostNames = 5;
    std::string names;
    for (std::size_t i = 0; i < std::min(needless.size(), kMostNames); ++i)
      names += (i > 0 ? ", " : "") + needless[i];
    if (needless.size() > kMostNames) names += ", ...";
    messages->push_back(block_.approximations + " has " + std::to_string(needless.size()) +
                        (needless.size() == 1 ? " photo that is" : " photos that are") +
                        " not in the block: " + names);
  }

  BlockSummary Summarize(const AdjustmentResult& adjusted) const {
    BlockSummary summary;
    for (const PartResult& part : adjusted.parts)
      summary.photos += static_cast<int>(part.photos.size());
    for (const BlockPhotoFile& photo : photos_) summary.by_neighbours += photo.by_neighbours;
    summary.ties = static_cast<int>(adjusted.ties.size());
    for (const PointResult& tie : adjusted.ties)
      for (const SightingResult& sighting : tie.seen) {
        ++summary.sightings;
        summary.rejected += sighting.state == Name(ObservationState::kRejected);
      }
    for (const ComponentResult& component : adjusted.components)
      if (component.group == "tie image") summary.tie_sigma0_px = component.sigma0_px;
    summary.checks = static_cast<int>(adjusted.checks.size());
    summary.check_rms_px = adjusted.CheckRmsPx();
    return summary;
  }

  // What an earlier run left and this one does not write.
  void RemoveStale(const std::string& out) const {
    std::error_code ignored;
    for (const char* file : {"quicklook.png", "seams.png", "exports"})
      fs::remove_all(fs::path(out) / file, ignored);
    for (const UnusablePhoto& photo : block_.unusable)
      for (const char* file : {".patches.png", ".marks.png", ".interior.json"})
        fs::remove(fs::path(out) / (photo.name + file), ignored);
  }

  // A picture that cannot be drawn costs no result.
  void Illustrate(BlockRunResult* result) const {
    try {
      result->quicklook = MakeQuicklook(result->results);
      if (!result->quicklook) return;
      for (const std::string& photo : result->quicklook->left_out)
        result->messages.push_back("photo " + photo + " could not be read for the quicklook");
    } catch (const std::exception& error) {
      result->messages.push_back(std::string("no quicklook: ") + error.what());
    }
  }

  void WriteOutputs(BlockRunResult* written) const {
    BlockRunResult& result = *written;
    const std::string& out = block_.output_directory;
    RemoveStale(out);
    OrientationTable table;
    table.crs = block_.crs;
    for (const ExteriorResult& photo : result.results) {
      WriteExteriorResult(out, photo);
      if (photo.pose)
        table.rows.push_back(
            {photo.photo, *photo.pose, Vector6d(photo.covariance->diagonal().cwiseSqrt())});
    }
    WriteOrientationTable((fs::path(out) / "orientation.csv").string(), table);
    WriteBlockCamera(out, camera_, earth_k1_.value_or(0));
    if (result.adjusted) WriteAdjustmentResult(out, *result.adjusted);
    WriteBlockGeopackage(out, block_.crs, result.results,
                         result.adjusted ? &*result.adjusted : nullptr);
    if (options_.quicklook) Illustrate(&result);
    WriteReport(out);
    WriteExportsTo(out, result);
  }

  void WriteExportsTo(const std::string& out, const BlockRunResult& result) const {
    const auto oriented = [](const ExteriorResult& photo) { return photo.pose.has_value(); };
    if (block_.formats.empty() ||
        std::none_of(result.results.begin(), result.results.end(), oriented))
      return;
    try {
      WriteExportsOf(out, BlockCameraPath(out), block_.formats);
    } catch (const InputError& error) {
      throw InputError("the block is done and written to " + out +
                       ", but not exported: " + error.what());
    }
  }

  const BlockRunOptions& options_;
  const BlockFile& block_;
  CameraFile camera_;
  bool film_;
  std::optional<double> earth_k1_;  // in camera_ since it is decided
  MarkShapes marks_;
  StageFolder exterior_;
  OrientationTable approximations_;
  std::string shared_, patches_;  // digests
  std::vector<BlockPhotoFile> photos_;
};

}  // namespace

bool IsUnfinished(const std::string& output_directory) {
  std::error_code ignored;
  return fs::exists(UnfinishedPath(output_directory), ignored);
}

BlockRunResult RunBlock(const BlockRunOptions& options) { return BlockRun(options).Run(); }

std::vector<std::string> PlanBlock(const BlockRunOptions& options) {
  return BlockRun(options).Plan();
}

}  // namespace orient

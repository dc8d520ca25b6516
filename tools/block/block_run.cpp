#include "tools/block/block_run.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "core/files/folder_lock.h"
#include "core/files/orientation_table.h"
#include "core/files/partial_files.h"
#include "core/format_text.h"
#include "patchdb/content_digest.h"
#include "tools/approximations.h"
#include "tools/block/adjustment_summary.h"
#include "tools/block/block_approximations.h"
#include "tools/block/block_outputs.h"
#include "tools/block/calibrated_camera.h"
#include "tools/block/neighbour_stage.h"
#include "tools/block/pose_covariance.h"
#include "tools/block/stage_folder.h"
#include "tools/block/tie_stage.h"
#include "tools/block_camera.h"
#include "tools/exterior_run.h"
#include "tools/interior_run.h"
#include "tools/made_from.h"
#include "tools/progress.h"
#include "tools/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string StagePath(const std::string& out, const std::string& stage) {
  return (fs::path(out) / "stages" / stage).string();
}

std::string UnfinishedPath(const std::string& out) { return StagePath(out, "unfinished"); }

// In the folders that are a run's own.
void RemovePartialFilesOfKilledRuns(const std::string& out) {
  RemovePartialFiles(out);
  RemovePartialFiles(StagePath(out, ""));
  // Neither a folder that cannot be read nor what is removed meanwhile may end the walk by a throw.
  std::vector<std::string> folders;
  std::error_code error, ignored;
  for (fs::recursive_directory_iterator
           entry(StagePath(out, ""), fs::directory_options::skip_permission_denied, error),
       end;
       !error && entry != end; entry.increment(error))
    if (entry->is_directory(ignored)) folders.push_back(entry->path().string());
  for (const std::string& folder : folders) RemovePartialFiles(folder);
}

// All that is said of the flight, as one text that changes when it does.
std::string FlightText(const FlightPlan& flight) {
  if (flight.Empty()) return "";
  std::string text = FormatText("%.6g %.6g %.6g %.6g %d", flight.overlap, flight.side_lap,
                                flight.flying_height_m.value_or(0), flight.scale.value_or(0),
                                flight.back_and_forth ? 1 : 0);
  if (flight.next_strip)
    text += FormatText(" %g %g", flight.next_strip->x(), flight.next_strip->y());
  text += FormatText(" %.9g", flight.azimuth_rad.value_or(99));
  for (const FlightStrip& strip : flight.strips) {
    text += FormatText("; %.9g", strip.azimuth_rad.value_or(99));
    for (const std::string& photo : strip.photos) text.append(" ").append(photo);
  }
  return text;
}

constexpr const char* kNoPoseCovariance =
    "pose_covariance.csv is not written: it is for blocks that were adjusted and came to rest, of "
    "at "
    "most 300 photos";

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
    PrepareDigests();  // what is wrong with tables, strips and DEM shows before the work
    MakeOutputDirectory(out);
    const FolderLock lock(out, ".orient-block.lock");
    RemovePartialFilesOfKilledRuns(out);
    if (!options_.resume) fs::remove_all(fs::path(out) / "stages");
    MakeOutputDirectory(StagePath(out, ""));
    WriteFileAtomically(UnfinishedPath(out), "an interrupted run goes on with --resume\n");
    if (film_) OrientInteriors();
    OrientExteriors();
    ReadPhotos();
    BlockRunResult result;
    for (const auto& [what, photos] : changed_)
      result.messages.push_back(
          std::string("oriented again, for what they were made from has changed (")
              .append(what)
              .append("): ")
              .append(photos));
    if (const auto told = SetOtherPhotosAside(block_)) result.messages.push_back(*told);
    if (block_.adjustment.ties && photos_.size() > 1) Adjust(&result);
    if (!result.adjusted) {
      result.results = OwnResults(photos_);
      fs::remove(AdjustmentResultPath(out));
      fs::remove(CalibratedCameraPath(out));
      fs::remove(PoseCovariancePath(out));
      if (block_.adjustment.pose_covariance) result.messages.emplace_back(kNoPoseCovariance);
    }
    AddUnusable(&result.results);
    NameNeedlessApproximations(&result);
    WriteBlockOutputs({block_, camera_, photos_, options_.quicklook}, &result);
    fs::remove(UnfinishedPath(out));
    return result;
  }

  std::vector<std::string> Plan() {
    std::vector<std::string> lines;
    const auto line = [&](bool keep, const std::string& what) {
      lines.push_back((keep ? "keep  " : "do    ") + what);
    };
    PrepareDigests();
    if (film_) interiors_that_stay_ = InteriorsThatStay(InteriorOptions());
    for (const UnusablePhoto& photo : block_.unusable)
      lines.push_back("cannot  " + photo.name + ": " + photo.reason);
    const std::set<std::string> kept = KeptExteriors();
    for (const std::string& path : block_.photos) {
      const std::string name = PhotoName(path);
      if (film_) line(InteriorStays(name), "interior  " + name);
      line(kept.contains(name), "exterior  " + name);
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
  bool InteriorStays(const std::string& name) const { return interiors_that_stay_.contains(name); }

  // Photos whose exterior orientation would not be done again. What is done again may change the
  // approximations of those after it.
  std::set<std::string> KeptExteriors() {
    std::set<std::string> kept;
    if (!options_.resume) return kept;
    std::vector<ExteriorResult> so_far(block_.photos.size());
    bool all = true;
    for (auto next = NextPhotos(so_far); all && !next.empty(); next = NextPhotos(so_far))
      for (const std::size_t i : next) {
        const std::string name = PhotoName(block_.photos[i]);
        so_far[i].photo = name;
        const bool keep = (!film_ || InteriorStays(name)) &&
                          exterior_.IsCurrent(name, DigestOfExterior(block_.photos[i]));
        all = all && keep;
        if (!keep) continue;
        kept.insert(name);
        so_far[i] = ReadExteriorResult(exterior_.ResultPath(name));
      }
    return kept;
  }

  InteriorRunOptions InteriorOptions() const {
    InteriorRunOptions options;
    options.photos = block_.photos;
    options.camera = block_.camera;
    options.out = block_.output_directory;
    options.scan = {block_.pixel_size_um, block_.polarity, block_.orientation};
    options.resume = options_.resume;
    options.redo_changed = true;
    options.jobs = options_.jobs;
    return options;
  }

  void OrientInteriors() const {
    Progress progress("interior orientation", static_cast<int>(block_.photos.size()));
    RunInterior(InteriorOptions(), [&] { progress.Advance(); });
  }

  ExteriorRunOptions ExteriorOptions() const {
    ExteriorRunOptions options;
    options.photos = block_.photos;
    options.camera = block_.camera;
    options.approximations = block_.approximations;
    options.table = approximations_->Table();
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
    approximations_.emplace(block_, camera_.camera);
    DecideOnTheEarth();
    shared_ = Digest("block 2" + FlightText(block_.flight) + DigestOfCamera(camera_) +
                     DigestOfRaster(block_.dem) + block_.crs.Wkt() +
                     std::to_string(static_cast<int>(block_.earth)) +
                     sigma(block_.position_sigma_m) + sigma(block_.attitude_sigma_rad));
    patches_ = ContentOf(PatchDatabase::Open(block_.patchdb, PatchDatabase::Mode::kRead));
  }

  // Every stage uses the same camera; that a photo's height changes by metres makes no other one.
  void DecideOnTheEarth() {
    if (earth_k1_) return;
    char rounded[32];
    std::snprintf(rounded, sizeof rounded, "%.2e", EarthK1OfRun(ExteriorOptions()));
    earth_k1_ = std::strtod(rounded, nullptr);
    camera_.camera = WithEarth(camera_.camera, *earth_k1_);
  }

  std::string DigestOfExterior(const std::string& path) const {
    const std::string name = PhotoName(path);
    std::string text = "settings=" + shared_ + " patches=" + Digest(patches_) +
                       " scan=" + DigestOfFile(path) +
                       " approximation=" + Digest(TextOf(approximations_->Table().Find(name)));
    if (film_)
      text += " interior=" + DigestOfFile(InteriorResultPath(block_.output_directory, name));
    return text;
  }

  // Of the next photos to orient; what is kept of them and not of now is dropped.
  std::vector<std::size_t> NextPhotos(const std::vector<ExteriorResult>& so_far) {
    approximations_->Learn(so_far);
    std::vector<std::string> open;
    std::vector<std::size_t> index;
    for (std::size_t i = 0; i < so_far.size(); ++i) {
      if (!so_far[i].photo.empty()) continue;
      open.push_back(PhotoName(block_.photos[i]));
      index.push_back(i);
    }
    std::vector<std::size_t> next;
    for (const std::size_t i : approximations_->Next(open)) next.push_back(index[i]);
    return next;
  }

  void OrientExteriors() {
    std::map<std::string, std::string> digests;
    ExteriorRunOptions options = ExteriorOptions();
    options.resume = true;  // what is not of now is dropped
    options.next_photos = [&](const std::vector<ExteriorResult>& so_far, OrientationTable* table) {
      const std::vector<std::size_t> next = NextPhotos(so_far);
      *table = approximations_->Table();
      for (const std::size_t i : next) {
        const std::string name = PhotoName(block_.photos[i]);
        digests[name] = DigestOfExterior(block_.photos[i]);
        if (exterior_.IsCurrent(name, digests[name])) continue;
        if (const std::string what = exterior_.WhatChanged(name, digests[name]); !what.empty())
          changed_[what] += (changed_[what].empty() ? "" : ", ") + name;
        exterior_.Drop(name);
      }
      return next;
    };
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

  // GNSS and approximations make no photo ok, and keep no block from coming to rest.
  static AdjustedBlock AdjustAndJudge(const AdjustmentInputs& inputs, BlockRunResult* result) {
    AdjustedBlock adjusted = AdjustPhotos(inputs);
    result->results = FinalResults(inputs, adjusted);
    if (inputs.known.Empty()) return adjusted;
    AdjustmentInputs without = inputs;
    without.known = {};
    AdjustedBlock by_control = AdjustPhotos(without);
    std::vector<ExteriorResult> results = FinalResults(without, by_control);
    if (adjusted.result.converged && !by_control.result.converged) {
      HoldAllToControl(&result->results);
      return adjusted;
    }
    if (adjusted.result.converged || !by_control.result.converged) {
      HoldToControl(results, &result->results);
      return adjusted;
    }
    result->results = std::move(results);
    result->messages.emplace_back(
        "with GNSS and approximations as observations the block does not come to rest: adjusted "
        "without them");
    return by_control;
  }

  void Adjust(BlockRunResult* result) {
    if (!AnyPose()) return;
    {
      const GroundSurface surface = SurfaceUnder(block_, photos_);
      RunNeighbourStage(
          {ExteriorOptions(), *approximations_, camera_, marks_, surface, block_.output_directory,
           StagePath(block_.output_directory, "neighbours"), shared_},
          &photos_, &result->messages);
    }
    const GroundSurface surface = SurfaceUnder(block_, photos_);
    const std::vector<TieRecord> ties = MeasureTies(surface, result);
    if (ties.empty()) return;
    const AdjustmentInputs inputs{photos_,
                                  ties,
                                  camera_.camera,
                                  surface,
                                  block_.patchdb,
                                  block_.adjustment,
                                  approximations_->Observations()};
    const AdjustedBlock adjusted = AdjustAndJudge(inputs, result);
    WriteCalibratedCamera(block_.output_directory, camera_, adjusted.result);
    if (!WritePoseCovariance(block_.output_directory, block_.adjustment.pose_covariance, adjusted,
                             result->results))
      result->messages.emplace_back(kNoPoseCovariance);
    if (adjusted.result.converged && !adjusted.result.cameras.empty())
      camera_.camera = adjusted.result.cameras.front();
    result->messages.insert(result->messages.end(), adjusted.result.messages.begin(),
                            adjusted.result.messages.end());
    AdjustmentResult summary = SummaryOf(adjusted, result->messages);
    result->summary = Summarize(summary);
    result->adjusted = std::move(summary);
  }

  void AddUnusable(std::vector<ExteriorResult>* results) const {
    for (const UnusablePhoto& photo : block_.unusable) {
      ExteriorResult failed;
      failed.photo = photo.name;
      failed.messages = {photo.reason};
      results->push_back(std::move(failed));
    }
  }

  void NameNeedlessApproximations(BlockRunResult* result) const {
    const std::vector<std::string>& needless = approximations_->Needless();
    const std::vector<std::string>& more = approximations_->Messages();
    result->messages.insert(result->messages.end(), more.begin(), more.end());
    if (needless.empty()) return;
    if (IsOrientationTable(block_.approximations)) result->not_there = needless;
    constexpr std::size_t kMostNames = 5;
    std::string names;
    for (std::size_t i = 0; i < std::min(needless.size(), kMostNames); ++i)
      names += (i > 0 ? ", " : "") + needless[i];
    if (needless.size() > kMostNames) names += ", ...";
    result->messages.push_back(block_.approximations + " has " + std::to_string(needless.size()) +
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

  const BlockRunOptions& options_;
  const BlockFile& block_;
  CameraFile camera_;
  bool film_;
  std::optional<double> earth_k1_;              // in camera_ since it is decided
  std::set<std::string> interiors_that_stay_;   // of a plan
  std::map<std::string, std::string> changed_;  // photos that are oriented again, by the reason
  MarkShapes marks_;
  StageFolder exterior_;
  std::optional<BlockApproximations> approximations_;
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

#include "block/block.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "block/held_to_control.h"
#include "block/inputs/block_files.h"
#include "block/inputs/measurement_inputs.h"
#include "block/inputs/same_images.h"
#include "block/stages/adjustment_stage.h"
#include "block/stages/exterior_inputs.h"
#include "block/stages/exterior_stage.h"
#include "block/stages/interior_stage.h"
#include "block/stages/neighbour_stage.h"
#include "block/stages/tie_stage.h"
#include "block/verdict/adjustment_summary.h"
#include "block/verdict/approximations_apart.h"
#include "block/verdict/calibrated_camera.h"
#include "block/verdict/final_results.h"
#include "block/verdict/point_table.h"
#include "block/verdict/pose_covariance.h"
#include "core/files/orientation_table.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

void OrientInteriors(const BlockInputs& inputs, ProgressListener* listener) {
  ProgressTask progress(listener, "interior orientation",
                        static_cast<int>(inputs.Block().photos.size()));
  RunInterior(inputs.Interior(), [&] { progress.Advance(); });
}

// Orients each photo by its own patches. Kept results of earlier runs whose inputs have changed
// are computed again, and the change is reported as a finding.
void OrientExteriors(const BlockInputs& inputs, const ResultStore& results,
                     ProgressListener* listener, OrientedBlock* block) {
  ExteriorRunOptions options = inputs.Exterior(results.Folder());
  options.resume = true;
  options.next_photos = [&](const std::vector<ExteriorResult>& so_far, OrientationTable* table) {
    std::vector<std::size_t> next = NextPhotos(inputs, so_far);
    *table = inputs.Approximations().Table();
    return next;
  };
  ProgressTask progress(listener, "exterior orientation",
                        static_cast<int>(inputs.Block().photos.size()));
  std::map<std::string, std::vector<std::string>> changed;
  RunExterior(
      options, [&] { progress.Advance(); }, &changed);
  std::map<std::string, std::vector<std::string>> photos;  // by which of their inputs have changed
  for (const auto& [photo, what] : changed) photos[TextOfInputs(what)].push_back(photo);
  for (const auto& [what, names] : photos)
    block->findings.push_back({.reason = Reason::kInputsChanged,
                               .value = static_cast<double>(names.size()),
                               .where = fmt::format("{}: {}", what, fmt::join(names, ", "))});
}

std::vector<BlockPhotoFile> ReadPhotos(const BlockInputs& inputs, const ResultStore& results) {
  std::vector<BlockPhotoFile> photos;
  for (const std::string& path : inputs.Block().photos)
    photos.push_back(ReadBlockPhoto(path, results.PathOf(PhotoName(path)), inputs.Camera(),
                                    inputs.Marks(), inputs.OutputDirectory()));
  // An earlier run's picture of a photo that has no patches any more. Where only the interior
  // orientation disagrees now, the picture is that of the stage's result, which stays.
  std::error_code ignored;
  for (const BlockPhotoFile& photo : photos)
    if (!photo.HasPose() && !Has(photo.exterior.findings, Reason::kScanOrientationExcluded))
      fs::remove(fs::path(inputs.OutputDirectory()) / (photo.name + ".patches.png"), ignored);
  return photos;
}

std::set<std::string> Posed(const std::vector<BlockPhotoFile>& photos) {
  std::set<std::string> posed;
  for (const BlockPhotoFile& photo : photos)
    if (photo.HasPose()) posed.insert(photo.name);
  return posed;
}

// Orients photos without patches of their own by patches from their neighbours.
void OrientByNeighbours(const BlockInputs& inputs, const BlockFolder& folder,
                        ProgressListener* listener, OrientedBlock* block) {
  const GroundSurface surface = SurfaceUnder(inputs.Block(), block->photos);
  RunNeighbourStage({inputs.Exterior(""), inputs.Approximations(), inputs.Camera(), inputs.Marks(),
                     surface, folder.Directory(), folder.StageDirectory("neighbours"), listener},
                    &block->photos, &block->findings);
}

std::vector<TieRecord> MeasureTies(const BlockInputs& inputs, const BlockFolder& folder,
                                   const GroundSurface& surface, ProgressListener* listener,
                                   OrientedBlock* block) {
  ProgressTask progress(listener, "tie points", static_cast<int>(Posed(block->photos).size()));
  const TieStage stage{block->photos,
                       inputs.Camera().camera,
                       surface,
                       inputs.Shared(),
                       ResultStore(folder.StageDirectory("ties"), ".ties.json"),
                       inputs.Options().jobs};
  return RunTieStage(
      stage, [&] { progress.Advance(); }, &block->findings);
}

void JudgeApart(const std::optional<Finding>& apart, const PosePriors& stated,
                std::vector<ExteriorResult>* results, Findings* findings) {
  if (!apart) return;
  findings->push_back(*apart);
  AddToPhotos(*apart, stated, results);
}

JudgedBlock AdjustAndJudge(const AdjustmentInputs& inputs, const PosePriors& stated) {
  const auto judged = [](const AdjustmentInputs& given) {
    AdjustedBlock adjusted = AdjustPhotos(given);
    std::vector<ExteriorResult> results = FinalResults(given, adjusted);
    return JudgedBlock{std::move(adjusted), std::move(results), {}};
  };
  AdjustmentInputs by_control = inputs;
  by_control.known = {};
  JudgedBlock without = judged(by_control);
  const auto apart = ApproximationsApart(without.results, stated);
  JudgedBlock done =
      inputs.known.Empty() ? std::move(without) : HeldToControl(judged(inputs), std::move(without));
  JudgeApart(apart, stated, &done.results, &done.findings);
  return done;
}

void Adjust(const BlockInputs& inputs, const std::vector<TieRecord>& ties,
            const GroundSurface& surface, OrientedBlock* block) {
  const BlockAdjustmentChoice& settings = inputs.Block().adjustment;
  const AdjustmentInputs given{block->photos,
                               ties,
                               inputs.Camera().camera,
                               surface,
                               inputs.Block().patchdb,
                               settings,
                               inputs.Approximations().Observations(),
                               &inputs.ManualMeasurements()};
  JudgedBlock judged = AdjustAndJudge(given, inputs.Approximations().Stated());
  block->results = std::move(judged.results);
  block->findings.insert(block->findings.end(), judged.findings.begin(), judged.findings.end());
  const AdjustedBlock& adjusted = judged.adjusted;
  const std::string& out = inputs.OutputDirectory();
  WriteCalibratedCamera(out, inputs.Camera(), adjusted.result);
  if (!WritePoseCovariance(out, settings.pose_covariance, adjusted, block->results))
    block->findings.push_back(NoPoseCovariance());
  if (adjusted.result.converged && !adjusted.result.cameras.empty())
    block->camera.camera = adjusted.result.cameras.front();
  block->findings.insert(block->findings.end(), adjusted.result.findings.begin(),
                         adjusted.result.findings.end());
  const PointTable points = TableOfPoints(adjusted.surveyed, adjusted.block, adjusted.result);
  WritePointTable(out, points);
  block->control_points = TextOf(points);
  block->adjusted = SummaryOf(adjusted, block->findings);
  block->summary = Summarize(*block->adjusted, block->photos);
}

// Takes the photos' own results as final; files of an earlier adjustment no longer hold.
void TakeOwnResults(const BlockInputs& inputs, OrientedBlock* block) {
  const std::string& out = inputs.OutputDirectory();
  block->results = OwnResults(block->photos);
  fs::remove(AdjustmentResultPath(out));
  fs::remove(CalibratedCameraPath(out));
  fs::remove(PoseCovariancePath(out));
  fs::remove(PointTablePath(out));
  if (inputs.Block().adjustment.pose_covariance) block->findings.push_back(NoPoseCovariance());
  const PosePriors& stated = inputs.Approximations().Stated();
  JudgeApart(ApproximationsApart(block->results, stated), stated, &block->results,
             &block->findings);
}

// A final result is made from the whole block and is never reused by a later run.
void ForgetStages(std::vector<ExteriorResult>* results) {
  for (ExteriorResult& result : *results) {
    result.made_from.clear();
    result.earth_k1.reset();
    result.asked_of_neighbours.reset();
  }
}

void AddUnusable(const BlockInputs& inputs, OrientedBlock* block) {
  for (const UnusablePhoto& photo : inputs.Block().unusable) {
    ExteriorResult failed;
    failed.photo = photo.name;
    failed.findings = {
        {.reason = Reason::kUnusableInBlock, .at_best = Status::kFailed, .where = photo.reason}};
    block->results.push_back(std::move(failed));
  }
}

void NameUnknownMeasurements(const BlockInputs& inputs, OrientedBlock* block) {
  std::vector<std::string> photos = PhotoNames(inputs.Block().photos);
  for (const UnusablePhoto& photo : inputs.Block().unusable) photos.push_back(photo.name);
  if (auto unknown = UnknownPhotos(inputs.ManualMeasurements(), photos))
    block->findings.push_back(*std::move(unknown));
}

void TakeRemarks(const BlockInputs& inputs, OrientedBlock* block) {
  const Findings& remarks = inputs.Approximations().Remarks();
  block->findings.insert(block->findings.end(), remarks.begin(), remarks.end());
  block->not_there = inputs.Approximations().NotThere();
}

}  // namespace

OrientedBlock Orient(const BlockInputs& inputs, const BlockFolder& folder,
                     ProgressListener* listener) {
  const ResultStore exterior = ExteriorStore(folder.StageDirectory("exterior"));
  OrientedBlock block;
  block.camera = inputs.Camera();
  if (inputs.IsFilm()) OrientInteriors(inputs, listener);
  OrientExteriors(inputs, exterior, listener, &block);
  block.photos = ReadPhotos(inputs, exterior);
  for (Finding& finding : SameImages(block.photos)) block.findings.push_back(std::move(finding));
  if (inputs.Block().adjustment.ties && block.photos.size() > 1 && !Posed(block.photos).empty()) {
    OrientByNeighbours(inputs, folder, listener, &block);
    const GroundSurface surface = SurfaceUnder(inputs.Block(), block.photos);
    const auto ties = MeasureTies(inputs, folder, surface, listener, &block);
    if (!ties.empty() || JoinsPhotos(inputs.ManualMeasurements(), Posed(block.photos)))
      Adjust(inputs, ties, surface, &block);
  }
  if (!block.adjusted) TakeOwnResults(inputs, &block);
  for (ExteriorResult& result : block.results) ApplyVerdict(inputs.ManualMeasurements(), &result);
  ForgetStages(&block.results);
  AddUnusable(inputs, &block);
  TakeRemarks(inputs, &block);
  NameUnknownMeasurements(inputs, &block);
  return block;
}

}  // namespace orient::block

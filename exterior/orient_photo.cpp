#include "exterior/orient_photo.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/median.h"
#include "exterior/judge.h"
#include "exterior/search/first_pose.h"
#include "exterior/search/wide_search.h"
#include "exterior/settled_pose.h"
#include "exterior/steps/photo_task.h"
#include "exterior/steps/precise_round.h"

namespace orient::exterior {
namespace {

// Largest log10 of false alarms at which the best pose of a search of the whole photo is judged by
// precise matches; there, the number of trials counts against it.
constexpr double kWorthAJudgement = 2;

void TellPlace(const PreciseMatch& match, double added_px2, PatchResult* patch) {
  patch->pixel = match.pixel;
  patch->sigma_px = (match.covariance_px2.diagonal().array() + added_px2).sqrt().matrix();
  patch->ncc = match.ncc;
}

void TellRejected(PatchResult* patch) {
  patch->state = PatchState::kRejected;
  patch->findings = {{.reason = Reason::kPatchContradictsOthers}};
}

void FillPatches(const PhotoTask& task, const PreciseRound& round, ExteriorResult* result) {
  std::vector<PatchResult> patches(round.predictions.size());
  for (std::size_t i = 0; i < round.predictions.size(); ++i) {
    const PreciseMatch& match = round.matches[i];
    patches[i].id = task.patches[round.predictions[i].patch].id;
    patches[i].source = task.patches[round.predictions[i].patch].source_id;
    patches[i].ground_m = task.patches[round.predictions[i].patch].ground_m;
    patches[i].predicted = round.predictions[i].pixel;
    patches[i].state = PatchState::kNotFound;
    patches[i].findings = match.why_not;
  }
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    PatchResult& patch = patches[round.observed[k]];
    patch.state = PatchState::kMatched;
    if (!round.estimate || round.estimate->rejected[k]) TellRejected(&patch);
    TellPlace(round.matches[round.observed[k]], round.estimate ? round.estimate->added_px2 : 0,
              &patch);
    if (round.estimate) patch.residual_px = round.estimate->residuals_px[k];
  }
  for (const UnseenPatch& unseen : round.not_visible) {
    PatchResult patch;
    patch.id = task.patches[unseen.patch].id;
    patch.source = task.patches[unseen.patch].source_id;
    patch.ground_m = task.patches[unseen.patch].ground_m;
    patch.state = PatchState::kNotVisible;
    patch.findings = {{.reason = ReasonOf(unseen.why)}};
    patches.push_back(patch);
  }
  std::sort(patches.begin(), patches.end(),
            [](const PatchResult& a, const PatchResult& b) { return a.id < b.id; });
  result->patches = std::move(patches);
}

// A patch that was found in a larger window and contradicts the pose is not searched for that far
// away again, but is reported all the same.
void NameContradicting(const PhotoView& view, const std::vector<PreciseRound>& rounds,
                       const PhotoTask& task, ExteriorResult* result) {
  std::map<std::int64_t, const PreciseMatch*> found;  // by patch: its last match
  for (const PreciseRound& round : rounds)
    for (std::size_t i = 0; i < round.matches.size(); ++i)
      if (round.matches[i].found)
        found[task.patches[round.predictions[i].patch].id] = &round.matches[i];
  for (PatchResult& patch : result->patches) {
    const auto match = found.find(patch.id);
    if (patch.state != PatchState::kNotFound || match == found.end()) continue;
    const auto expected = view.PixelFromGround(*patch.ground_m);
    if (!expected) continue;
    TellRejected(&patch);
    TellPlace(*match->second, 0, &patch);
    patch.residual_px = *patch.pixel - *expected;
  }
}

// Spread of the agreeing patches: 1 if all over the photo, 0 if on a line.
double SpreadOf(const PhotoTask& task, const PreciseRound& round) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  double count = 0;
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    if (round.estimate->rejected[k]) continue;
    const Eigen::Vector2d& pixel = round.matches[round.observed[k]].pixel;
    sum += pixel;
    squares += pixel * pixel.transpose();
    ++count;
  }
  const Eigen::Matrix2d moments = squares / count - sum * sum.transpose() / (count * count);
  const double area = static_cast<double>(task.image.Width()) * task.image.Height();
  return 12 * std::sqrt(std::max(0.0, moments.determinant())) / area;
}

TriedPatches ToRemedy(const PhotoTask& task, const PreciseRound& round) {
  TriedPatches tried;
  tried.visible = static_cast<int>(round.predictions.size());
  std::vector<double> sides_px;
  for (const PatchPrediction& p : round.predictions)
    if (const auto side_px = PatchSide(round.view, task.patches[p.patch]))
      sides_px.push_back(*side_px / round.reduction);
  if (!sides_px.empty()) tried.side_px = Median(std::move(sides_px));
  return tried;
}

double MeanHeight(const PhotoTask& task, const PreciseRound& round) {
  double sum = 0;
  for (const PatchPrediction& p : round.predictions) sum += task.patches[p.patch].ground_m.z();
  return sum / static_cast<double>(round.predictions.size());
}

// Accuracy required of the pose on the ground: no finer than a pixel of the photo, nor than the
// control allows, i.e. half of the patches' pixel and the errors common to their heights.
double Target_m(const PhotoTask& task, const PreciseRound& round, const PhotoView& view) {
  if (task.options.target_m) return *task.options.target_m;
  const double height_m = MeanHeight(task, round), ground_pixel_m = view.GroundPixel(height_m);
  std::vector<double> resolutions_m;
  for (const PatchPrediction& p : round.predictions)
    resolutions_m.push_back(task.patches[p.patch].gsd_m);
  const double by_heights_m =
      ground_pixel_m *
      WorstProjectionSigma(view, round.estimate->common_height_covariance, height_m);
  return std::hypot(std::max(ground_pixel_m, 0.5 * Median(std::move(resolutions_m))), by_heights_m);
}

// `round`: with the matches found close to the pose; `places`: without them, as they assume it.
JudgedPose ToJudge(const PhotoTask& task, const PreciseRound& round, int places,
                   const PoseTrack& track, double target_m) {
  const PoseEstimate& estimate = *round.estimate;
  const double height_m = MeanHeight(task, round);
  const PhotoView view = task.View(track.position, estimate.pose);
  JudgedPose judged;
  judged.places = places;
  judged.spread = SpreadOf(task, round);
  judged.worst_sigma_px = WorstProjectionSigma(view, estimate.honest_covariance, height_m);
  judged.target_px = target_m / view.GroundPixel(height_m);
  judged.trends = estimate.trends;
  judged.contradicts_prior = round.contradicts_prior;
  judged.prior_sigmas = std::sqrt(std::max(0.0, estimate.prior_chi2));
  judged.prior_counts = task.photo.accuracy_is_stated || task.options.wide;
  return judged;
}

ExteriorResult Failed(const PhotoTask& task, const Finding& why) {
  ExteriorResult result;
  result.photo = task.photo.name;
  result.status = Status::kFailed;
  result.findings = {why};
  return result;
}

// `tried`: the patches that were searched for; `rounds`: what came before.
ExteriorResult Failed(const PhotoTask& task, const Finding& why, const PreciseRound& tried,
                      const std::vector<LoopRound>& rounds) {
  ExteriorResult result = Failed(task, why);
  result.iterations = rounds;
  FillPatches(task, tried, &result);
  for (const Finding& remedy : Remedies(ToRemedy(task, tried))) result.findings.push_back(remedy);
  return result;
}

// Failed before any precise match. `track`: the pose reached so far, null if none. The
// patches are those visible under it, none of which was found in agreement with others.
ExteriorResult FailedEarly(const PhotoTask& task, const Finding& why, const PoseTrack* track) {
  const PosePrior& prior = task.photo.prior;
  PreciseRound tried;
  tried.view = track != nullptr ? task.View(track->position, track->pose)
                                : task.View(task.photo.positions.front(), prior.pose);
  tried.predictions = Predict(tried.view, track != nullptr ? track->covariance : prior.covariance,
                              task.patches, task.Prediction(), &tried.not_visible);
  tried.matches.resize(tried.predictions.size());
  for (PreciseMatch& match : tried.matches)
    match.why_not = {{.reason = Reason::kPatchFoundWithNoOthers}};
  // For the advice: a pose that chance explains may be far too high.
  tried.view = task.View(task.photo.positions.front(), prior.pose);
  return Failed(task, why, tried, track != nullptr ? track->rounds : std::vector<LoopRound>());
}

ExteriorResult ResultOf(const PhotoTask& task, SettledPose pose) {
  const PreciseRound round = Complete(task, pose.track, pose.Last());
  pose.track.rounds.push_back(SummaryOf(round));
  ExteriorResult result;
  result.photo = task.photo.name;
  result.pose = round.estimate->pose;
  result.covariance = round.estimate->honest_covariance;
  result.sigma0_px = round.estimate->sigma0_px;
  result.orientation = pose.track.position.orientation;
  result.iterations = pose.track.rounds;
  FillPatches(task, round, &result);
  const PhotoView view = task.View(pose.track.position, *result.pose);
  NameContradicting(view, pose.rounds, task, &result);
  const double pixel_m = view.GroundPixel(MeanHeight(task, round));
  result.target_m = Target_m(task, round, view);
  JudgedPose judged = ToJudge(task, round, pose.matches.places, pose.track, *result.target_m);
  judged.sources = VotesOf(result.patches, round.reduction);
  result.projection_sigma = ProjectionSigmaOf(judged.worst_sigma_px, pixel_m);
  result.findings = Judge(judged);
  const FilmPosition& position = pose.track.position;
  const int alike = EquallyLikelyPositions(task.photo, position, result.pose->opk_rad.z());
  if (position.orientation && alike > 1)
    result.findings.push_back({.reason = Reason::kKappaWithOrientation,
                               .value = alike,
                               .where = std::string(Name(*position.orientation))});
  result.status = StatusOf(result.findings);
  return result;
}

}  // namespace

ExteriorResult OrientPhoto(const PhotoToOrient& photo, const PhotoImage& image,
                           const std::vector<patchdb::Patch>& patches,
                           const OrientPhotoOptions& options) {
  const PhotoTask task{photo, image, patches, options};
  if (patches.empty()) return Failed(task, NoPatches("the patch database"));

  WholePhotoSearch search;
  if (options.wide)
    search = SearchWidely(task);
  else
    search.track = FirstPose(task);
  std::optional<PoseTrack>& track = search.track;
  if (!track && options.wide)
    return FailedEarly(
        task, search.searched ? NothingAlike(search.complete) : NotSearchedAsAWhole(), nullptr);
  if (!track) return FailedEarly(task, WhyNoFirstPose(task), nullptr);
  const auto chance = [&] { return track->log10_false_alarms > options.max_log10_false_alarms; };
  const auto no_consensus = [&] {
    return FailedEarly(task, NoConsensus(track->rounds.front(), options.wide, search.complete),
                       &*track);
  };
  // What a wide search leaves open at its level, the patches may still decide at a finer one.
  if (!options.wide && chance()) return no_consensus();
  const int reduction = PreciseReduction(task, *track);
  Descend(task, reduction, &*track);
  if (chance() && !(options.wide && track->log10_false_alarms < kWorthAJudgement))
    return no_consensus();
  SettledPose pose = SettlePose(task, *track, reduction);
  if (pose.why_not) return Failed(task, *pose.why_not, pose.Last(), pose.track.rounds);
  return ResultOf(task, std::move(pose));
}

}  // namespace orient::exterior

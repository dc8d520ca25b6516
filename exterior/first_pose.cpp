#include "exterior/first_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/imaging/side_by_side.h"
#include "core/median.h"
#include "exterior/align.h"
#include "exterior/consensus.h"
#include "exterior/match.h"

namespace orient {
namespace {

// The coarsest power of two at which a typical patch still has enough pixels to be told from
// others, and not so coarse that the window is only a few pixels.
int CoarsestReduction(const PhotoTask& task, const PhotoView& view,
                      const std::vector<PatchPrediction>& predictions, double radius_px) {
  std::vector<double> sides;
  for (std::size_t i = 0; i < predictions.size(); i += 1 + predictions.size() / 20)
    if (const auto side = PatchSide(view, task.patches[predictions[i].patch]))
      sides.push_back(*side);
  if (sides.empty()) return 1;
  const double side = UpperMedian(std::move(sides));
  int reduction = 1;
  while (side / (reduction * 2) >= task.options.min_side_px && radius_px / (reduction * 2) > 8)
    reduction *= 2;
  return reduction;
}

// Of an aligned patch in pixels; below, any two textures correlate.
int LeastSide(const OrientPhotoOptions& options) { return std::min(options.min_side_px, 11); }

// One coarse round: several places for every patch, and the pose that most of them agree on.
std::optional<Consensus> Vote(const PhotoTask& task, const PhotoView& view, const PosePrior& prior,
                              const std::vector<PatchPrediction>& predictions, int reduction,
                              double margin_px, double trials) {
  std::vector<VotingPatch> voting(predictions.size());
  SideBySide(predictions.size(), [&](std::size_t i) {
    const PatchPrediction& prediction = predictions[i];
    const Patch& patch = task.patches[prediction.patch];
    voting[i].ground_m = patch.ground_m;
    const auto aligned =
        AlignPatch(view, patch, reduction, LeastSide(task.options), task.options.max_side_px);
    if (!aligned) return;
    const Eigen::Vector2d radius =
        prediction.Radius(kWindowSigmas) + Eigen::Vector2d::Constant(margin_px);
    voting[i].window_px2 = AreaToSearch(aligned->predicted_px, radius, task.image).Size().prod();
    voting[i].candidates = FindCandidates(*aligned, task.image, radius, {});
  });
  ConsensusOptions options;
  options.sigma_px = 0.5 + 0.4 * reduction;
  options.trials = trials;
  return FindConsensus(view, prior, voting, options);
}

// Approximations are often worse than they are said to be: twice, and in position a few per cent
// of the flying height, which is what a map or a forgotten datum shift makes of it.
PosePrior Doubtful(const PosePrior& prior, const std::vector<Patch>& patches) {
  constexpr double kShareOfHeight = 0.03;
  const double height = std::abs(prior.pose.position_m.z() - patches.front().ground_m.z());
  PosePrior wide = prior;
  wide.covariance *= 4;
  wide.covariance.topLeftCorner<3, 3>() +=
      std::pow(kShareOfHeight * height, 2) * Eigen::Matrix3d::Identity();
  return wide;
}

// Pixels of one search window at its resolution: more would take minutes a patch and all memory.
constexpr double kMaxWindowPixels = 12e6;

// Which patches are sought, how far around, and at which resolution.
struct SearchPlan {
  std::vector<PatchPrediction> predictions;
  double radius_px = 0;
  int coarsest = 1;

  // Of the largest window, as far as it lies in the photo.
  double WindowPixels(const PhotoTask& task, int reduction) const {
    const double width = std::min<double>(2 * radius_px, task.image.Width()) / reduction;
    return width * std::min<double>(2 * radius_px, task.image.Height()) / reduction;
  }
};

SearchPlan Plan(const PhotoTask& task, const FilmPosition& position, const PosePrior& prior) {
  const PhotoView view = task.View(position, prior.pose);
  SearchPlan plan;
  plan.predictions = SelectSpread(Predict(view, prior.covariance, task.patches, task.Prediction()),
                                  task.patches, task.options.voting_patches, task.Prediction());
  plan.radius_px = LargestRadius(plan.predictions, kWindowSigmas);
  plan.coarsest = CoarsestReduction(task, view, plan.predictions, plan.radius_px);
  return plan;
}

// A first pose from one prior at one resolution.
std::optional<PoseTrack> TryFirst(const PhotoTask& task, const FilmPosition& position,
                                  const PosePrior& prior, int finer, double trials) {
  const SearchPlan plan = Plan(task, position, prior);
  if (plan.predictions.empty() || plan.coarsest < finer) return std::nullopt;
  const int reduction = plan.coarsest / finer;
  if (plan.WindowPixels(task, reduction) > kMaxWindowPixels) return std::nullopt;
  const PhotoView view = task.View(position, prior.pose);
  const auto consensus = Vote(task, view, prior, plan.predictions, reduction, reduction, trials);
  if (!consensus) return std::nullopt;
  const LoopRound round{static_cast<int>(plan.predictions.size()),
                        static_cast<int>(consensus->supporters.size()), plan.radius_px,
                        consensus->rms_px};
  return PoseTrack{
      position, consensus->pose, consensus->covariance, consensus->log10_false_alarms, reduction,
      {round},  trials};
}

}  // namespace

// Every way the film may lie is tried in the same manner before any is tried harder: the wrong ones
// never succeed.
std::optional<PoseTrack> FirstPose(const PhotoTask& task) {
  const PosePrior& prior = task.photo.prior;
  const PosePrior doubtful = Doubtful(prior, task.patches);
  std::optional<PoseTrack> best;
  const std::array ways = {std::pair(&prior, 1), std::pair(&prior, 2), std::pair(&doubtful, 1)};
  const auto trials = static_cast<double>(ways.size() * task.photo.positions.size());
  for (const auto& [assumed, finer] : ways) {
    for (const FilmPosition& position : task.photo.positions) {
      const auto track = TryFirst(task, position, *assumed, finer, trials);
      if (track && (!best || track->log10_false_alarms < best->log10_false_alarms)) best = track;
    }
    if (best && best->log10_false_alarms < task.options.max_log10_false_alarms) return best;
  }
  return best;
}

void Descend(const PhotoTask& task, PoseTrack* track) {
  const PosePrior weak = Weakened({track->pose, task.photo.prior.covariance});
  for (int reduction = track->reduction / 2; reduction > 1; reduction /= 2) {
    const double margin = 1.5 * track->reduction;
    const PhotoView view = task.View(track->position, track->pose);
    const auto predictions =
        SelectSpread(Predict(view, track->covariance, task.patches, task.Prediction()),
                     task.patches, task.options.voting_patches, task.Prediction());
    const auto consensus = Vote(task, view, weak, predictions, reduction, margin, track->trials);
    // A patch may be too small for this level: a finer one shows it.
    if (!consensus || consensus->supporters.size() < 4) continue;
    track->pose = consensus->pose;
    track->covariance = consensus->covariance;
    track->log10_false_alarms = std::min(track->log10_false_alarms, consensus->log10_false_alarms);
    track->reduction = reduction;
    track->rounds.push_back(
        {static_cast<int>(predictions.size()), static_cast<int>(consensus->supporters.size()),
         LargestRadius(predictions, kWindowSigmas) + margin, consensus->rms_px});
  }
}

std::string WhyNoFirstPose(const PhotoTask& task) {
  const FilmPosition& position = task.photo.positions.front();
  const SearchPlan plan = Plan(task, position, task.photo.prior);
  if (plan.predictions.empty())
    return "its approximation sees none of the " + std::to_string(task.patches.size()) +
           " patches in the region: correct it, or harvest patches there";
  const PhotoView view = task.View(position, task.photo.prior.pose);
  const bool large_enough = std::any_of(
      plan.predictions.begin(), plan.predictions.end(), [&](const PatchPrediction& prediction) {
        const auto side = PatchSide(view, task.patches[prediction.patch]);
        return side && *side >= LeastSide(task.options);
      });
  if (!large_enough)
    return "under its approximation the patches are smaller than " +
           std::to_string(LeastSide(task.options)) +
           " px: its height is wrong, or the patches are of another scale";
  if (plan.WindowPixels(task, plan.coarsest) > kMaxWindowPixels)
    return "its approximation is too uncertain: every patch would be sought in most of the photo; "
           "give a better one, or its true accuracy";
  return "fewer than three of the patches have a counterpart in the photo";
}

}  // namespace orient

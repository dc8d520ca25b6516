#include "exterior/search/first_pose.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <set>
#include <tuple>

#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "exterior/search/search_prior.h"
#include "exterior/steps/align.h"
#include "exterior/steps/consensus.h"
#include "exterior/steps/match.h"

namespace orient::exterior {
namespace {

constexpr int kVotingPatches = 160;  // in the coarse rounds

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
  while (side / (reduction * 2) >= kMinSide_px && radius_px / (reduction * 2) > 8) reduction *= 2;
  return reduction;
}

// Least side of an aligned patch in pixels; below, any two textures correlate.
constexpr int kLeastSide_px = 11;

// Several candidate places for each patch at a coarse level.
std::vector<VotingPatch> Seek(const PhotoTask& task, const PhotoView& view,
                              const std::vector<PatchPrediction>& predictions, int reduction,
                              double margin_px) {
  std::vector<VotingPatch> voting(predictions.size());
  SideBySide(predictions.size(), [&](std::size_t i) {
    const PatchPrediction& prediction = predictions[i];
    const patchdb::Patch& patch = task.patches[prediction.patch];
    voting[i].ground_m = patch.ground_m;
    const auto aligned = AlignPatch(view, patch, reduction, kLeastSide_px, kMaxSide_px);
    if (!aligned) return;
    const Eigen::Vector2d radius =
        prediction.Radius(kWindowSigmas) + Eigen::Vector2d::Constant(margin_px);
    voting[i].window_px2 = AreaToSearch(aligned->predicted_px, radius, task.image).Size().prod();
    voting[i].candidates = FindCandidates(*aligned, task.image, radius, {});
  });
  return voting;
}

// If one patch in seven is right, this many samples contain three right ones a few times.
constexpr int kSamplesOfAll = 20000;

// The pose that most of the patches searched for at a level agree on.
std::optional<Consensus> Vote(const PhotoView& view, const PosePrior& prior,
                              const std::vector<VotingPatch>& voting, int reduction, double trials,
                              int samples = ConsensusOptions().samples) {
  ConsensusOptions options;
  options.samples = samples;
  options.sigma_px = 0.5 + 0.4 * reduction;
  options.trials = trials;
  return FindConsensus(view, prior, voting, options);
}

// Votes with patches sought where the track's pose projects them, at a level; leaves the track
// unchanged if too few agree.
void VoteAround(const PhotoTask& task, int reduction, double margin_px, PoseTrack* track,
                int most_patches = kVotingPatches) {
  const PosePrior weak = Weakened({track->pose, task.photo.prior.covariance});
  const PhotoView view = task.View(track->position, track->pose);
  const auto predictions =
      SelectSpread(Predict(view, track->covariance, task.patches, task.Prediction()), task.patches,
                   most_patches, task.Prediction());
  const auto consensus = Vote(view, weak, Seek(task, view, predictions, reduction, margin_px),
                              reduction, track->trials);
  // The patches may be too small at this level: a finer one shows them.
  if (!consensus || consensus->supporters.size() < 4) return;
  track->pose = consensus->pose;
  track->covariance = consensus->covariance;
  track->log10_false_alarms = std::min(track->log10_false_alarms, consensus->log10_false_alarms);
  track->reduction = reduction;
  track->rounds.push_back(
      {static_cast<int>(predictions.size()), static_cast<int>(consensus->supporters.size()),
       LargestRadius(predictions, kWindowSigmas) + margin_px, consensus->rms_px, reduction});
}

// Most pixels of one search window at its resolution: more takes minutes per patch and all memory.
constexpr double kMaxWindowPixels = 3e6;

// Most pixels of all windows searched for a first pose, at their resolution: minutes of CPU time.
constexpr double kMaxSearchedPixels = 1e10;

// Which patches are searched for, how far around, and at which resolution.
struct SearchPlan {
  std::vector<PatchPrediction> predictions;
  double radius_px = 0;
  int coarsest = 1;

  // Pixels of the largest window, as far as it lies in the photo.
  double WindowPixels(const PhotoTask& task, int reduction) const {
    const double width = std::min<double>(2 * radius_px, task.image.Width()) / reduction;
    return width * std::min<double>(2 * radius_px, task.image.Height()) / reduction;
  }
};

SearchPlan Plan(const PhotoTask& task, const FilmPosition& position, const PosePrior& prior) {
  const PhotoView view = task.View(position, prior.pose);
  SearchPlan plan;
  plan.predictions = SelectSpread(Predict(view, prior.covariance, task.patches, task.Prediction()),
                                  task.patches, kVotingPatches, task.Prediction());
  plan.radius_px = LargestRadius(plan.predictions, kWindowSigmas);
  plan.coarsest = CoarsestReduction(task, view, plan.predictions, plan.radius_px);
  return plan;
}

// In a window sized for a poor approximation a patch costs much, in one around a known pose hardly
// anything. So a few patches all over the photo are searched for first, and more only until they
// agree on a pose that chance does not explain; it then shows where the others are.
constexpr int kFirstPatches = 12;
constexpr std::size_t kFewBatches = 2, kAllBatches = std::numeric_limits<std::size_t>::max();

// The predictions in batches; the first batches, taken together, are spread over the photo.
std::vector<std::vector<PatchPrediction>> Batches(const PhotoTask& task,
                                                  const std::vector<PatchPrediction>& predictions) {
  std::vector<std::vector<PatchPrediction>> batches;
  std::vector<bool> taken(task.patches.size(), false);
  const int all = static_cast<int>(predictions.size());
  int wanted = 0;
  for (int count = kFirstPatches; wanted < all; count *= 2) {
    wanted = 3 * count > 2 * all ? all : count;  // no small last batch
    batches.emplace_back();
    for (const PatchPrediction& p :
         SelectSpread(predictions, task.patches, wanted, task.Prediction())) {
      if (!taken[p.patch]) batches.back().push_back(p);
      taken[p.patch] = true;
    }
    // A larger selection need not contain the smaller ones: all of it may be taken already.
    if (batches.back().empty()) batches.pop_back();
  }
  return batches;
}

// The search for a first pose from one prior at one resolution, in one film position.
class FirstSearch {
 public:
  FirstSearch(const PhotoTask& task, const FilmPosition& position, const PosePrior& prior,
              int finer)
      : task_(task), position_(position), prior_(prior), view_(task.View(position, prior.pose)) {
    const SearchPlan plan = Plan(task, position, prior);
    patches_ = plan.predictions.size();
    window_pixels_ = plan.WindowPixels(task, plan.coarsest);
    reduction_ = plan.coarsest / finer;
    if (reduction_ == 0 || plan.WindowPixels(task, reduction_) > kMaxWindowPixels) return;
    radius_px_ = plan.radius_px;
    batches_ = Batches(task, plan.predictions);
  }

  std::size_t PatchCount() const { return patches_; }
  // Of the largest window, at the coarsest resolution.
  double WindowPixels() const { return window_pixels_; }
  std::size_t BatchCount() const { return batches_.size(); }
  bool Done() const { return done_ == batches_.size(); }
  std::size_t BatchesDone() const { return done_; }

  // Seeks the next batch of patches; returns the pose that they and those before agree on, if any.
  // The last batch is the last chance: up to `last_samples` are drawn.
  std::optional<PoseTrack> Next(double trials, int last_samples, SearchBudget* budget) {
    std::vector<VotingPatch> sought = Seek(task_, view_, batches_[done_++], reduction_, reduction_);
    budget->Spend(sought, reduction_);
    voting_.insert(voting_.end(), std::make_move_iterator(sought.begin()),
                   std::make_move_iterator(sought.end()));
    const int least = ConsensusOptions().samples;
    const int samples = Done() && batches_.size() > 1 ? std::max(last_samples, least) : least;
    const auto consensus = Vote(view_, prior_, voting_, reduction_, trials, samples);
    if (!consensus) return std::nullopt;
    const LoopRound round{static_cast<int>(voting_.size()),
                          static_cast<int>(consensus->supporters.size()), radius_px_,
                          consensus->rms_px, reduction_};
    return PoseTrack{position_,
                     consensus->pose,
                     consensus->covariance,
                     consensus->log10_false_alarms,
                     reduction_,
                     {round},
                     trials};
  }

 private:
  const PhotoTask& task_;
  const FilmPosition& position_;
  PosePrior prior_;
  PhotoView view_;
  std::size_t patches_ = 0;
  double window_pixels_ = 0;
  int reduction_ = 0;
  double radius_px_ = 0;
  std::vector<std::vector<PatchPrediction>> batches_;
  std::size_t done_ = 0;
  std::vector<VotingPatch> voting_;
};

// Whether every window is of moderate size.
bool IsEasy(const FirstSearch& search) {
  constexpr double kMostPixels = 1.5e6;
  return search.WindowPixels() <= kMostPixels;
}

// From one prior, in all film positions; `finer` than the coarsest resolution by this factor.
std::vector<FirstSearch> SearchesFrom(const PhotoTask& task, const PosePrior& prior, int finer) {
  std::vector<FirstSearch> searches;
  for (const FilmPosition& position : task.photo.positions)
    searches.emplace_back(task, position, prior, finer);
  return searches;
}

std::size_t MostBatches(const std::vector<FirstSearch>& searches) {
  std::size_t most = 0;
  for (const FirstSearch& search : searches) most = std::max(most, search.BatchCount());
  return most;
}

// Each batch is tried in all searches before the next one: the wrong ones never succeed. `best`:
// the best of the poses that chance explains. Nothing more is tried once the budget is spent.
std::optional<PoseTrack> InBatches(const PhotoTask& task, double trials, std::size_t most_batches,
                                   std::vector<FirstSearch>* searches, SearchBudget* budget,
                                   std::optional<PoseTrack>* best) {
  const std::size_t batches = MostBatches(*searches);
  const int samples = kSamplesOfAll / static_cast<int>(std::max<std::size_t>(searches->size(), 1));
  for (std::size_t batch = 0; batch < std::min(batches, most_batches); ++batch) {
    std::optional<PoseTrack> found;
    for (FirstSearch& search : *searches) {
      if (search.Done() || budget->Spent()) continue;
      const auto track = search.Next(trials, samples, budget);
      if (!track) continue;
      if (search.Done()) KeepBetter(track, best);
      if (track->log10_false_alarms < task.options.max_log10_false_alarms)
        KeepBetter(track, &found);
    }
    if (!found) continue;
    if (batch + 1 < batches) VoteAround(task, found->reduction, 3.0 * found->reduction, &*found);
    return found;
  }
  return std::nullopt;
}

}  // namespace

std::optional<PoseTrack> FirstPose(const PhotoTask& task) {
  const PosePrior& prior = task.photo.prior;
  const PosePrior doubtful = Doubtful(prior, task.patches.front().ground_m.z());
  // Finer or wider, a patch costs four times as much; if a few batches fail, keypoints are next.
  const std::array ways = {std::tuple(&prior, 1, kAllBatches), std::tuple(&prior, 2, kFewBatches),
                           std::tuple(&doubtful, 1, kFewBatches)};
  std::optional<PoseTrack> best;
  SearchBudget budget(kMaxSearchedPixels);
  for (const auto& [assumed, finer, most_batches] : ways) {
    auto searches = SearchesFrom(task, *assumed, finer);
    const auto trials = static_cast<double>(ways.size() * searches.size() * MostBatches(searches));
    if (auto found = InBatches(task, trials, most_batches, &searches, &budget, &best)) return found;
  }
  return best;
}

std::optional<PoseTrack> EasyFirstPose(const PhotoTask& task) {
  constexpr std::size_t kBatches = 2;
  auto searches = SearchesFrom(task, task.photo.prior, 1);
  if (!std::all_of(searches.begin(), searches.end(), IsEasy)) return std::nullopt;
  const auto trials = static_cast<double>(searches.size() * MostBatches(searches));
  SearchBudget budget(kMaxSearchedPixels);
  std::optional<PoseTrack> unproven;
  return InBatches(task, trials, kBatches, &searches, &budget, &unproven);
}

namespace {

constexpr std::size_t kFewestSought = 4;  // patches: any three agree on a pose
constexpr std::size_t kKappaBatches = 3;
// Pixels of all sectors: some 7 s of processor time. Where kappa is stated, its own sector and
// those of the usual mistakes come first.
constexpr double kMostInSectors = 1e8, kMostIfKappaIsStated = 4e7;

}  // namespace

double KappaTrials(const PhotoTask& task) {
  return static_cast<double>(kKappaSectors * task.photo.positions.size() * kKappaBatches);
}

WholePhotoSearch FirstPoseByKappa(const PhotoTask& task, double trials) {
  WholePhotoSearch search;
  std::set<Look> looks;
  std::vector<FirstSearch> searches;
  for (const PosePrior& prior : KappaSectors(task.photo.prior, task.options.prior_failed))
    for (const FilmPosition& position : task.photo.positions) {
      if (!looks.insert(LookOf(position, prior.pose.opk_rad.z())).second) continue;
      FirstSearch one(task, position, prior, 1);
      if (one.PatchCount() < kFewestSought) continue;
      if (IsEasy(one))
        searches.push_back(std::move(one));
      else
        search.complete = false;
    }
  search.searched = !searches.empty();
  SearchBudget budget(task.options.prior_failed ? kMostIfKappaIsStated : kMostInSectors);
  auto found = InBatches(task, trials, kKappaBatches, &searches, &budget, &search.track);
  if (found) search.track = std::move(found);
  for (const FirstSearch& one : searches)
    search.complete &= one.BatchesDone() >= std::min(one.BatchCount(), kKappaBatches);
  return search;
}

// Most rough poses are wrong, as a probe of some patches shows: at least this many of them agree
// around a right pose, three or four around any.
constexpr int kProbingPatches = 40, kWorthAllPatches = 6;
// Largest search radius, pixels of the level: a pose less certain than this predicts nothing.
constexpr double kFarthest_px = 200;

std::optional<PoseTrack> Confirmed(const PhotoTask& task, const PoseTrack& rough) {
  const PhotoView view = task.View(rough.position, rough.pose);
  const auto predictions = Predict(view, rough.covariance, task.patches, task.Prediction());
  if (predictions.empty()) return std::nullopt;
  PoseTrack track = rough;
  const double radius_px = LargestRadius(predictions, kWindowSigmas);
  const int reduction = std::min(CoarsestReduction(task, view, predictions, radius_px), 4);
  if (radius_px > kFarthest_px * reduction) return std::nullopt;
  if (std::ssize(predictions) > 2 * kProbingPatches) {
    PoseTrack probe = rough;
    VoteAround(task, reduction, 2.0 * rough.reduction, &probe, kProbingPatches);
    const bool found = probe.rounds.size() > rough.rounds.size();
    if (!found || probe.rounds.back().matched < kWorthAllPatches) return std::nullopt;
  }
  VoteAround(task, reduction, 2.0 * rough.reduction, &track);
  if (track.rounds.size() == rough.rounds.size()) return std::nullopt;
  return track;
}

void Descend(const PhotoTask& task, int finest, PoseTrack* track) {
  for (int reduction = track->reduction / 2; reduction > 1 && reduction >= finest; reduction /= 2)
    VoteAround(task, reduction, 1.5 * track->reduction, track);
}

Finding WhyNoFirstPose(const PhotoTask& task) {
  const auto failed = [](std::string where) {
    return Finding{
        .reason = Reason::kNoFirstPose, .at_best = Status::kFailed, .where = std::move(where)};
  };
  const FilmPosition& position = task.photo.positions.front();
  const SearchPlan plan = Plan(task, position, task.photo.prior);
  if (plan.predictions.empty())
    return failed(
        fmt::format("under its approximation none of the {} patches in the region is visible: "
                    "correct it, or harvest "
                    "patches there",
                    task.patches.size()));
  const PhotoView view = task.View(position, task.photo.prior.pose);
  const bool large_enough = std::any_of(
      plan.predictions.begin(), plan.predictions.end(), [&](const PatchPrediction& prediction) {
        const auto side = PatchSide(view, task.patches[prediction.patch]);
        return side && *side >= kLeastSide_px;
      });
  if (!large_enough)
    return failed(fmt::format(
        "under its approximation the patches are smaller than {} px: its height is wrong, or the "
        "patches are of another scale",
        kLeastSide_px));
  if (plan.WindowPixels(task, plan.coarsest) > kMaxWindowPixels)
    return failed(
        "its approximation is too uncertain: every patch would be searched for in most of the "
        "photo; "
        "give a better one, or its true accuracy");
  return failed(
      "fewer than three of the patches that were searched for have a counterpart in the photo");
}

}  // namespace orient::exterior

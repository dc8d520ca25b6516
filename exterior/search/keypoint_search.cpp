#include "exterior/search/keypoint_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <utility>

#include "core/geometry/collinearity.h"
#include "exterior/search/first_pose.h"
#include "exterior/search/keypoint_pairs.h"
#include "exterior/search/keypoint_pose.h"
#include "exterior/search/possible_pairs.h"
#include "exterior/search/search_prior.h"
#include "exterior/search/vote_cluster.h"

namespace orient::exterior {
namespace {

// Levels to search, the coarser first: most photos are found there at a quarter of the cost, and by
// few patches. In a region much larger than the photo, many patches lie outside it. In large
// photos chips may be too small for all levels but the last.
struct Level {
  double most_pixels;
  std::vector<int> batches;  // numbers of patches
};
const std::array kLevels = {Level{3e6, {300, 600}}, Level{12e6, {900, 900}}, Level{24e6, {900}}};
constexpr double kLeastChip_px = 24;  // of the level: half of it is border
// Diameter in pixels of the smallest keypoints that SIFT finds.
constexpr double kSmallest_px = 3;
// Number of rotations tried: those that most pairs imply.
constexpr int kTried = 5;
// Chips nearer than this share of the photo's longer side may show the same ground.
constexpr double kApart = 0.03;
// Chips, each with its most-backed pair, from which samples of three are drawn for a pose.
constexpr std::size_t kMostBacked = 40;
constexpr int kFewest = 5;  // agreeing places; patches then prove the pose or not

// Keypoints of the photo's levels and of chips, found once.
class FoundKeypoints {
 public:
  explicit FoundKeypoints(const PhotoTask& task) : task_(task) {}

  const Keypoints& OfPhoto(int reduction) {
    const auto [at, fresh] = photo_.try_emplace(reduction);
    if (fresh) at->second = KeypointsOf(task_.image, reduction);
    return at->second;
  }
  ChipKeypoints OfChips(const std::vector<std::size_t>& which, double least_size_m, bool mirrored) {
    return KeypointsOf(task_.patches, which, least_size_m, mirrored, &chips_[mirrored ? 1 : 0]);
  }

 private:
  const PhotoTask& task_;
  std::map<int, Keypoints> photo_;
  std::array<KeypointsByPatch, 2> chips_;  // index 0: as they are, 1: mirrored
};

// Pairs of one rotation, and how many others back each.
struct BackedPairs {
  std::vector<Pair> pairs;
  std::vector<int> backing;
};

// A search that trusts the approximation, or does without one.
class KeypointSearch {
 public:
  // `prior`: of the pose; `believed`: whether its accuracy limits which pairs are possible.
  KeypointSearch(const PhotoTask& task, FoundKeypoints* found, PosePrior prior, bool believed,
                 double ground_m, double trials)
      : task_(task),
        found_(found),
        prior_(std::move(prior)),
        believed_(believed),
        trials_(trials),
        ground_m_(ground_m) {}

  void Run(WholePhotoSearch* search) const {
    int before = 0;
    // If any pair is possible, fine levels have too many of them.
    const auto end = believed_ ? kLevels.end() : kLevels.begin() + 1;
    for (auto level = kLevels.begin(); level != end; ++level) {
      const auto& [most_pixels, batches] = *level;
      const int reduction = FinestReduction(task_.image, most_pixels);
      if (reduction == before) break;
      before = reduction;
      SearchLevel(reduction, batches, search);
      if (Convinces(search->track, task_.options)) break;
    }
  }

 private:
  void SearchLevel(int reduction, const std::vector<int>& batches, WholePhotoSearch* search) const;
  void SearchBatch(const std::vector<std::size_t>& which, int reduction,
                   WholePhotoSearch* search) const;
  void Try(const Keypoints& photo, const ChipKeypoints& chips, int reduction, bool mirrored,
           WholePhotoSearch* search) const;
  std::optional<PoseTrack> Follow(const BackedPairs& turned, const Keypoints& photo,
                                  const ChipKeypoints& chips,
                                  const std::vector<FilmPosition>& positions, int reduction) const;
  std::optional<PoseTrack> FollowChips(const BackedPairs& turned, const ChipKeypoints& chips,
                                       const FilmPosition& position, int reduction) const;
  std::vector<std::size_t> PatchesAround() const;
  double ReachMm(const PhotoView& view, const Eigen::Vector2d& photo_mm) const;
  PhotoView ViewTurned(const FilmPosition& position, double turn_rad) const;
  double WindowPx2(const PhotoView& view, const Eigen::Vector3d& ground_m) const;
  double Height() const { return prior_.pose.position_m.z() - ground_m_; }
  double Gsd() const {
    return task_.View(task_.photo.positions.front(), {}).PixelSize() * Height() /
           task_.photo.camera.principal_distance_mm;
  }

  const PhotoTask& task_;
  FoundKeypoints* found_;
  PosePrior prior_;
  bool believed_;
  double trials_;
  double ground_m_;
};

// Patches that the photo may show, whatever its kappa.
std::vector<std::size_t> KeypointSearch::PatchesAround() const {
  const PhotoView view = task_.View(task_.photo.positions.front(), prior_.pose);
  std::vector<std::size_t> around;
  for (std::size_t i = 0; i < task_.patches.size(); ++i) {
    const auto photo_mm = PhotoFromGround(view.camera, view.pose, task_.patches[i].ground_m);
    const bool far = photo_mm && (*photo_mm - view.camera.frame_centre_mm).norm() >
                                     view.camera.FrameRadius() + ReachMm(view, *photo_mm);
    if (!far || !believed_) around.push_back(i);
  }
  return around;
}

void KeypointSearch::SearchLevel(int reduction, const std::vector<int>& batches,
                                 WholePhotoSearch* search) const {
  std::vector<std::size_t> around = PatchesAround();
  for (const int patches : batches) {
    const std::vector<std::size_t> which =
        PatchesToShow(task_.patches, around, kLeastChip_px * Gsd() * reduction, patches);
    if (which.empty()) return;
    search->searched = true;
    SearchBatch(which, reduction, search);
    if (Convinces(search->track, task_.options)) return;
    std::erase_if(around, [&, sought = std::set(which.begin(), which.end())](std::size_t i) {
      return sought.count(i) > 0;
    });
  }
}

void KeypointSearch::SearchBatch(const std::vector<std::size_t>& which, int reduction,
                                 WholePhotoSearch* search) const {
  for (const bool mirrored : {false, true}) {
    const auto& positions = task_.photo.positions;
    if (std::none_of(positions.begin(), positions.end(),
                     [&](const FilmPosition& p) { return IsMirrored(p) == mirrored; }))
      continue;
    const ChipKeypoints chips =
        found_->OfChips(which, kSmallest_px * Gsd() * reduction / kScaleReach, mirrored);
    Try(found_->OfPhoto(reduction), chips, reduction, mirrored, search);
    if (Convinces(search->track, task_.options)) return;
  }
}

// How far a point may lie from where the prior's position and tilt project it, with kappa known to
// within kTurnReach_rad.
double KeypointSearch::ReachMm(const PhotoView& view, const Eigen::Vector2d& photo_mm) const {
  const Vector6d sigma = prior_.covariance.diagonal().cwiseSqrt();
  const double tilt = std::min(sigma.segment<2>(3).maxCoeff(), kUsualTilt_rad);
  const double off_axis_mm = (photo_mm - view.camera.principal_point_mm).norm();
  return kWindowSigmas * std::hypot(tilt, sigma.head<2>().maxCoeff() / Height()) *
             view.camera.principal_distance_mm +
         (kTurnReach_rad + kWindowSigmas * sigma[2] / Height()) * off_axis_mm;
}

// The approximate view, but with the kappa that follows from the rotation.
PhotoView KeypointSearch::ViewTurned(const FilmPosition& position, double turn_rad) const {
  PhotoView view = task_.View(position, prior_.pose);
  view.pose.opk_rad.z() = KappaOf(turn_rad, position);
  return view;
}

// Area of the scan in which a point may lie given the stated accuracy, with kappa known to within
// kTurnReach_rad.
double KeypointSearch::WindowPx2(const PhotoView& view, const Eigen::Vector3d& ground_m) const {
  const double whole_px2 = static_cast<double>(task_.image.Width()) * task_.image.Height();
  const auto photo_mm = PhotoFromGround(view.camera, view.pose, ground_m);
  if (!believed_ || !photo_mm) return whole_px2;
  const double reach_px = ReachMm(view, *photo_mm) / view.PixelSize();
  return std::min(whole_px2, std::numbers::pi * reach_px * reach_px);
}

void KeypointSearch::Try(const Keypoints& photo, const ChipKeypoints& chips, int reduction,
                         bool mirrored, WholePhotoSearch* search) const {
  std::vector<FilmPosition> positions;
  for (const FilmPosition& position : task_.photo.positions)
    if (IsMirrored(position) == mirrored) positions.push_back(position);
  const double sigma = std::sqrt(prior_.covariance(2, 2)) / Height();
  const double reach = std::log(kScaleReach) + std::log1p(2 * std::min(sigma, 0.5));
  PossiblePairs possible(photo, chips, Gsd(), std::exp(reach));
  if (believed_)
    for (const FilmPosition& position : positions) {
      const PhotoView view = task_.View(position, prior_.pose);
      possible.LetPassNear(
          view, position, kTurnReach_rad + kWindowSigmas * std::sqrt(prior_.covariance(5, 5)),
          [&](const Eigen::Vector2d& photo_mm) { return ReachMm(view, photo_mm); });
    }
  std::vector<Pair> pairs = AlikePairs(
      photo, chips, [&](std::size_t i) { return possible.Of(i); }, reduction);
  for (std::vector<Pair>& near : ByTurn(std::move(pairs), kTried, kFewest)) {
    BackedPairs turned{std::move(near), {}};
    turned.backing = SupportCounts(turned.pairs, photo, chips, mirrored,
                                   kApart * std::max(task_.image.Width(), task_.image.Height()));
    KeepBetter(Follow(turned, photo, chips, positions, reduction), &search->track);
    for (const FilmPosition& position : positions)
      if (!Convinces(search->track, task_.options))
        KeepBetter(FollowChips(turned, chips, position, reduction), &search->track);
    if (Convinces(search->track, task_.options)) return;
  }
}

// Per chip the pair that most others back; of these pairs, the kMostBacked most-backed.
std::vector<PlaneVote> MostBacked(const std::vector<PlaneVote>& votes,
                                  const std::vector<int>& backing) {
  std::vector<std::size_t> order(votes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return backing[a] > backing[b]; });
  std::set<std::size_t> voters;
  std::vector<PlaneVote> most;
  for (const std::size_t i : order)
    if (voters.size() < kMostBacked && voters.insert(votes[i].voter).second)
      most.push_back(votes[i]);
  return most;
}

// The pose that the chips agree on, whose candidates are the places of their middles that keypoints
// imply: less precise than keypoints, but with an informative prior few need agree.
std::optional<PoseTrack> KeypointSearch::FollowChips(const BackedPairs& turned,
                                                     const ChipKeypoints& chips,
                                                     const FilmPosition& position,
                                                     int reduction) const {
  PosePrior prior = prior_;
  const PhotoView view = ViewTurned(position, turned.pairs.front().turn_rad);
  prior.pose = view.pose;
  prior.covariance.row(5).setZero();
  prior.covariance.col(5).setZero();
  prior.covariance(5, 5) = kTurnReach_rad * kTurnReach_rad;
  std::map<std::size_t, std::size_t> voter_of;  // by chip
  std::vector<VotingPatch> voting;
  std::vector<PlaneVote> votes;  // of all pairs, in their order
  for (const Pair& pair : turned.pairs) {
    const std::size_t index = chips.chip[pair.match.first];
    const auto [voter, fresh] = voter_of.try_emplace(index, voting.size());
    if (fresh) {
      const Eigen::Vector3d& middle_m = chips.middles_m[index];
      voting.push_back({middle_m, {}, WindowPx2(view, middle_m)});
    }
    std::vector<Candidate>& candidates = voting[voter->second].candidates;
    votes.push_back({voter->second, candidates.size(), pair.middle_px});
    candidates.push_back({pair.middle_px, 1});
  }
  ConsensusOptions options;
  options.sigma_px = 1.0 + 2.0 * reduction;
  options.iterations = 5;
  options.trials = trials_;
  const std::vector<PlaneVote> likely = MostBacked(votes, turned.backing);
  const auto consensus = FindConsensus(view, prior, {voting, likely, options});
  if (!consensus) return std::nullopt;
  return Confirmed(task_, TrackOf(task_, position, *consensus, voting.size(), reduction, trials_));
}

// The pose that the keypoints agree on, if patches around it agree, too.
std::optional<PoseTrack> KeypointSearch::Follow(const BackedPairs& turned, const Keypoints& photo,
                                                const ChipKeypoints& chips,
                                                const std::vector<FilmPosition>& positions,
                                                int reduction) const {
  const PhotoView view = ViewTurned(positions.front(), turned.pairs.front().turn_rad);
  std::vector<SharedKeypoint> shared;
  double area_px2 = 0;
  for (std::size_t i = 0; i < turned.pairs.size(); ++i) {
    const Pair& pair = turned.pairs[i];
    const Eigen::Vector3d& ground_m = chips.ground_m[pair.match.first];
    shared.push_back({.pixel = photo.pixels[pair.match.second],
                      .ground_m = ground_m,
                      .lender_mm = {},
                      .weight = std::pow(1.0 + turned.backing[i], 2)});
    area_px2 += WindowPx2(view, ground_m) / static_cast<double>(turned.pairs.size());
  }
  KeypointPoseOptions options;
  options.sigma_px = 1.5 * reduction;
  options.min_supporters = kFewest;
  options.max_log10_false_alarms = 0;
  options.rival_share = 1;
  options.samples = 10000;
  options.area_px2 = area_px2;
  options.searches = static_cast<int>(trials_);
  const Eigen::Vector2i scan_px(task_.image.Width(), task_.image.Height());
  const auto found = PoseFromKeypoints(task_.photo.camera, positions, scan_px, shared, options);
  if (!found) return std::nullopt;
  const LoopRound round{static_cast<int>(shared.size()), found->supporters,
                        std::max(task_.image.Width(), task_.image.Height()) / 2.0, found->rms_px,
                        reduction};
  const PoseTrack rough{.position = positions[found->position],
                        .pose = found->pose,
                        .covariance = 4 * found->covariance,
                        .log10_false_alarms = found->log10_false_alarms,
                        .reduction = reduction,
                        .rounds = {round},
                        .trials = trials_};
  return Confirmed(task_, rough);
}

}  // namespace

double KeypointTrials(const PhotoTask& task) {
  constexpr int kPosesOfATurn = 2;
  std::size_t batches = 0;
  for (const Level& level : kLevels) batches += level.batches.size();
  const int searches = task.options.prior_failed ? 2 : 1;
  return static_cast<double>(batches) * searches * kTried * kPosesOfATurn *
         static_cast<double>(task.photo.positions.size());
}

WholePhotoSearch SearchByKeypoints(const PhotoTask& task, double ground_height_m, double trials) {
  const PosePrior& stated = task.photo.prior;
  FoundKeypoints found(task);
  WholePhotoSearch search;
  if (!task.options.prior_failed) {
    KeypointSearch(task, &found, stated, true, ground_height_m, trials).Run(&search);
    return search;
  }
  KeypointSearch(task, &found, Doubtful(stated, ground_height_m), true, ground_height_m, trials)
      .Run(&search);
  if (!Convinces(search.track, task.options))
    KeypointSearch(task, &found, Widened(stated, ground_height_m), false, ground_height_m, trials)
        .Run(&search);
  return search;
}

}  // namespace orient::exterior

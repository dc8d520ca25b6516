#include "exterior/search/attitude_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "core/geometry/rotation.h"
#include "exterior/search/search_prior.h"
#include "exterior/search/sought_patches.h"
#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {
namespace {

constexpr double kKnownPerHeight = 0.08;  // largest sigma of a known position, over the height
// Approximations are often worse than stated.
constexpr double kDoubtPerHeight = 0.03;
// Tilt, and what the steps of kappa and position leave open, make the patches' votes for the tilt
// differ by up to this, as a tangent.
constexpr double kCluster = 0.15;
// Number of the best ways whose patches are drawn again under the pose that they led to.
constexpr std::size_t kFollowed = 3;
constexpr double kMostCorrelated = 2e8;  // pixels: some 7 s of processor time

// Each candidate's vote for the tilt, as a shift in a level photo of principal distance one.
std::vector<PlaneVote> TiltVotes(const PhotoView& view, const std::vector<VotingPatch>& voting) {
  constexpr double kNearHorizon = -0.2;
  const auto level = [](const Eigen::Vector3d& direction) -> Eigen::Vector2d {
    return direction.head<2>() / -direction.z();
  };
  std::vector<PlaneVote> votes;
  for (std::size_t i = 0; i < voting.size(); ++i) {
    const Eigen::Vector3d true_direction = voting[i].ground_m - view.pose.position_m;
    if (!(true_direction.z() < kNearHorizon * true_direction.norm())) continue;
    for (std::size_t k = 0; k < voting[i].candidates.size(); ++k) {
      const auto ray = GroundRayFromPhoto(view.camera, view.pose,
                                          view.PhotoFromPixel(voting[i].candidates[k].pixel));
      if (!ray || ray->direction.z() > kNearHorizon) continue;
      votes.push_back({i, k, level(true_direction) - level(ray->direction)});
    }
  }
  return votes;
}

// The pose tilted by such a shift.
Pose Tilted(const Pose& pose, const Eigen::Vector2d& shift) {
  const Eigen::Quaterniond tilt = Eigen::Quaterniond::FromTwoVectors(
      -Eigen::Vector3d::UnitZ(), Eigen::Vector3d(shift.x(), shift.y(), -1));
  return {pose.position_m, OpkFromRotation(tilt.toRotationMatrix() * pose.GroundFromPhoto())};
}

// Factors on the height: 1 alone if the position is known, otherwise others as well.
std::vector<double> HeightsToTry(const PhotoTask& task, double ground_m) {
  if (IsPositionKnown(task.photo.prior, ground_m)) return {1};
  return HeightFactors(task.photo.prior, ground_m);
}

class AttitudeSearch {
 public:
  AttitudeSearch(const PhotoTask& task, double ground_m, const SoughtPatches& sought,
                 const Pose& approximate, double trials, SearchBudget* budget)
      : task_(task),
        ground_m_(ground_m),
        sought_(sought),
        wide_(WideOf(task, ground_m, approximate)),
        budget_(budget) {
    options_.sigma_px = 0.5 + 0.6 * sought.Reduction();
    options_.samples = 1000;
    options_.iterations = 5;
    options_.trials = trials;
  }
  std::optional<PoseTrack> Run();

 private:
  struct Way {
    const FilmPosition* position = nullptr;
    double kappa_rad = 0;
    double height_m = 0;  // above the ground
  };
  PhotoView ViewOf(const Way& way) const;
  Look LookOf(const Way& way) const;
  static PosePrior WideOf(const PhotoTask& task, double ground_m, const Pose& approximate);
  std::vector<Way> Ways() const;
  const std::vector<VotingPatch>& Sought(const Way& way, const PhotoView& view);
  std::optional<PoseTrack> TryFirst(const Way& way);
  std::optional<PoseTrack> TryAgain(const Way& way, const PoseTrack& track) const;
  std::optional<PoseTrack> TryAs(const Way& way, const PhotoView& drawn_under,
                                 const std::vector<VotingPatch>& voting) const;

  const PhotoTask& task_;
  double ground_m_;
  const SoughtPatches& sought_;
  PosePrior wide_;
  SearchBudget* budget_;
  ConsensusOptions options_;
  std::map<Look, std::vector<VotingPatch>> found_;
};

// A prior with any tilt that aerial photos have, and the position as far as it is known.
PosePrior AttitudeSearch::WideOf(const PhotoTask& task, double ground_m, const Pose& approximate) {
  const double height = approximate.position_m.z() - ground_m;
  PosePrior wide = Widened({approximate, task.photo.prior.covariance}, ground_m);
  if (IsPositionKnown(task.photo.prior, ground_m))
    wide.covariance.topLeftCorner<3, 3>() =
        Eigen::Matrix3d(task.photo.prior.covariance.diagonal().head<3>().asDiagonal()) +
        std::pow(kDoubtPerHeight * height, 2) * Eigen::Matrix3d::Identity();
  else
    wide.covariance(2, 2) = std::pow((kHeightStep - 1) * height, 2);
  return wide;
}

// All ways, the most likely first.
std::vector<AttitudeSearch::Way> AttitudeSearch::Ways() const {
  std::vector<Way> ways;
  for (const double factor : HeightsToTry(task_, ground_m_))
    for (int k = 0; k < kKappas; ++k)
      for (const FilmPosition& position : task_.photo.positions)
        ways.push_back({&position, wide_.pose.opk_rad.z() + Outwards(k) * kKappaStep_rad,
                        factor * (wide_.pose.position_m.z() - ground_m_)});
  const Matrix6d& stated = task_.photo.prior.covariance;
  const double height = wide_.pose.position_m.z() - ground_m_;
  const auto unlikely = [&](const Way& way) {
    return std::pow(way.kappa_rad - wide_.pose.opk_rad.z(), 2) /
               (stated(5, 5) + kKappaStep_rad * kKappaStep_rad) +
           std::pow(way.height_m - height, 2) /
               (stated(2, 2) + std::pow((kHeightStep - 1) * height, 2));
  };
  std::stable_sort(ways.begin(), ways.end(),
                   [&](const Way& a, const Way& b) { return unlikely(a) < unlikely(b); });
  return ways;
}

PhotoView AttitudeSearch::ViewOf(const Way& way) const {
  PhotoView view = task_.View(*way.position, wide_.pose);
  view.pose.opk_rad.z() = way.kappa_rad;
  view.pose.position_m.z() = ground_m_ + way.height_m;
  return view;
}

Look AttitudeSearch::LookOf(const Way& way) const {
  const double size = (wide_.pose.position_m.z() - ground_m_) / way.height_m;  // lower: larger
  return exterior::LookOf(*way.position, way.kappa_rad, size);
}

const std::vector<VotingPatch>& AttitudeSearch::Sought(const Way& way, const PhotoView& view) {
  const Look look = LookOf(way);
  const auto known = found_.find(look);
  if (known != found_.end()) return known->second;
  std::vector<VotingPatch> voting = sought_.Seek(view, wide_);
  budget_->Spend(voting, sought_.Reduction());
  return found_.emplace(look, std::move(voting)).first->second;
}

std::optional<PoseTrack> AttitudeSearch::TryFirst(const Way& way) {
  const PhotoView view = ViewOf(way);
  return TryAs(way, view, Sought(way, view));
}

std::optional<PoseTrack> AttitudeSearch::TryAs(const Way& way, const PhotoView& drawn_under,
                                               const std::vector<VotingPatch>& voting) const {
  PhotoView view = drawn_under;
  const std::vector<PlaneVote> cluster = LargestCluster(TiltVotes(view, voting), kCluster);
  if (cluster.empty()) return std::nullopt;
  view.pose = Tilted(view.pose, MeanOf(cluster));
  PosePrior prior = wide_;
  prior.pose.opk_rad.z() = way.kappa_rad;
  prior.pose.position_m.z() = ground_m_ + way.height_m;
  prior.covariance(5, 5) = kKappaStep_rad * kKappaStep_rad;
  const auto consensus = FindConsensus(view, prior, {voting, cluster, options_});
  if (!consensus) return std::nullopt;
  return TrackOf(task_, *way.position, *consensus, voting.size(), sought_.Reduction(),
                 options_.trials);
}

std::optional<PoseTrack> AttitudeSearch::TryAgain(const Way& way, const PoseTrack& track) const {
  const PhotoView view = task_.View(track.position, track.pose);
  return TryAs(way, view, sought_.Seek(view, wide_));
}

std::optional<PoseTrack> AttitudeSearch::Run() {
  const std::vector<Way> ways = Ways();
  WaysToTry to_try;
  to_try.count = ways.size();
  to_try.look = [&](std::size_t i) { return LookOf(ways[i]); };
  to_try.first = [&](std::size_t i) { return TryFirst(ways[i]); };
  to_try.again = [&](std::size_t i, const PoseTrack& track) { return TryAgain(ways[i], track); };
  to_try.followed = kFollowed;
  to_try.max_log10_false_alarms = task_.options.max_log10_false_alarms;
  to_try.budget = budget_;
  return TryWays(to_try);
}

// Poses to draw the patches under. Aerial photos look down to within some degrees, which says more
// about the tilt than a less certain approximation; as it stands, this comes second, for obliques.
std::vector<Pose> ApproximatePoses(const PosePrior& prior) {
  const double usual = kUsualTilt_rad * kUsualTilt_rad;
  const double stated = prior.covariance.diagonal().segment<2>(3).maxCoeff();
  const Eigen::Vector2d tilt = prior.pose.opk_rad.head<2>();
  if (tilt.norm() * stated / (usual + stated) < kCluster / 2) return {prior.pose};
  Pose down = prior.pose;
  down.opk_rad.head<2>() *= usual / (usual + stated);
  return {down, prior.pose};
}

}  // namespace

bool IsPositionKnown(const PosePrior& prior, double ground_height_m) {
  const double height = prior.pose.position_m.z() - ground_height_m;
  return height > 0 &&
         std::sqrt(prior.covariance.diagonal().head<3>().maxCoeff()) <= kKnownPerHeight * height;
}

double AttitudeTrials(const PhotoTask& task, double ground_height_m) {
  const double ways = static_cast<double>(HeightsToTry(task, ground_height_m).size() * kKappas *
                                          task.photo.positions.size());
  return static_cast<double>(ApproximatePoses(task.photo.prior).size()) *
         (ways + static_cast<double>(kFollowed) * kFollowedRounds);
}

WholePhotoSearch SearchAttitudes(const PhotoTask& task, double ground_height_m, double trials) {
  WholePhotoSearch search;
  SearchBudget budget(kMostCorrelated);
  std::optional<PoseTrack>& best = search.track;
  std::shared_ptr<const PhotoLevel> level;
  for (const Pose& approximate : ApproximatePoses(task.photo.prior)) {
    if (budget.Spent()) break;
    const auto sought = SoughtPatches::Of(task, ground_height_m, approximate, &level);
    if (!sought) continue;
    search.searched = true;
    KeepBetter(AttitudeSearch(task, ground_height_m, *sought, approximate, trials, &budget).Run(),
               &best);
    if (Convinces(best, task.options)) break;
  }
  search.complete = !budget.Spent();
  return search;
}

}  // namespace orient::exterior

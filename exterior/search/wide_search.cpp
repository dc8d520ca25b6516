#include "exterior/search/wide_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "exterior/search/first_pose.h"
#include "exterior/search/keypoint_search.h"
#include "exterior/search/mosaic_tiles.h"
#include "exterior/search/search_prior.h"
#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {
namespace {

// Tilt and the remainders of the steps in kappa and scale displace a photo's tiles relative to one
// another by up to this share of the flying height.
constexpr double kClusterPerHeight = 0.15;

// Best hypotheses followed up per scale: drawn under the pose that a few tiles agree on, the others
// look more like the photo, and that pose may have another scale.
constexpr std::size_t kFollowed = 2;
constexpr double kMostCorrelated = 1e8;  // pixels: some 3 s of processor time

// One way the photo may have been taken.
struct Hypothesis {
  const FilmPosition* position = nullptr;
  Pose pose;
  double height_m = 0;  // above the ground
};

// Transforms an offset in the scan, pixels, to one on level ground, metres.
Eigen::Matrix2d GroundFromScan(const PhotoTask& task, const Hypothesis& hypothesis) {
  const double scale = hypothesis.height_m / task.photo.camera.principal_distance_mm;
  return scale * Eigen::Rotation2Dd(hypothesis.pose.opk_rad.z()).toRotationMatrix() *
         hypothesis.position->photo_from_pixel.A;
}

double GsdOf(const PhotoTask& task, const Hypothesis& hypothesis) {
  return std::sqrt(std::abs(GroundFromScan(task, hypothesis).determinant()));
}

// All kappas, outwards from the approximate one, at each scale before those at the next.
std::vector<Hypothesis> Hypotheses(const PhotoTask& task, const PosePrior& wide, double ground_m) {
  const double height = wide.pose.position_m.z() - ground_m;
  std::vector<Hypothesis> hypotheses;
  for (const double factor : HeightFactors(wide, ground_m))
    for (int k = 0; k < kKappas; ++k)
      for (const FilmPosition& position : task.photo.positions) {
        Hypothesis hypothesis{&position, wide.pose, height * factor};
        hypothesis.pose.opk_rad.z() += Outwards(k) * kKappaStep_rad;
        hypothesis.pose.position_m.z() = ground_m + hypothesis.height_m;
        hypotheses.push_back(hypothesis);
      }
  return hypotheses;
}

// Positions of the camera, m, each if its candidate is right and the attitude is the hypothesis'.
std::vector<PlaneVote> Votes(const PhotoView& view, const std::vector<VotingPatch>& voting) {
  std::vector<PlaneVote> votes;
  for (std::size_t i = 0; i < voting.size(); ++i)
    for (std::size_t k = 0; k < voting[i].candidates.size(); ++k) {
      const auto ray = GroundRayFromPhoto(view.camera, view.pose,
                                          view.PhotoFromPixel(voting[i].candidates[k].pixel));
      if (!ray || ray->direction.z() > -0.1) continue;
      const double drop = (voting[i].ground_m.z() - view.pose.position_m.z()) / ray->direction.z();
      votes.push_back({i, k, voting[i].ground_m.head<2>() - drop * ray->direction.head<2>()});
    }
  return votes;
}

// d ground / d scan, metres per pixel, at a ground point under a pose; empty if it is not seen.
std::optional<Eigen::Matrix2d> GroundFromScanAt(const PhotoView& view,
                                                const Eigen::Vector3d& ground_m) {
  const auto projection = PhotoFromGroundWithDerivatives(view.camera, view.pose, ground_m);
  if (!projection || !view.camera.InFrame(projection->photo_mm, view.camera.FrameRadius() / 4))
    return std::nullopt;
  const Eigen::Matrix2d scan_from_ground =
      view.photo_from_pixel.Inverse().A * projection->by_ground.leftCols<2>();
  return Eigen::Matrix2d(scan_from_ground.inverse());
}

class WideSearch {
 public:
  // `other_trials`: number of ways in which a first pose was searched for before.
  WideSearch(const PhotoTask& task, PosePrior wide, double ground_m, double other_trials)
      : task_(task),
        other_trials_(other_trials),
        wide_(std::move(wide)),
        hypotheses_(Hypotheses(task, wide_, ground_m)) {}

  WholePhotoSearch Run();
  double Trials() const {  // of this search and those before
    return other_trials_ +
           static_cast<double>((1 + kFollowed * kFollowedRounds) * hypotheses_.size());
  }

 private:
  std::optional<PoseTrack> TryAll(const std::vector<Hypothesis>& hypotheses);
  Look LookOf(const Hypothesis& hypothesis) const;
  const std::vector<VotingPatch>& Sought(const Hypothesis& hypothesis);
  PosePrior PriorOf(const Hypothesis& hypothesis) const;
  std::optional<PoseTrack> TryAs(const Hypothesis& hypothesis);
  std::optional<PoseTrack> TryAgain(const Hypothesis& hypothesis, const PoseTrack& track) const;
  ConsensusOptions Options() const;

  const PhotoTask& task_;
  double other_trials_;
  PosePrior wide_;
  std::vector<Hypothesis> hypotheses_;
  std::optional<MosaicTiles> tiles_;
  SearchBudget budget_{kMostCorrelated};
  std::map<Look, std::vector<VotingPatch>> sought_;
};

WholePhotoSearch WideSearch::Run() {
  tiles_ = MosaicTiles::Of(task_.patches, task_.image, GsdOf(task_, hypotheses_.front()),
                           wide_.pose.position_m.head<2>());
  if (!tiles_) return {};
  WholePhotoSearch search;
  search.searched = true;
  std::optional<PoseTrack>& best = search.track;
  for (auto first = hypotheses_.begin(); first != hypotheses_.end();) {
    const auto end = std::find_if(first, hypotheses_.end(), [&](const Hypothesis& hypothesis) {
      return hypothesis.height_m != first->height_m;
    });
    KeepBetter(TryAll({first, end}), &best);
    if (Convinces(best, task_.options) || budget_.Spent()) break;
    first = end;
  }
  search.complete = !budget_.Spent();
  return search;
}

std::optional<PoseTrack> WideSearch::TryAll(const std::vector<Hypothesis>& hypotheses) {
  WaysToTry to_try;
  to_try.count = hypotheses.size();
  to_try.look = [&](std::size_t i) { return LookOf(hypotheses[i]); };
  to_try.first = [&](std::size_t i) { return TryAs(hypotheses[i]); };
  to_try.again = [&](std::size_t i, const PoseTrack& track) {
    return TryAgain(hypotheses[i], track);
  };
  to_try.followed = kFollowed;
  to_try.max_log10_false_alarms = task_.options.max_log10_false_alarms;
  to_try.budget = &budget_;
  return TryWays(to_try);
}

ConsensusOptions WideSearch::Options() const {
  ConsensusOptions options;
  options.sigma_px = 0.5 + 0.6 * tiles_->Reduction();
  options.samples = 1000;
  options.iterations = 5;
  options.trials = Trials();
  return options;
}

// Matrix elements in hundredths of the GSD, and the flying height in whole metres.
Look WideSearch::LookOf(const Hypothesis& hypothesis) const {
  const Eigen::Matrix2d shape = GroundFromScan(task_, hypothesis);
  const double unit = 0.01 * GsdOf(task_, hypothesis);
  return {std::lround(shape(0, 0) / unit), std::lround(shape(0, 1) / unit),
          std::lround(shape(1, 0) / unit), std::lround(hypothesis.height_m)};
}

const std::vector<VotingPatch>& WideSearch::Sought(const Hypothesis& hypothesis) {
  const Look look = LookOf(hypothesis);
  const auto known = sought_.find(look);
  if (known != sought_.end()) return known->second;
  const Eigen::Matrix2d shape = GroundFromScan(task_, hypothesis);
  auto voting = tiles_->Seek([&](const Eigen::Vector3d&) { return shape; });
  budget_.Spend(voting, tiles_->Reduction());
  return sought_.emplace(look, std::move(voting)).first->second;
}

// The hypothesis represents all poses within its steps of kappa and scale.
PosePrior WideSearch::PriorOf(const Hypothesis& hypothesis) const {
  PosePrior prior{hypothesis.pose, wide_.covariance};
  prior.covariance(2, 2) = std::pow((kHeightStep - 1) * hypothesis.height_m, 2);
  prior.covariance(5, 5) = kKappaStep_rad * kKappaStep_rad;
  return prior;
}

std::optional<PoseTrack> WideSearch::TryAs(const Hypothesis& hypothesis) {
  const std::vector<VotingPatch>& voting = Sought(hypothesis);
  PhotoView view = task_.View(*hypothesis.position, hypothesis.pose);
  const std::vector<PlaneVote> cluster =
      LargestCluster(Votes(view, voting), kClusterPerHeight * hypothesis.height_m);
  if (cluster.empty()) return std::nullopt;
  view.pose.position_m.head<2>() = MeanOf(cluster);
  const ConsensusOptions options = Options();
  const auto consensus = FindConsensus(view, PriorOf(hypothesis), {voting, cluster, options});
  if (!consensus) return std::nullopt;
  return TrackOf(task_, *hypothesis.position, *consensus, tiles_->Count(), tiles_->Reduction(),
                 options.trials);
}

std::optional<PoseTrack> WideSearch::TryAgain(const Hypothesis& hypothesis,
                                              const PoseTrack& track) const {
  const PhotoView view = task_.View(track.position, track.pose);
  const Eigen::Matrix2d elsewhere = GroundFromScan(task_, hypothesis);
  const auto voting = tiles_->Seek([&](const Eigen::Vector3d& ground_m) {
    return GroundFromScanAt(view, ground_m).value_or(elsewhere);
  });
  ConsensusOptions options = Options();
  options.sigma_px = 0.5 + 0.4 * tiles_->Reduction();
  options.samples = 3000;
  const auto consensus = FindConsensus(view, PriorOf(hypothesis), voting, options);
  if (!consensus) return std::nullopt;
  return TrackOf(task_, *hypothesis.position, *consensus, tiles_->Count(), tiles_->Reduction(),
                 options.trials);
}

WholePhotoSearch SearchAtEveryKappa(const PhotoTask& task) {
  const double ground_m = MedianGroundHeight(task.patches);
  if (!(task.photo.prior.pose.position_m.z() > ground_m)) return {};
  const bool known = IsPositionKnown(task.photo.prior, ground_m);
  WideSearch places(task, Widened(task.photo.prior, ground_m), ground_m,
                    KeypointTrials(task) + (known ? KappaTrials(task) : 0));
  WholePhotoSearch search = SearchByKeypoints(task, ground_m, places.Trials());
  if (Convinces(search.track, task.options)) return search;
  const bool trusted = known && !task.options.prior_failed;
  if (!trusted) search.Add(places.Run());
  if (!known || Convinces(search.track, task.options)) return search;
  // With a window for each patch, fewer patches than in the other searches show the pose. If the
  // position is truly known, this shows more than tiles do, unless all windows are too large.
  WholePhotoSearch in_sectors = FirstPoseByKappa(task, places.Trials());
  const bool searched = in_sectors.searched;
  search.Add(std::move(in_sectors));
  if (trusted && !searched) search.Add(places.Run());
  return search;
}

}  // namespace

WholePhotoSearch SearchWidely(const PhotoTask& task) {
  WholePhotoSearch search = SearchAtEveryKappa(task);
  if (search.track)
    LetPriorDecidePosition(task.photo.positions, task.photo.prior, &search.track->position,
                           &search.track->pose);
  return search;
}

}  // namespace orient::exterior

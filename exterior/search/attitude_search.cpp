#include "exterior/search/attitude_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/base/side_by_side.h"
#include "core/geometry/rotation.h"
#include "core/matching/correlation.h"
#include "core/matching/image_correlator.h"
#include "exterior/search/search_prior.h"
#include "exterior/search/whole_photo_search.h"
#include "exterior/steps/align.h"

namespace orient::exterior {
namespace {

constexpr double kKnownPerHeight = 0.08;  // one sigma of the position
// Approximations are often worse than they are said to be.
constexpr double kDoubtPerHeight = 0.03;
constexpr int kPatches = 60;
constexpr int kSide = 13;             // of a drawn patch, pixels of the level
constexpr double kMaxPixels = 1.5e6;  // of a level that is searched whole
// Tilt, and what the step of kappa and the position leave, move what the patches say of the tilt
// against one another by up to this, as a tangent.
constexpr double kCluster = 0.15;
constexpr int kMaxCandidates = 4;      // of a patch
constexpr double kMinScore = 0.3;      // of a candidate
constexpr double kPeakDistance = 2.5;  // pixels of the level
// The best are drawn again under the pose that they led to.
constexpr std::size_t kFollowed = 3;

// Level and patches of one search; the patches are drawn in one size.
class SoughtPatches {
 public:
  static std::optional<SoughtPatches> Of(const PhotoTask& task, const Pose& approximate);

  int Reduction() const { return reduction_; }
  // One per patch, its candidates anywhere in the photo; drawn as seen under a pose.
  std::vector<VotingPatch> Seek(const PhotoView& view) const;

 private:
  SoughtPatches(const PhotoTask& task, std::vector<std::size_t> patches, int reduction,
                ImageWindow photo)
      : task_(task),
        patches_(std::move(patches)),
        reduction_(reduction),
        photo_(std::move(photo)),
        search_(photo_.image, kSide) {}

  const PhotoTask& task_;
  std::vector<std::size_t> patches_;
  int reduction_;
  ImageWindow photo_;
  ChannelCorrelator search_;
};

// The lens' inverse need not exist as far outside the frame as patches may be drawn.
PhotoView WithoutLens(PhotoView view) {
  view.camera.lens = {};
  view.film_correction = nullptr;
  return view;
}

// Spread over what the photo may show, whichever way it is turned.
std::vector<std::size_t> PatchesAround(const PhotoTask& task, const PhotoView& view) {
  std::vector<PatchPrediction> around;
  const Camera& camera = view.camera;
  for (std::size_t i = 0; i < task.patches.size(); ++i) {
    const auto photo = PhotoFromGround(camera, view.pose, task.patches[i].ground_m);
    if (!photo || (*photo - camera.frame_centre_mm).norm() > camera.FrameRadius()) continue;
    around.push_back({i, view.PixelFromPhoto(*photo), Eigen::Matrix2d::Zero()});
  }
  std::vector<std::size_t> chosen;
  for (const PatchPrediction& p : SelectSpread(around, task.patches, kPatches, task.Prediction()))
    chosen.push_back(p.patch);
  return chosen;
}

std::optional<SoughtPatches> SoughtPatches::Of(const PhotoTask& task, const Pose& approximate) {
  const PhotoView view = WithoutLens(task.View(task.photo.positions.front(), approximate));
  std::vector<std::size_t> patches = PatchesAround(task, view);
  std::vector<double> sides;
  for (const std::size_t i : patches)
    if (const auto of = PatchSide(view, task.patches[i])) sides.push_back(*of);
  if (sides.empty()) return std::nullopt;
  // Most of them, for the smallest are too small.
  const auto small = sides.begin() + static_cast<std::ptrdiff_t>(sides.size() / 4);
  std::nth_element(sides.begin(), small, sides.end());
  const int reduction = static_cast<int>(*small / kSide);
  const Eigen::Vector2d size(task.image.Width(), task.image.Height());
  if (reduction < 1 || size.prod() > kMaxPixels * reduction * reduction ||
      size.minCoeff() < 2.0 * kSide * reduction)
    return std::nullopt;
  return SoughtPatches(task, std::move(patches), reduction,
                       task.image.Around(size / 2, size / 2, reduction));
}

std::vector<VotingPatch> SoughtPatches::Seek(const PhotoView& view) const {
  std::vector<VotingPatch> voting(patches_.size());
  SideBySide(voting.size(), [&](std::size_t i) {
    const patchdb::Patch& patch = task_.patches[patches_[i]];
    voting[i].ground_m = patch.ground_m;
    const auto aligned = AlignPatch(view, patch, reduction_, kSide, kSide);
    if (!aligned) return;
    const Image scores = search_.Scores(aligned->image);
    const auto places = std::count_if(scores.values.begin(), scores.values.end(),
                                      [](float score) { return !std::isnan(score); });
    voting[i].window_px2 = static_cast<double>(places) * reduction_ * reduction_;
    for (const Peak& peak : FindPeaks(scores, kMaxCandidates, kPeakDistance, kMinScore))
      voting[i].candidates.push_back(
          {photo_.RasterFromImage(peak.position + aligned->Centre()), peak.score});
  });
  return voting;
}

// What each candidate says of the tilt, as a shift in a level photo of principal distance one.
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

class AttitudeSearch {
 public:
  AttitudeSearch(const PhotoTask& task, const SoughtPatches& sought, const Pose& approximate,
                 double trials)
      : task_(task), sought_(sought), wide_(WideOf(task, approximate)) {
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
  };
  Look LookOf(const Way& way) const;
  static PosePrior WideOf(const PhotoTask& task, const Pose& approximate);
  std::vector<Way> Ways() const;
  const std::vector<VotingPatch>& Sought(const Way& way, const PhotoView& view);
  std::optional<PoseTrack> TryFirst(const Way& way);
  std::optional<PoseTrack> TryAgain(const Way& way, const PoseTrack& track) const;
  std::optional<PoseTrack> TryAs(const Way& way, const PhotoView& drawn_under,
                                 const std::vector<VotingPatch>& voting) const;

  const PhotoTask& task_;
  const SoughtPatches& sought_;
  PosePrior wide_;
  ConsensusOptions options_;
  std::map<Look, std::vector<VotingPatch>> found_;
};

// Any tilt that aerial photos have, at the position that is known.
PosePrior AttitudeSearch::WideOf(const PhotoTask& task, const Pose& approximate) {
  const double ground_m = MedianGroundHeight(task.patches);
  const double height = approximate.position_m.z() - ground_m;
  PosePrior wide = Widened({approximate, task.photo.prior.covariance}, ground_m);
  wide.covariance.topLeftCorner<3, 3>() =
      Eigen::Matrix3d(task.photo.prior.covariance.diagonal().head<3>().asDiagonal()) +
      std::pow(kDoubtPerHeight * height, 2) * Eigen::Matrix3d::Identity();
  return wide;
}

// Outwards from the approximate kappa.
std::vector<AttitudeSearch::Way> AttitudeSearch::Ways() const {
  std::vector<Way> ways;
  for (int k = 0; k < kKappas; ++k)
    for (const FilmPosition& position : task_.photo.positions)
      ways.push_back({&position, wide_.pose.opk_rad.z() + Outwards(k) * kKappaStep_rad});
  return ways;
}

// In hundredths.
Look AttitudeSearch::LookOf(const Way& way) const {
  const PhotoView view = task_.View(*way.position, wide_.pose);
  const Eigen::Matrix2d shape = Eigen::Rotation2Dd(way.kappa_rad).toRotationMatrix() *
                                way.position->photo_from_pixel.A / view.PixelSize();
  Look look{};
  for (int i = 0; i < 4; ++i) look[static_cast<std::size_t>(i)] = std::lround(100 * shape(i));
  return look;
}

const std::vector<VotingPatch>& AttitudeSearch::Sought(const Way& way, const PhotoView& view) {
  const Look look = LookOf(way);
  const auto known = found_.find(look);
  if (known != found_.end()) return known->second;
  return found_.emplace(look, sought_.Seek(WithoutLens(view))).first->second;
}

std::optional<PoseTrack> AttitudeSearch::TryFirst(const Way& way) {
  PhotoView view = task_.View(*way.position, wide_.pose);
  view.pose.opk_rad.z() = way.kappa_rad;
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
  prior.covariance(5, 5) = kKappaStep_rad * kKappaStep_rad;
  const auto consensus = FindConsensus(view, prior, {voting, cluster, options_});
  if (!consensus) return std::nullopt;
  return TrackOf(task_, *way.position, *consensus, voting.size(), sought_.Reduction(),
                 options_.trials);
}

std::optional<PoseTrack> AttitudeSearch::TryAgain(const Way& way, const PoseTrack& track) const {
  const PhotoView view = task_.View(track.position, track.pose);
  return TryAs(way, view, sought_.Seek(WithoutLens(view)));
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
  return TryWays(to_try);
}

// Where the patches are drawn. Aerial photos look down but for some degrees: an approximation that
// is less certain says less of the tilt than this does. As it stands it comes second, for obliques.
std::vector<Pose> ApproximatePoses(const PosePrior& prior) {
  constexpr double kUsualTilt_rad = 5 * std::numbers::pi / 180;
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

double AttitudeTrials(const PhotoTask& task) {
  const double ways = kKappas * static_cast<double>(task.photo.positions.size());
  return static_cast<double>(ApproximatePoses(task.photo.prior).size()) *
         (ways + static_cast<double>(kFollowed) * kFollowedRounds);
}

std::optional<PoseTrack> SearchAttitudes(const PhotoTask& task, double trials) {
  std::optional<PoseTrack> best;
  for (const Pose& approximate : ApproximatePoses(task.photo.prior)) {
    const auto sought = SoughtPatches::Of(task, approximate);
    if (!sought) continue;
    auto found = AttitudeSearch(task, *sought, approximate, trials).Run();
    if (found && (!best || found->log10_false_alarms < best->log10_false_alarms))
      best = std::move(found);
    if (best && best->log10_false_alarms < task.options.max_log10_false_alarms) break;
  }
  return best;
}

}  // namespace orient::exterior

#include "exterior/search/whole_photo_search.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/median.h"
#include "core/geometry/rotation.h"

namespace orient::exterior {
namespace {

struct Try {
  std::size_t way = 0;
  PoseTrack track;
};

bool Convinces(const WaysToTry& ways, const PoseTrack& track) {
  return track.log10_false_alarms < ways.max_log10_false_alarms;
}

// Rotation between the film positions of two transforms of the scan; empty if one is mirrored
// relative to the other.
std::optional<double> TurnBetween(const Affine2d& from, const Affine2d& to) {
  const Eigen::Matrix2d turn = to.A * from.A.inverse();
  if (turn.determinant() < 0) return std::nullopt;
  return std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
}

PoseTrack FollowUp(const WaysToTry& ways, Try from) {
  for (int round = 0; round < kFollowedRounds && !Convinces(ways, from.track); ++round) {
    auto again = ways.again(from.way, from.track);
    if (again && IsBetter(*again, from.track)) from.track = std::move(*again);
  }
  return std::move(from.track);
}

}  // namespace

Look LookOf(const FilmPosition& position, double kappa_rad) {
  const Eigen::Matrix2d& A = position.photo_from_pixel.A;
  const Eigen::Matrix2d shape =
      Eigen::Rotation2Dd(kappa_rad).toRotationMatrix() * A / std::sqrt(std::abs(A.determinant()));
  Look look{};
  for (int i = 0; i < 4; ++i) look[static_cast<std::size_t>(i)] = std::lround(100 * shape(i));
  return look;
}

double MedianGroundHeight(const std::vector<patchdb::Patch>& patches) {
  std::vector<double> heights;
  for (const patchdb::Patch& patch : patches) heights.push_back(patch.ground_m.z());
  return UpperMedian(std::move(heights));
}

void KeepBetter(std::optional<PoseTrack> track, std::optional<PoseTrack>* best) {
  if (track && (!*best || IsBetter(*track, **best))) *best = std::move(track);
}

void WholePhotoSearch::Add(WholePhotoSearch another) {
  KeepBetter(std::move(another.track), &track);
  searched |= another.searched;
  complete &= another.complete;
}

void SearchBudget::Spend(const std::vector<VotingPatch>& sought, int reduction) {
  for (const VotingPatch& patch : sought) left_ -= patch.window_px2 / (reduction * reduction);
}

namespace {

// Difference in chi-square above which the prior decides between two kappas.
constexpr double kClearly_chi2 = 9;

double Chi2OfKappa(const PosePrior& prior, double kappa_rad) {
  const double off_rad = NormalizeAngle(kappa_rad - prior.pose.opk_rad.z());
  return off_rad * off_rad / prior.covariance(5, 5);
}

}  // namespace

void LetPriorDecidePosition(const std::vector<FilmPosition>& positions, const PosePrior& prior,
                            FilmPosition* position, Pose* pose) {
  const double kappa_rad = pose->opk_rad.z();
  const Affine2d found = position->photo_from_pixel;
  double least_chi2 = Chi2OfKappa(prior, kappa_rad) - kClearly_chi2;
  for (const FilmPosition& other : positions) {
    // kappa is the innermost rotation: about the camera's own axis.
    const auto turn_rad = TurnBetween(found, other.photo_from_pixel);
    if (!turn_rad) continue;
    const double chi2 = Chi2OfKappa(prior, kappa_rad - *turn_rad);
    if (chi2 >= least_chi2) continue;
    least_chi2 = chi2;
    *position = other;
    pose->opk_rad.z() = NormalizeAngle(kappa_rad - *turn_rad);
  }
}

int EquallyLikelyPositions(const PhotoToOrient& photo, const FilmPosition& position,
                           double kappa_rad) {
  const double chi2 = Chi2OfKappa(photo.prior, kappa_rad);
  return static_cast<int>(
      std::count_if(photo.positions.begin(), photo.positions.end(), [&](const FilmPosition& one) {
        const auto turn_rad = TurnBetween(position.photo_from_pixel, one.photo_from_pixel);
        return turn_rad && Chi2OfKappa(photo.prior, kappa_rad - *turn_rad) < chi2 + kClearly_chi2;
      }));
}

std::optional<PoseTrack> TryWays(const WaysToTry& ways) {
  std::vector<Try> tries;
  for (std::size_t way = 0; way < ways.count && !ways.budget->Spent(); ++way) {
    auto track = ways.first(way);
    if (!track) continue;
    if (Convinces(ways, *track)) return track;
    tries.push_back({way, std::move(*track)});
  }
  std::stable_sort(tries.begin(), tries.end(),
                   [](const Try& a, const Try& b) { return IsBetter(a.track, b.track); });
  std::optional<PoseTrack> best;
  std::set<Look> followed;
  for (std::size_t i = 0; i < tries.size() && followed.size() < ways.followed; ++i) {
    if (!followed.insert(ways.look(tries[i].way)).second) continue;
    KeepBetter(FollowUp(ways, std::move(tries[i])), &best);
    if (Convinces(ways, *best)) break;
  }
  return best;
}

std::optional<Consensus> FindConsensus(const PhotoView& view, const PosePrior& prior,
                                       const ClusterConsensus& of) {
  std::vector<VotingPatch> agreeing = of.voting;
  for (VotingPatch& patch : agreeing) patch.candidates.clear();
  for (const PlaneVote& vote : of.cluster)
    agreeing[vote.voter].candidates.push_back(of.voting[vote.voter].candidates[vote.candidate]);
  auto consensus = FindConsensus(view, prior, agreeing, of.options);
  if (consensus)
    consensus->log10_false_alarms = Log10FalseAlarms(of.voting, consensus->supporters, of.options);
  return consensus;
}

PoseTrack TrackOf(const PhotoTask& task, const FilmPosition& position, const Consensus& consensus,
                  std::size_t sought, int reduction, double trials) {
  const LoopRound round{static_cast<int>(sought), static_cast<int>(consensus.supporters.size()),
                        std::max(task.image.Width(), task.image.Height()) / 2.0, consensus.rms_px,
                        reduction};
  return {position, consensus.pose, consensus.covariance, consensus.log10_false_alarms, reduction,
          {round},  trials};
}

}  // namespace orient::exterior

#include "exterior/search/attitude_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/base/side_by_side.h"
#include "core/geometry/rotation.h"
#include "exterior/search/photo_level.h"
#include "exterior/search/search_prior.h"
#include "exterior/search/whole_photo_search.h"
#include "exterior/steps/align.h"

namespace orient::exterior {
namespace {

constexpr double kKnownPerHeight = 0.08;  // one sigma of the position
// Approximations are often worse than they are said to be.
constexpr double kDoubtPerHeight = 0.03;
constexpr std::size_t kPatches = 60;
constexpr double kCells = 8;        // along the photo's longer side, with about one of them each
constexpr std::size_t kFewest = 4;  // of them
constexpr double kMostTurned_rad = 1.2;  // beyond, anywhere in the photo
// Of a drawn patch, pixels of the level: with fewer it resembles too much.
constexpr int kLeastSide = 13;
constexpr int kMostSide = 19;
constexpr double kMaxPixels = 6e6;  // of a level that is searched whole
// Tilt, and what the step of kappa and the position leave, move what the patches say of the tilt
// against one another by up to this, as a tangent.
constexpr double kCluster = 0.15;
constexpr int kMaxCandidates = 4;  // of a patch
constexpr double kMinScore = 0.3;  // of a candidate
// The best are drawn again under the pose that they led to.
constexpr std::size_t kFollowed = 3;

// Level and patches of one search; the patches are drawn in one size.
class SoughtPatches {
 public:
  static std::optional<SoughtPatches> Of(const PhotoTask& task, double ground_m,
                                         const Pose& approximate);

  int Reduction() const { return level_.Reduction(); }
  // One per patch, its candidates where a camera may see it whose pose is the prior's but for what
  // the steps of kappa and height leave; drawn as seen under a view.
  std::vector<VotingPatch> Seek(const PhotoView& view, const PosePrior& prior) const;

 private:
  SoughtPatches(const PhotoTask& task, double ground_m, std::vector<std::size_t> patches,
                PhotoLevel level)
      : task_(task), ground_m_(ground_m), patches_(std::move(patches)), level_(std::move(level)) {}

  const PhotoTask& task_;
  double ground_m_;
  std::vector<std::size_t> patches_;
  PhotoLevel level_;
};

// The lens' inverse need not exist as far outside the frame as patches may be drawn.
PhotoView WithoutLens(PhotoView view) {
  view.camera.lens = {};
  view.film_correction = nullptr;
  return view;
}

struct AroundPhoto {
  std::size_t patch = 0;  // index into the patches
  Eigen::Vector2d pixel;  // scan
  double width_px = 0;
};

// What the photo may show, whichever way it is turned.
std::vector<AroundPhoto> PatchesAround(const PhotoTask& task, const PhotoView& view) {
  std::vector<AroundPhoto> around;
  const Camera& camera = view.camera;
  for (std::size_t i = 0; i < task.patches.size(); ++i) {
    const auto photo = PhotoFromGround(camera, view.pose, task.patches[i].ground_m);
    if (!photo || (*photo - camera.frame_centre_mm).norm() > camera.FrameRadius()) continue;
    if (const auto width_px = PatchWidth(view, task.patches[i]))
      around.push_back({i, view.PixelFromPhoto(*photo), *width_px});
  }
  return around;
}

// How well an image's place is determined by its own gradients: det N / tr N (Foerstner).
double Structure(const Image& image) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int row = 1; row + 1 < image.height; ++row)
    for (int col = 1; col + 1 < image.width; ++col) {
      const Eigen::Vector2d gradient(image.At(col + 1, row) - image.At(col - 1, row),
                                     image.At(col, row + 1) - image.At(col, row - 1));
      if (gradient.allFinite()) sum += gradient * gradient.transpose();
    }
  return sum.trace() > 0 ? sum.determinant() / sum.trace() : 0;
}

// Of those at least so wide the ones with most structure at that level, evenly distributed: what
// makes a good patch at full resolution may be gone there.
std::vector<std::size_t> Conspicuous(const PhotoTask& task, const PhotoView& view,
                                     const std::vector<AroundPhoto>& around, int reduction,
                                     int side) {
  std::vector<double> structure(around.size(), 0);
  SideBySide(around.size(), [&](std::size_t i) {
    if (around[i].width_px < 0.95 * side * reduction) return;
    const auto drawn = AlignWholePatch(view, task.patches[around[i].patch], reduction, side);
    if (drawn) structure[i] = Structure(drawn->image);
  });
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < around.size(); ++i)
    if (structure[i] > 0) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return structure[a] > structure[b]; });
  // The best of every cell, then the second best of every cell, until there are enough.
  const double cell_px = std::max(task.image.Width(), task.image.Height()) / kCells;
  std::map<std::pair<long, long>, int> ranked;
  std::vector<int> rank(around.size(), 0);
  for (const std::size_t i : order) {
    const Eigen::Vector2d cell = around[i].pixel / cell_px;
    rank[i] = ranked[{std::lround(cell.x()), std::lround(cell.y())}]++;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rank[a] < rank[b]; });
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::min(order.size(), kPatches); ++k)
    chosen.push_back(around[order[k]].patch);
  return chosen;
}

// The finest level that can be searched whole.
int FinestReduction(const PhotoImage& photo) {
  int reduction = 1;
  const double pixels = static_cast<double>(photo.Width()) * photo.Height();
  while (pixels > kMaxPixels * reduction * reduction) ++reduction;
  return reduction;
}

std::optional<SoughtPatches> SoughtPatches::Of(const PhotoTask& task, double ground_m,
                                               const Pose& approximate) {
  const PhotoView view = WithoutLens(task.View(task.photo.positions.front(), approximate));
  const std::vector<AroundPhoto> around = PatchesAround(task, view);
  if (around.empty()) return std::nullopt;
  std::vector<double> widths;
  for (const AroundPhoto& patch : around) widths.push_back(patch.width_px);
  // Most of them, for the smallest are too small.
  const auto small = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 4);
  std::nth_element(widths.begin(), small, widths.end());
  const int reduction = std::max(FinestReduction(task.image), static_cast<int>(*small / kMostSide));
  const int fitting = static_cast<int>(*small / reduction);
  const int side = std::clamp(fitting - (fitting % 2 == 0 ? 1 : 0), kLeastSide, kMostSide);
  std::vector<std::size_t> patches = Conspicuous(task, view, around, reduction, side);
  const int shorter = std::min(task.image.Width(), task.image.Height());
  if (patches.size() < kFewest || shorter < 2 * side * reduction) return std::nullopt;
  return SoughtPatches(task, ground_m, std::move(patches), PhotoLevel(task.image, reduction, side));
}

std::vector<VotingPatch> SoughtPatches::Seek(const PhotoView& view, const PosePrior& prior) const {
  const double height = view.pose.position_m.z() - ground_m_;
  const Vector6d sigma = prior.covariance.diagonal().cwiseSqrt();
  const double turned = kWindowSigmas * std::hypot(sigma.segment<2>(3).maxCoeff(),
                                                   sigma.head<2>().maxCoeff() / height);
  const double stretched = kKappaStep_rad / 2 + kWindowSigmas * sigma[2] / height;
  const double distance_px = view.camera.principal_distance_mm / view.PixelSize();
  const Eigen::Vector2d middle_px = view.PixelFromPhoto(view.camera.frame_centre_mm);
  std::vector<VotingPatch> voting(patches_.size());
  SideBySide(voting.size(), [&](std::size_t i) {
    const patchdb::Patch& patch = task_.patches[patches_[i]];
    voting[i].ground_m = patch.ground_m;
    const auto drawn = AlignWholePatch(view, patch, level_.Reduction(), level_.Side());
    if (!drawn) return;
    const double off_px = (drawn->predicted_px - middle_px).norm();
    // The same tilt moves more what lies farther out.
    const double oblique = 1 + std::pow(off_px / distance_px, 2);
    auto places = level_.Find(
        drawn->image, drawn->predicted_px,
        oblique * std::tan(std::min(turned, kMostTurned_rad)) * distance_px + stretched * off_px,
        kMaxCandidates, kMinScore);
    voting[i].candidates = std::move(places.best);
    voting[i].window_px2 = places.area_px2;
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

// The position is known, or its height is not either.
std::vector<double> HeightsToTry(const PhotoTask& task, double ground_m) {
  if (IsPositionKnown(task.photo.prior, ground_m)) return {1};
  return HeightFactors(task.photo.prior, ground_m);
}

class AttitudeSearch {
 public:
  AttitudeSearch(const PhotoTask& task, double ground_m, const SoughtPatches& sought,
                 const Pose& approximate, double trials)
      : task_(task),
        ground_m_(ground_m),
        sought_(sought),
        wide_(WideOf(task, ground_m, approximate)) {
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
  ConsensusOptions options_;
  std::map<Look, std::vector<VotingPatch>> found_;
};

// Any tilt that aerial photos have, at the position as far as it is known.
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

// The likely ones first.
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

// In hundredths; larger where the camera is lower.
Look AttitudeSearch::LookOf(const Way& way) const {
  const PhotoView view = ViewOf(way);
  const double size = (wide_.pose.position_m.z() - ground_m_) / way.height_m;
  const Eigen::Matrix2d shape = Eigen::Rotation2Dd(way.kappa_rad).toRotationMatrix() *
                                way.position->photo_from_pixel.A * (size / view.PixelSize());
  Look look{};
  for (int i = 0; i < 4; ++i) look[static_cast<std::size_t>(i)] = std::lround(100 * shape(i));
  return look;
}

const std::vector<VotingPatch>& AttitudeSearch::Sought(const Way& way, const PhotoView& view) {
  const Look look = LookOf(way);
  const auto known = found_.find(look);
  if (known != found_.end()) return known->second;
  return found_.emplace(look, sought_.Seek(WithoutLens(view), wide_)).first->second;
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
  return TryAs(way, view, sought_.Seek(WithoutLens(view), wide_));
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

double AttitudeTrials(const PhotoTask& task, double ground_height_m) {
  const double ways = static_cast<double>(HeightsToTry(task, ground_height_m).size() * kKappas *
                                          task.photo.positions.size());
  return static_cast<double>(ApproximatePoses(task.photo.prior).size()) *
         (ways + static_cast<double>(kFollowed) * kFollowedRounds);
}

WholePhotoSearch SearchAttitudes(const PhotoTask& task, double ground_height_m, double trials) {
  WholePhotoSearch search;
  std::optional<PoseTrack>& best = search.track;
  for (const Pose& approximate : ApproximatePoses(task.photo.prior)) {
    const auto sought = SoughtPatches::Of(task, ground_height_m, approximate);
    if (!sought) continue;
    search.searched = true;
    KeepBetter(AttitudeSearch(task, ground_height_m, *sought, approximate, trials).Run(), &best);
    if (best && best->log10_false_alarms < task.options.max_log10_false_alarms) break;
  }
  return search;
}

}  // namespace orient::exterior

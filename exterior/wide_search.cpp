#include "exterior/wide_search.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "core/imaging/correlation.h"
#include "core/imaging/side_by_side.h"
#include "core/imaging/template_search.h"
#include "core/median.h"
#include "exterior/consensus.h"
#include "exterior/patch_mosaic.h"

namespace orient {
namespace {

constexpr int kSide = 25;             // of a tile, level pixels
constexpr double kShortSide = 160;    // of the photo at the coarsest level, pixels
constexpr double kMaxPixels = 1.5e6;  // of a level that is searched whole
constexpr double kCovered = 0.6;      // of a tile, by patches
constexpr std::size_t kMaxTiles = 160;
constexpr std::size_t kMinTiles = 8;
constexpr double kKappaStep_rad = 15 * std::numbers::pi / 180;
constexpr double kScaleStep = 1.2;
constexpr double kAllowedScale = 1.2;  // wrong by so much, even if the height is said to be known
constexpr double kMinScore = 0.45;     // of a tile's candidate
// Tilt, and what the steps of kappa and scale leave, move a photo's tiles against one another by
// up to this share of the flying height.
constexpr double kClusterPerHeight = 0.15;

// One way the photo may have been taken.
struct Hypothesis {
  const FilmPosition* position = nullptr;
  Pose pose;
  double height_m = 0;  // above the ground
};

double MedianHeight(const std::vector<Patch>& patches) {
  std::vector<double> heights;
  for (const Patch& patch : patches) heights.push_back(patch.ground_m.z());
  return UpperMedian(std::move(heights));
}

// From an offset in the photo, pixels of a level, to one on level ground.
Eigen::Matrix2d GroundFromLevel(const PhotoTask& task, const Hypothesis& hypothesis,
                                int reduction) {
  const double scale = hypothesis.height_m / task.photo.camera.principal_distance_mm;
  return scale * reduction * Eigen::Rotation2Dd(hypothesis.pose.opk_rad.z()).toRotationMatrix() *
         hypothesis.position->photo_from_pixel.A;
}

// Kappas outwards from the approximate one, before that at another scale.
std::vector<Hypothesis> Hypotheses(const PhotoTask& task, const PosePrior& wide, double ground_m) {
  const double height = wide.pose.position_m.z() - ground_m;
  const double sigma = std::sqrt(wide.covariance(2, 2)) / height;
  const double reach = std::max(std::log(kAllowedScale), std::log1p(2 * std::min(sigma, 0.5)));
  const int scales = std::max(1, static_cast<int>(std::lround(reach / std::log(kScaleStep))));
  const int kappas = static_cast<int>(std::lround(2 * std::numbers::pi / kKappaStep_rad));
  const auto outwards = [](int i) { return i % 2 == 0 ? -i / 2 : (i + 1) / 2; };
  std::vector<Hypothesis> hypotheses;
  for (int s = 0; s < 2 * scales + 1; ++s)
    for (int k = 0; k < kappas; ++k)
      for (const FilmPosition& position : task.photo.positions) {
        Hypothesis hypothesis{&position, wide.pose, height * std::pow(kScaleStep, outwards(s))};
        hypothesis.pose.opk_rad.z() += outwards(k) * kKappaStep_rad;
        hypothesis.pose.position_m.z() = ground_m + hypothesis.height_m;
        hypotheses.push_back(hypothesis);
      }
  return hypotheses;
}

// The tiles at one level, and the photo ready to be searched for them.
struct TileLevel {
  int reduction = 1;
  PatchMosaic mosaic;
  std::vector<Eigen::Vector3d> tiles_m;  // their middles on the ground
  ImageWindow window;                    // the whole photo
};

bool IsCovered(const Image& tile) {
  const auto valid = std::count_if(tile.values.begin(), tile.values.end(),
                                   [](float value) { return std::isfinite(value); });
  return static_cast<double>(valid) >= kCovered * static_cast<double>(tile.values.size());
}

// Side by side on the ground, the nearest to the photo's approximate middle first.
std::vector<Eigen::Vector3d> ChooseTiles(const PhotoTask& task, const PatchMosaic& mosaic,
                                         double gsd_m, const Eigen::Vector2d& middle_m) {
  std::vector<Eigen::Vector2d> centres;
  for (const Patch& patch : task.patches) centres.emplace_back(patch.ground_m.head<2>());
  std::stable_sort(centres.begin(), centres.end(), [&](const auto& a, const auto& b) {
    return (a - middle_m).squaredNorm() < (b - middle_m).squaredNorm();
  });
  std::vector<Eigen::Vector3d> tiles;
  for (const Eigen::Vector2d& centre : centres) {
    if (tiles.size() >= kMaxTiles) break;
    const bool taken = std::any_of(tiles.begin(), tiles.end(), [&](const Eigen::Vector3d& tile) {
      return (tile.head<2>() - centre).norm() < gsd_m * kSide;
    });
    if (taken) continue;
    if (!IsCovered(mosaic.Draw(centre, gsd_m * Eigen::Matrix2d::Identity(), kSide))) continue;
    tiles.emplace_back(centre.x(), centre.y(), mosaic.HeightAround(centre, gsd_m * kSide / 2));
  }
  return tiles;
}

// The coarsest level at which the patches are dense enough to make tiles.
std::optional<TileLevel> MakeLevel(const PhotoTask& task, const Hypothesis& stated) {
  const double width = task.image.Width(), height = task.image.Height();
  int reduction = std::max(1, static_cast<int>(std::lround(std::min(width, height) / kShortSide)));
  for (; reduction >= 1 && width * height <= kMaxPixels * reduction * reduction; reduction /= 2) {
    if (std::min(width, height) < 2.0 * kSide * reduction) continue;
    const double gsd_m =
        std::sqrt(std::abs(GroundFromLevel(task, stated, reduction).determinant()));
    auto mosaic = PatchMosaic::Of(task.patches, gsd_m);
    if (!mosaic) return std::nullopt;
    auto tiles = ChooseTiles(task, *mosaic, gsd_m, stated.pose.position_m.head<2>());
    if (tiles.size() < kMinTiles) continue;
    const Eigen::Vector2d half(width / 2, height / 2);
    return TileLevel{reduction, std::move(*mosaic), std::move(tiles),
                     task.image.Around(half, half, reduction)};
  }
  return std::nullopt;
}

// Where in the photo the tiles may lie, if it was taken so.
std::vector<VotingPatch> Seek(const TileLevel& level, const TemplateSearch& search,
                              const Eigen::Matrix2d& ground_from_level) {
  constexpr int kMaxCandidates = 4;
  constexpr double kPeakDistance = 3;
  std::vector<VotingPatch> voting(level.tiles_m.size());
  SideBySide(voting.size(), [&](std::size_t i) {
    voting[i].ground_m = level.tiles_m[i];
    const Image tile = level.mosaic.Draw(level.tiles_m[i].head<2>(), ground_from_level, kSide);
    if (!IsCovered(tile)) return;
    const Image scores = search.Scores(tile);
    voting[i].window_px2 =
        static_cast<double>(scores.values.size()) * level.reduction * level.reduction;
    for (const Peak& peak : FindPeaks(scores, kMaxCandidates, kPeakDistance, kMinScore)) {
      const Eigen::Vector2d middle = peak.position + Eigen::Vector2d::Constant(kSide / 2.0);
      voting[i].candidates.push_back({level.window.RasterFromImage(middle), peak.score});
    }
  });
  return voting;
}

// Where the camera was, if a candidate is right and the attitude is the hypothesis'.
struct Vote {
  std::size_t tile = 0, candidate = 0;
  Eigen::Vector2d camera_m;
};

std::vector<Vote> Votes(const PhotoView& view, const std::vector<VotingPatch>& voting) {
  std::vector<Vote> votes;
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

// The votes around that one which most tiles agree with.
std::vector<Vote> LargestCluster(const std::vector<Vote>& votes, double radius_m) {
  std::vector<Vote> best;
  std::size_t most = 0;
  for (const Vote& centre : votes) {
    std::vector<Vote> near;
    std::size_t tiles = 0;
    for (const Vote& vote : votes) {
      if ((vote.camera_m - centre.camera_m).norm() > radius_m) continue;
      if (near.empty() || near.back().tile != vote.tile) ++tiles;
      near.push_back(vote);
    }
    if (tiles <= most) continue;
    most = tiles;
    best = std::move(near);
  }
  return best;
}

class WideSearch {
 public:
  WideSearch(const PhotoTask& task, PosePrior wide, double ground_m)
      : task_(task),
        wide_(std::move(wide)),
        hypotheses_(Hypotheses(task, wide_, ground_m)),
        level_(MakeLevel(task, hypotheses_.front())) {}

  std::optional<PoseTrack> Run() {
    if (!level_) return std::nullopt;
    const TemplateSearch search(level_->window.image, kSide);
    std::optional<PoseTrack> best;
    for (const Hypothesis& hypothesis : hypotheses_) {
      const auto track = Try(hypothesis, search);
      if (track && (!best || track->log10_false_alarms < best->log10_false_alarms)) best = track;
      if (best && best->log10_false_alarms < task_.options.max_log10_false_alarms) break;
    }
    return best;
  }

 private:
  std::optional<PoseTrack> Try(const Hypothesis& hypothesis, const TemplateSearch& search);
  const std::vector<VotingPatch>& VotesOf(const Hypothesis& hypothesis,
                                          const TemplateSearch& search);
  PosePrior PriorOf(const Hypothesis& hypothesis) const;

  const PhotoTask& task_;
  PosePrior wide_;
  std::vector<Hypothesis> hypotheses_;
  std::optional<TileLevel> level_;
  // Film turned by a quarter and kappa turned back look the same.
  std::map<std::array<long, 4>, std::vector<VotingPatch>> sought_;
};

const std::vector<VotingPatch>& WideSearch::VotesOf(const Hypothesis& hypothesis,
                                                    const TemplateSearch& search) {
  const Eigen::Matrix2d shape = GroundFromLevel(task_, hypothesis, level_->reduction);
  const double unit = 0.01 * std::sqrt(std::abs(shape.determinant()));
  const std::array<long, 4> key = {std::lround(shape(0, 0) / unit), std::lround(shape(0, 1) / unit),
                                   std::lround(shape(1, 0) / unit),
                                   std::lround(hypothesis.height_m)};
  const auto known = sought_.find(key);
  if (known != sought_.end()) return known->second;
  return sought_.emplace(key, Seek(*level_, search, shape)).first->second;
}

// The hypothesis stands for what lies within its steps of kappa and scale.
PosePrior WideSearch::PriorOf(const Hypothesis& hypothesis) const {
  PosePrior prior{hypothesis.pose, wide_.covariance};
  prior.covariance.row(2).setZero();
  prior.covariance.col(2).setZero();
  prior.covariance.row(5).setZero();
  prior.covariance.col(5).setZero();
  prior.covariance(2, 2) = std::pow((kScaleStep - 1) * hypothesis.height_m, 2);
  prior.covariance(5, 5) = kKappaStep_rad * kKappaStep_rad;
  return prior;
}

std::optional<PoseTrack> WideSearch::Try(const Hypothesis& hypothesis,
                                         const TemplateSearch& search) {
  const std::vector<VotingPatch>& voting = VotesOf(hypothesis, search);
  PhotoView view = task_.View(*hypothesis.position, hypothesis.pose);
  const std::vector<Vote> cluster =
      LargestCluster(Votes(view, voting), kClusterPerHeight * hypothesis.height_m);
  std::vector<VotingPatch> agreeing = voting;
  for (VotingPatch& tile : agreeing) tile.candidates.clear();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Vote& vote : cluster) {
    agreeing[vote.tile].candidates.push_back(voting[vote.tile].candidates[vote.candidate]);
    middle += vote.camera_m / static_cast<double>(cluster.size());
  }
  ConsensusOptions options;
  options.sigma_px = 0.5 + 0.6 * level_->reduction;
  options.samples = 1000;
  options.iterations = 5;
  options.trials = static_cast<double>(hypotheses_.size());
  view.pose.position_m.head<2>() = middle;
  auto consensus = FindConsensus(view, PriorOf(hypothesis), agreeing, options);
  if (!consensus) return std::nullopt;
  // The others might have agreed as well.
  consensus->log10_false_alarms = Log10FalseAlarms(voting, consensus->supporters, options);
  const LoopRound round{
      static_cast<int>(voting.size()), static_cast<int>(consensus->supporters.size()),
      std::max(task_.image.Width(), task_.image.Height()) / 2.0, consensus->rms_px};
  return PoseTrack{*hypothesis.position,          consensus->pose,   consensus->covariance,
                   consensus->log10_false_alarms, level_->reduction, {round}};
}

}  // namespace

bool IsVague(const Camera& camera, const PosePrior& prior, double ground_height_m) {
  constexpr double kVagueKappa_rad = 12 * std::numbers::pi / 180;
  constexpr double kShareOfFrame = 0.1;
  const Vector6d sigma = prior.covariance.diagonal().cwiseSqrt();
  if (sigma[5] > kVagueKappa_rad) return true;
  const double height = std::max(1.0, prior.pose.position_m.z() - ground_height_m);
  const double moved_mm =
      camera.principal_distance_mm *
      std::hypot(sigma.head<2>().maxCoeff() / height, sigma.segment<2>(3).maxCoeff());
  return moved_mm > kShareOfFrame * camera.frame_mm.minCoeff();
}

PosePrior Widened(const PosePrior& prior, double ground_height_m) {
  constexpr double kShareOfHeight = 0.3, kScale = 0.1;
  constexpr double kLeastTilt_rad = 5 * std::numbers::pi / 180;
  constexpr double kMostTilt_rad = 12 * std::numbers::pi / 180;
  const double height = std::max(1.0, prior.pose.position_m.z() - ground_height_m);
  PosePrior wide{prior.pose, Matrix6d(prior.covariance.diagonal().asDiagonal())};
  for (int i = 0; i < 3; ++i)
    wide.covariance(i, i) += std::pow((i < 2 ? kShareOfHeight : kScale) * height, 2);
  for (int i = 3; i < 5; ++i)
    wide.covariance(i, i) =
        std::pow(std::clamp(std::sqrt(wide.covariance(i, i)), kLeastTilt_rad, kMostTilt_rad), 2);
  wide.covariance(5, 5) = std::numbers::pi * std::numbers::pi;
  return wide;
}

std::optional<PoseTrack> SearchWidely(const PhotoTask& task) {
  const double ground_m = MedianHeight(task.patches);
  if (!(task.photo.prior.pose.position_m.z() > ground_m)) return std::nullopt;
  return WideSearch(task, Widened(task.photo.prior, ground_m), ground_m).Run();
}

}  // namespace orient

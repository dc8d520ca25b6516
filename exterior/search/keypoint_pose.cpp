#include "exterior/search/keypoint_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "core/geometry/collinearity.h"
#include "exterior/steps/consensus.h"

namespace orient::exterior {
namespace {

// Least spread of supporters, one sigma across their line, as a share of the frame's shorter side.
constexpr double kMinSpread = 0.04;
constexpr double kInlierSigmas = 4;
// Least distance between a sample's points, as a share of the frame's shorter side.
constexpr double kLeastSide = 0.1;
// Keypoints within this many reaches of the same place in both frames belong to the frames.
constexpr double kFixedReaches = 3;
// Least distance of keypoints that count separately against chance: a descriptor covers some 20 px.
constexpr double kApartSigmas = 24;
constexpr int kPosesOfASample = 4;
// Probability that no sample of supporters only was drawn.
constexpr double kMissed = 1e-4;
constexpr int kRefinements = 3;
// Cells of the scan, each way: supporters in one cell have correlated errors.
constexpr int kCells = 8;

// One film position, and the keypoints that its photo shares with others.
struct Search {
  const Camera& camera;
  const FilmPosition& position;
  const KeypointPoseOptions& options;
  std::vector<SharedKeypoint> shared;
  std::vector<Eigen::Vector2d> photo_mm;  // of each shared keypoint
  std::vector<std::size_t> keypoint;      // number of each; those at one pixel are the same
  std::size_t keypoints = 0;
  double pixel_mm = 1;
  std::size_t positions = 1;  // of the film that are tried

  double Reach() const { return kInlierSigmas * options.sigma_px * pixel_mm; }
};

Search MakeSearch(const Camera& camera, const FilmPosition& position,
                  std::vector<SharedKeypoint> shared, const KeypointPoseOptions& options) {
  const PhotoView view{camera, position.photo_from_pixel, {}, position.film_correction};
  Search search{camera, position, options, std::move(shared), {}, {}, 0, view.PixelSize(), 1};
  std::sort(search.shared.begin(), search.shared.end(), [](const auto& a, const auto& b) {
    return std::pair(a.pixel.x(), a.pixel.y()) < std::pair(b.pixel.x(), b.pixel.y());
  });
  for (std::size_t i = 0; i < search.shared.size(); ++i) {
    const bool other = i == 0 || search.shared[i].pixel != search.shared[i - 1].pixel;
    search.keypoints += other ? 1 : 0;
    search.keypoint.push_back(search.keypoints - 1);
    search.photo_mm.push_back(view.PhotoFromPixel(search.shared[i].pixel));
  }
  return search;
}

// Indices of the shared keypoints that the pose projects within reach; per keypoint the best one.
std::vector<std::size_t> Supporters(const Search& search, const Pose& pose) {
  std::vector<std::size_t> supporters;
  const PosedCamera camera(search.camera, pose);
  double best = 0;
  for (std::size_t i = 0; i < search.shared.size(); ++i) {
    const auto seen = camera.PhotoFromGround(search.shared[i].ground_m);
    if (!seen) continue;
    const double off = (*seen - search.photo_mm[i]).norm();
    if (!(off <= search.Reach())) continue;
    const bool same =
        !supporters.empty() && search.keypoint[supporters.back()] == search.keypoint[i];
    if (same && off >= best) continue;
    best = off;
    if (same)
      supporters.back() = i;
    else
      supporters.push_back(i);
  }
  return supporters;
}

bool IsAerial(const Pose& pose, double max_tilt_rad) {
  return pose.GroundFromPhoto()(2, 2) >= std::cos(max_tilt_rad);
}

ControlObservation Observed(const Search& search, std::size_t i, double variance_mm2) {
  return {search.shared[i].ground_m, search.photo_mm[i],
          Eigen::Matrix2d::Identity() * variance_mm2};
}

bool FarApart(const Search& search, const std::array<std::size_t, 3>& sample) {
  const double least = kLeastSide * search.camera.frame_mm.minCoeff();
  for (std::size_t i = 0; i < 3; ++i)
    if ((search.photo_mm[sample.at(i)] - search.photo_mm[sample.at((i + 1) % 3)]).norm() < least)
      return false;
  return true;
}

struct Found {
  Pose pose;
  std::vector<std::size_t> supporters;
};

Found Ransac(const Search& search) {
  Found best;
  if (search.keypoints < 3) return best;
  std::mt19937 random(search.options.seed);
  std::vector<double> weights;
  for (const SharedKeypoint& keypoint : search.shared) weights.push_back(keypoint.weight);
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::discrete_distribution<std::size_t> any(weights.begin(), weights.end());
  double needed = search.options.samples;
  int usable = 0;
  for (int drawn = 0; drawn < search.options.samples && usable < needed; ++drawn) {
    const std::array<std::size_t, 3> sample = {any(random), any(random), any(random)};
    if (!FarApart(search, sample)) continue;
    ++usable;
    for (const Pose& pose : ResectThreePoints(
             search.camera, {Observed(search, sample[0], 1), Observed(search, sample[1], 1),
                             Observed(search, sample[2], 1)})) {
      if (!IsAerial(pose, search.options.max_tilt_rad)) continue;
      std::vector<std::size_t> supporters = Supporters(search, pose);
      if (supporters.size() <= best.supporters.size()) continue;
      best = {pose, std::move(supporters)};
      double share = 0;  // probability of drawing a supporter
      for (const std::size_t i : best.supporters) share += weights[i] / total;
      needed = std::log(kMissed) / std::log1p(-std::min(share * share * share, 0.999));
    }
  }
  return best;
}

// Least squares with the supporters, repeated with the supporters of the adjusted pose.
void Refine(const Search& search, Found* found) {
  const double variance = std::pow(search.options.sigma_px * search.pixel_mm, 2);
  for (int i = 0; i < kRefinements; ++i) {
    std::vector<ControlObservation> observed;
    for (const std::size_t k : found->supporters) observed.push_back(Observed(search, k, variance));
    ResectionOptions options;
    options.robust_scale = 2;
    const auto adjusted = Resect(search.camera, observed, found->pose, options);
    if (!adjusted) return;
    std::vector<std::size_t> supporters = Supporters(search, adjusted->pose);
    if (supporters.size() < found->supporters.size()) return;
    *found = {adjusted->pose, std::move(supporters)};
  }
}

// Spread across the line that fits them best, as a share of the frame's shorter side.
double Spread(const Search& search, const std::vector<std::size_t>& supporters) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  for (const std::size_t i : supporters) {
    sum += search.photo_mm[i];
    squares += search.photo_mm[i] * search.photo_mm[i].transpose();
  }
  const auto count = static_cast<double>(supporters.size());
  const Eigen::Matrix2d moments = squares / count - sum * sum.transpose() / (count * count);
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(moments).eigenvalues()[0];
  return std::sqrt(std::max(0.0, least)) / search.camera.frame_mm.minCoeff();
}

// Number of these, sorted by column, that lie apart from one another: keypoints on one texture are
// right or wrong together.
int Places(const Search& search, const std::vector<std::size_t>& which) {
  const double apart_px = kApartSigmas * search.options.sigma_px;
  std::vector<Eigen::Vector2d> places;
  for (const std::size_t i : which) {
    const Eigen::Vector2d& pixel = search.shared[i].pixel;
    bool taken = false;
    for (auto place = places.rbegin(); place != places.rend() && !taken; ++place) {
      if (pixel.x() - place->x() > apart_px) break;
      taken = (pixel - *place).norm() <= apart_px;
    }
    if (!taken) places.push_back(pixel);
  }
  return static_cast<int>(places.size());
}

double FalseAlarms(const Search& search, const Found& found, const Eigen::Vector2i& scan_px) {
  std::vector<std::size_t> all(search.shared.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const int agreeing = Places(search, found.supporters);
  const int places = std::max(agreeing, Places(search, all));
  const double reach_px = kInlierSigmas * search.options.sigma_px;
  const double area_px2 =
      search.options.area_px2 > 0 ? search.options.area_px2 : scan_px.cast<double>().prod();
  const double grounds = static_cast<double>(search.shared.size()) / places;
  const double p = std::min(1.0, grounds * std::numbers::pi * reach_px * reach_px / area_px2);
  const double trials =
      static_cast<double>(search.positions) * kPosesOfASample * search.options.searches;
  return Log10FalseAlarms(places, agreeing, grounds, p) + std::log10(trials);
}

// Whether the keypoints that do not support the pose support another one nearly as well: repetitive
// ground, or photos that contradict one another.
bool HasRival(const Search& search, const Found& found) {
  std::set<std::size_t> taken;
  for (const std::size_t i : found.supporters) taken.insert(search.keypoint[i]);
  std::vector<SharedKeypoint> rest;
  for (std::size_t i = 0; i < search.shared.size(); ++i)
    if (!taken.contains(search.keypoint[i])) rest.push_back(search.shared[i]);
  Found rival = Ransac(MakeSearch(search.camera, search.position, rest, search.options));
  if (static_cast<double>(rival.supporters.size()) <
      search.options.rival_share * static_cast<double>(found.supporters.size()))
    return false;
  // Is it the same pose, apart from the effect of objects standing on the surface?
  const PosedCamera camera(search.camera, rival.pose);
  double off = 0;
  for (const std::size_t i : found.supporters) {
    const auto seen = camera.PhotoFromGround(search.shared[i].ground_m);
    if (!seen) return true;
    off += (*seen - search.photo_mm[i]).norm() / static_cast<double>(found.supporters.size());
  }
  return off > 3 * search.Reach();
}

// Sum of the supporters' squared residuals.
double SquaresMm2(const Search& search, const Found& found) {
  const PosedCamera camera(search.camera, found.pose);
  double sum_mm2 = 0;
  for (const std::size_t i : found.supporters)
    if (const auto seen = camera.PhotoFromGround(search.shared[i].ground_m))
      sum_mm2 += (*seen - search.photo_mm[i]).squaredNorm();
  return sum_mm2;
}

// Supporters in one cell share errors of the surface and the neighbouring photo: they count once.
std::optional<Matrix6d> HonestCovariance(const Search& search, const Eigen::Vector2i& scan_px,
                                         Found* found) {
  std::set<std::pair<int, int>> cells;
  for (const std::size_t i : found->supporters) {
    const Eigen::Vector2d cell =
        kCells * search.shared[i].pixel.cwiseQuotient(scan_px.cast<double>());
    cells.insert({static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))});
  }
  const auto count = static_cast<double>(found->supporters.size());
  const double least = std::pow(search.options.sigma_px * search.pixel_mm / 2, 2);
  const double variance = std::max(least, SquaresMm2(search, *found) / (2 * count - 6)) * count /
                          static_cast<double>(cells.size());
  std::vector<ControlObservation> observed;
  for (const std::size_t i : found->supporters) observed.push_back(Observed(search, i, variance));
  const auto adjusted = Resect(search.camera, observed, found->pose);
  if (!adjusted || !adjusted->converged) return std::nullopt;
  found->pose = adjusted->pose;
  return adjusted->covariance;
}

// The keypoints that lie at the same place in both frames in none of the film positions.
std::vector<SharedKeypoint> OfTheGround(const Camera& camera,
                                        const std::vector<FilmPosition>& positions,
                                        const std::vector<SharedKeypoint>& shared,
                                        double sigma_px) {
  std::vector<SharedKeypoint> of_the_ground = shared;
  for (const FilmPosition& position : positions) {
    const PhotoView view{camera, position.photo_from_pixel, {}, position.film_correction};
    const double reach_mm = kFixedReaches * kInlierSigmas * sigma_px * view.PixelSize();
    std::erase_if(of_the_ground, [&](const SharedKeypoint& keypoint) {
      return keypoint.lender_mm &&
             (view.PhotoFromPixel(keypoint.pixel) - *keypoint.lender_mm).norm() <= reach_mm;
    });
  }
  return of_the_ground;
}

double RmsPx(const Search& search, const Found& found) {
  return std::sqrt(SquaresMm2(search, found) / static_cast<double>(found.supporters.size())) /
         search.pixel_mm;
}

std::optional<KeypointPose> PoseIn(const Search& search, const Eigen::Vector2i& scan_px) {
  Found found = Ransac(search);
  const KeypointPoseOptions& options = search.options;
  if (std::ssize(found.supporters) < options.min_supporters) return std::nullopt;
  Refine(search, &found);
  if (Places(search, found.supporters) < options.min_supporters) return std::nullopt;
  const double log10_false_alarms = FalseAlarms(search, found, scan_px);
  if (Spread(search, found.supporters) < kMinSpread ||
      log10_false_alarms > options.max_log10_false_alarms || HasRival(search, found))
    return std::nullopt;
  const auto covariance = HonestCovariance(search, scan_px, &found);
  if (!covariance || !IsAerial(found.pose, options.max_tilt_rad)) return std::nullopt;
  return KeypointPose{found.pose, *covariance,        static_cast<int>(found.supporters.size()),
                      0,          log10_false_alarms, RmsPx(search, found)};
}

}  // namespace

std::optional<KeypointPose> PoseFromKeypoints(const Camera& camera,
                                              const std::vector<FilmPosition>& positions,
                                              const Eigen::Vector2i& scan_px,
                                              const std::vector<SharedKeypoint>& shared,
                                              const KeypointPoseOptions& options) {
  const auto of_the_ground = OfTheGround(camera, positions, shared, options.sigma_px);
  std::optional<KeypointPose> best;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    Search search = MakeSearch(camera, positions[i], of_the_ground, options);
    search.positions = positions.size();
    auto pose = PoseIn(search, scan_px);
    if (!pose || (best && best->supporters >= pose->supporters)) continue;
    best = pose;
    best->position = i;
  }
  return best;
}

}  // namespace orient::exterior

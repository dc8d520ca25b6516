#include "exterior/steps/consensus.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/collinearity.h"

namespace orient::exterior {
namespace {

constexpr double kInlierSigmas = 3.0;  // a candidate within this many sigmas supports the pose
constexpr int kSampleSize = 3;

struct Observation {
  Eigen::Vector3d ground_m;
  Eigen::Vector2d pixel;
};

// Normal equations of the six elements about a pose, in scan pixels.
struct Normals {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d right = Vector6d::Zero();
};

class Voter {
 public:
  Voter(const PhotoView& view, const PosePrior& prior, const std::vector<VotingPatch>& patches,
        const ConsensusOptions& options)
      : view_(view),
        pixel_from_photo_(view.photo_from_pixel.Inverse()),
        prior_(prior),
        prior_information_(prior.covariance.inverse()),
        patches_(patches),
        options_(options) {}

  // Maximum a posteriori pose of the observations and the prior (Gauss-Newton), and its covariance.
  std::optional<Consensus> Estimate(const std::vector<Observation>& observations, const Pose& start,
                                    int iterations) const;
  // The candidates that a pose explains, one per patch; returns the score of the pose.
  double Score(const Pose& pose, std::vector<Supporter>* supporters) const;
  std::vector<Observation> Observations(const std::vector<Supporter>& supporters) const;
  double RmsPx(const Pose& pose, const std::vector<Supporter>& supporters) const;

 private:
  bool Accumulate(const Observation& observation, const PosedCamera& camera,
                  Normals* normals) const;
  std::optional<Eigen::Vector2d> Project(const PosedCamera& camera,
                                         const Eigen::Vector3d& ground_m) const {
    const auto photo = camera.PhotoFromGround(ground_m);
    if (!photo) return std::nullopt;
    return PixelFromPhoto(*photo);
  }
  // As the view's, with the inverse computed once.
  Eigen::Vector2d PixelFromPhoto(const Eigen::Vector2d& photo_mm) const {
    return view_.film_correction ? view_.PixelFromPhoto(photo_mm) : pixel_from_photo_ * photo_mm;
  }

  const PhotoView& view_;
  Affine2d pixel_from_photo_;
  const PosePrior& prior_;
  Matrix6d prior_information_;
  const std::vector<VotingPatch>& patches_;
  const ConsensusOptions& options_;
};

bool Voter::Accumulate(const Observation& observation, const PosedCamera& camera,
                       Normals* normals) const {
  const auto d = camera.PhotoFromGroundWithDerivatives(observation.ground_m);
  if (!d) return false;
  const Eigen::Matrix<double, 2, 6> jacobian = pixel_from_photo_.A * d->by_pose;
  const Eigen::Vector2d residual = observation.pixel - PixelFromPhoto(d->photo_mm);
  const double weight = 1 / (options_.sigma_px * options_.sigma_px);
  normals->matrix += weight * jacobian.transpose() * jacobian;
  normals->right += weight * jacobian.transpose() * residual;
  return true;
}

std::optional<Consensus> Voter::Estimate(const std::vector<Observation>& observations,
                                         const Pose& start, int iterations) const {
  Vector6d elements = start.AsVector();
  Consensus estimate;
  for (int i = 0; i < iterations; ++i) {
    Normals normals;
    const Pose pose = Pose::FromVector(elements);
    const PosedCamera camera(view_.camera, pose);
    const Vector6d from_prior = PoseDifference(prior_.pose, pose);
    normals.matrix = prior_information_;
    normals.right = prior_information_ * from_prior;
    for (const Observation& observation : observations)
      if (!Accumulate(observation, camera, &normals)) return std::nullopt;
    const Eigen::LLT<Matrix6d> factor(normals.matrix);
    if (factor.info() != Eigen::Success) return std::nullopt;
    elements += factor.solve(normals.right);
    if (i + 1 == iterations) estimate.covariance = factor.solve(Matrix6d::Identity());
  }
  estimate.pose = Pose::FromVector(elements);
  return estimate;
}

double Voter::Score(const Pose& pose, std::vector<Supporter>* supporters) const {
  const double reach = kInlierSigmas * options_.sigma_px;
  const PosedCamera camera(view_.camera, pose);
  double score = 0;
  if (supporters != nullptr) supporters->clear();
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const auto pixel = Project(camera, patches_[i].ground_m);
    if (!pixel) continue;
    double best = 0;
    std::size_t best_candidate = 0;
    for (std::size_t k = 0; k < patches_[i].candidates.size(); ++k) {
      const Candidate& candidate = patches_[i].candidates[k];
      const double distance = (candidate.pixel - *pixel).norm() / reach;
      // Better correlation counts more, a truncated parabola rewards agreement.
      const double gain = distance < 1 ? (1 - distance * distance) * candidate.score : 0;
      if (gain > best) {
        best = gain;
        best_candidate = k;
      }
    }
    score += best;
    if (best > 0 && supporters != nullptr) supporters->push_back({i, best_candidate});
  }
  return score;
}

std::vector<Observation> Voter::Observations(const std::vector<Supporter>& supporters) const {
  std::vector<Observation> observations;
  for (const Supporter& s : supporters)
    observations.push_back(
        {patches_[s.patch].ground_m, patches_[s.patch].candidates[s.candidate].pixel});
  return observations;
}

double Voter::RmsPx(const Pose& pose, const std::vector<Supporter>& supporters) const {
  const PosedCamera camera(view_.camera, pose);
  double sum = 0;
  for (const Observation& o : Observations(supporters)) {
    const auto pixel = Project(camera, o.ground_m);
    if (pixel) sum += (o.pixel - *pixel).squaredNorm();
  }
  return supporters.empty() ? 0 : std::sqrt(sum / static_cast<double>(supporters.size()));
}

// Three different patches, each with one of its candidates; better ones more often.
std::vector<Supporter> Draw(const std::vector<VotingPatch>& patches,
                            const std::vector<std::size_t>& voters, std::mt19937& random) {
  std::vector<Supporter> sample;
  while (sample.size() < kSampleSize) {
    const std::size_t patch = voters[random() % voters.size()];
    const bool known = std::any_of(sample.begin(), sample.end(),
                                   [&](const Supporter& s) { return s.patch == patch; });
    if (known) continue;
    const std::size_t count = patches[patch].candidates.size();
    std::size_t candidate = 0;
    while (candidate + 1 < count && random() % 2 == 0) ++candidate;
    sample.push_back({patch, candidate});
  }
  return sample;
}

// Alternates between supporters and pose until they agree.
void Polish(const Voter& voter, Consensus* consensus) {
  for (int i = 0; i < 10; ++i) {
    const auto refined =
        voter.Estimate(voter.Observations(consensus->supporters), consensus->pose, 3);
    if (!refined) return;
    const std::size_t before = consensus->supporters.size();
    consensus->pose = refined->pose;
    consensus->covariance = refined->covariance;
    voter.Score(consensus->pose, &consensus->supporters);
    if (consensus->supporters.size() == before && i > 1) break;
  }
}

}  // namespace

double Log10FalseAlarms(int patches, int supporters, double candidates, double p) {
  if (supporters <= kSampleSize || patches <= kSampleSize) return 0;
  // The sample that defines the pose supports it in any case, and does not count.
  const double n = patches - kSampleSize;
  const double k = supporters - kSampleSize;
  const double q = k / n;
  double log_tail = 0;
  if (q > p) {
    log_tail = -n * q * std::log(q / p);
    if (q < 1) log_tail -= n * (1 - q) * std::log((1 - q) / (1 - p));
  }
  const double log_samples = kSampleSize * std::log(candidates) + std::lgamma(patches + 1.0) -
                             std::lgamma(kSampleSize + 1.0) - std::lgamma(n + 1);
  return (log_tail + log_samples) / std::numbers::ln10;
}

double Log10FalseAlarms(const std::vector<VotingPatch>& patches,
                        const std::vector<Supporter>& supporters, const ConsensusOptions& options) {
  const double reach = kInlierSigmas * options.sigma_px;
  double candidates = 0, p = 0, voters = 0;
  for (const VotingPatch& patch : patches) {
    const double count = static_cast<double>(patch.candidates.size());
    if (count == 0 || patch.window_px2 <= 0) continue;
    candidates += count;
    p += std::min(1.0, count * std::numbers::pi * reach * reach / patch.window_px2);
    ++voters;
  }
  if (voters < kSampleSize) return 0;
  return Log10FalseAlarms(static_cast<int>(voters), static_cast<int>(supporters.size()),
                          candidates / voters, p / voters) +
         std::log10(options.trials);
}

std::optional<Consensus> FindConsensus(const PhotoView& view, const PosePrior& prior,
                                       const std::vector<VotingPatch>& patches,
                                       const ConsensusOptions& options) {
  std::vector<std::size_t> voters;
  for (std::size_t i = 0; i < patches.size(); ++i)
    if (!patches[i].candidates.empty()) voters.push_back(i);
  if (voters.size() < kSampleSize) return std::nullopt;

  const Voter voter(view, prior, patches, options);
  std::mt19937 random(options.seed);
  std::optional<Consensus> best;
  double best_score = 0;
  for (int i = 0; i < options.samples; ++i) {
    const auto sample = Draw(patches, voters, random);
    auto hypothesis = voter.Estimate(voter.Observations(sample), view.pose, options.iterations);
    if (!hypothesis) continue;
    const double score = voter.Score(hypothesis->pose, nullptr);
    if (score <= best_score) continue;
    best_score = score;
    best = hypothesis;
  }
  if (!best) return std::nullopt;
  voter.Score(best->pose, &best->supporters);
  Polish(voter, &*best);
  best->rms_px = voter.RmsPx(best->pose, best->supporters);
  best->log10_false_alarms = Log10FalseAlarms(patches, best->supporters, options);
  return best;
}

}  // namespace orient::exterior

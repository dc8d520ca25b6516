#include "block/stages/adjustment_stage.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "block/bundle/sub_blocks.h"
#include "block/ties/one_station.h"
#include "core/matching/least_squares_matching.h"
#include "core/terrain/view_over_ground.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/resect.h"
#include "patchdb/regions/control_patches.h"

namespace orient::block {
namespace {

// Check patches are held out by ground squares with this share of a footprint's side: single
// ones between others would be too easy to predict.
constexpr double kCheckCellPerFootprint = 0.15;

// Whether its square is held out: always the same squares, whatever else is in the block.
bool HeldOut(const Eigen::Vector3d& ground_m, double cell_m, double share) {
  const auto col = static_cast<std::int64_t>(std::floor(ground_m.x() / cell_m));
  const auto row = static_cast<std::int64_t>(std::floor(ground_m.y() / cell_m));
  std::uint64_t hash = static_cast<std::uint64_t>(col) * 0x9e3779b97f4a7c15u ^
                       (static_cast<std::uint64_t>(row) + 0x7f4a7c15u) * 0xbf58476d1ce4e5b9u;
  hash = (hash ^ (hash >> 31)) * 0x94d049bb133111ebu;
  return static_cast<double>((hash ^ (hash >> 29)) % 10000) < share * 10000;
}

// Rounded to a power of two: the check patches stay the same if the footprints change a little.
double CheckCell(double footprint_side_m) {
  return std::exp2(std::round(std::log2(kCheckCellPerFootprint * footprint_side_m)));
}

double MeanFootprintSide(const std::vector<BlockPhotoFile>& photos) {
  double sum = 0;
  int count = 0;
  for (const BlockPhotoFile& photo : photos) {
    if (!photo.HasPose() || photo.footprint.Empty()) continue;
    sum += std::sqrt((photo.footprint.max_x - photo.footprint.min_x) *
                     (photo.footprint.max_y - photo.footprint.min_y));
    ++count;
  }
  return count > 0 ? sum / count : 1000;
}

template <typename Value>
std::optional<Value> Known(const std::map<std::string, Value>& of_photo, const std::string& photo) {
  const auto found = of_photo.find(photo);
  return found != of_photo.end() ? std::optional<Value>(found->second) : std::nullopt;
}

void AddPhotos(const AdjustmentInputs& inputs, AdjustedBlock* adjusted,
               std::map<std::string, std::size_t>* index) {
  adjusted->block.cameras = {inputs.camera};
  for (std::size_t i = 0; i < inputs.photos.size(); ++i) {
    const BlockPhotoFile& photo = inputs.photos[i];
    if (!photo.HasPose()) continue;
    (*index)[photo.name] = adjusted->block.photos.size();
    adjusted->photo_of.push_back(i);
    BlockPhoto to;
    to.name = photo.name;
    to.photo_from_pixel = photo.position.photo_from_pixel;
    to.film_correction = photo.position.film_correction;
    to.approximate = *photo.exterior.pose;
    to.interior = photo.position.covariance;
    to.film_sigma_mm = photo.position.film_sigma_mm;
    AddKnown(inputs.known, &to);
    adjusted->block.photos.push_back(std::move(to));
  }
}

void AddTie(const TieRecord& tie, const std::map<std::string, std::size_t>& index,
            BlockToAdjust* block) {
  const std::size_t point = block->points.size();
  BlockPoint to;
  to.id = static_cast<std::int64_t>(point) + 1;
  to.approximate_m = tie.ground_m;
  block->points.push_back(to);
  for (const SightingRecord& seen : tie.seen)
    if (const auto photo = index.find(seen.photo); photo != index.end())
      block->observations.push_back({photo->second, point, seen.pixel, seen.covariance_px2});
}

void AddTies(const AdjustmentInputs& inputs, const std::map<std::string, std::size_t>& index,
             AdjustedBlock* adjusted) {
  BlockToAdjust& block = adjusted->block;
  std::map<std::string, Pose> poses;
  for (const BlockPhoto& photo : block.photos) poses[photo.name] = photo.approximate;
  for (const TieRecord& tie : inputs.ties) {
    const std::vector<TieRecord> parts = SplitByStations(tie, poses);
    if (parts.empty()) AddTie(tie, index, &block);
    for (const TieRecord& part : parts) AddTie(part, index, &block);
  }
  if (inputs.measured) AddMeasuredTies(*inputs.measured, &block);
  adjusted->ties = block.points.size();
}

BlockPoint ControlOf(const patchdb::Patch& patch, bool held_out) {
  BlockPoint point;
  point.id = patch.id;
  point.approximate_m = patch.ground_m;
  point.held_out = held_out;
  point.control.emplace();
  point.control->ground_m = patch.ground_m;
  point.control->covariance_m2 = patch.covariance_m2;
  if (patch.height_effect && patch.height_sigma_m) {
    point.control->height_effect = *patch.height_effect;
    point.control->height_sigma_m = *patch.height_sigma_m;
  }
  point.control->source = std::to_string(patch.source_id);
  return point;
}

// A common height error is also contained in the patch's own covariance: that part is removed.
void LeaveOutHeights(GroundControl* control) {
  if (control->height_sigma_m <= 0) return;
  const Eigen::Matrix3d common = control->height_sigma_m * control->height_sigma_m *
                                 control->height_effect * control->height_effect.transpose();
  const Eigen::Matrix3d rest = control->covariance_m2 - common;
  const double least = 1e-4 * control->covariance_m2.trace();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(rest);
  control->covariance_m2 = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(least).asDiagonal() *
                           eigen.eigenvectors().transpose();
}

// Patches that photos' own orientations matched; not those lent by neighbours (numbers below 0).
void AddPatches(const AdjustmentInputs& inputs, AdjustedBlock* adjusted) {
  BlockToAdjust& block = adjusted->block;
  const patchdb::ControlPatches database = patchdb::ControlPatches::Open(inputs.patchdb);
  const double cell_m = CheckCell(MeanFootprintSide(inputs.photos));
  std::set<std::int64_t> surveyed;
  for (const patchdb::PatchSource& source : database.Sources())
    if (source.kind == patchdb::SourceKind::kGcp) surveyed.insert(source.id);
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    for (const PatchResult& match : inputs.photos[adjusted->photo_of[i]].exterior.patches) {
      if (match.id < 0 || !match.pixel || !match.sigma_px) continue;
      if (match.state == PatchState::kRejected) {
        adjusted->checks_rejected_alone +=
            match.ground_m && HeldOut(*match.ground_m, cell_m, inputs.choice.check_share) ? 1 : 0;
        continue;
      }
      if (match.state != PatchState::kMatched) continue;
      // An edge would need the covariance of both axes, which the result does not hold.
      if (exterior::IsOfEdge(*match.sigma_px)) continue;
      auto point = adjusted->patch.find(match.id);
      if (point == adjusted->patch.end()) {
        const auto patch = database.ReadPatch(match.id);
        if (!patch) continue;  // deleted since
        BlockPoint control =
            ControlOf(*patch, HeldOut(patch->ground_m, cell_m, inputs.choice.check_share));
        LeaveOutHeights(&*control.control);
        if (!surveyed.contains(patch->source_id))
          control.control->source_sigma_m =
              exterior::kSharedBySource *
              std::sqrt(control.control->covariance_m2.topLeftCorner<2, 2>().trace() / 2);
        point = adjusted->patch.emplace(match.id, block.points.size()).first;
        block.points.push_back(std::move(control));
      }
      const Eigen::Vector2d variance =
          match.sigma_px->cwiseAbs2() +
          Eigen::Vector2d::Constant(kMatchModelSigma_px * kMatchModelSigma_px);
      block.observations.push_back({i, point->second, *match.pixel, variance.asDiagonal()});
    }
  }
}

double FlyingHeight(const AdjustmentInputs& inputs) {
  double sum = 0;
  int count = 0;
  for (const BlockPhotoFile& photo : inputs.photos)
    if (photo.HasPose()) {
      sum += photo.exterior.pose->position_m.z() -
             GroundHeightUnder(inputs.surface, inputs.camera, *photo.exterior.pose);
      ++count;
    }
  return count > 0 ? std::max(sum / count, 1.0) : 1000;
}

// Effect of film bending on a pose, however many observations there are: the bend, as a random
// field over the frame, absorbed by a pose in a least-squares fit.
Matrix6d CovarianceOfBend(const Camera& camera, const Pose& pose, double sigma_mm,
                          double height_m) {
  std::vector<Eigen::Vector2d> places;
  std::vector<Eigen::Matrix<double, 2, 6>> rows;
  for (const SeenPlace& place : PlacesInFrame(camera, pose, height_m)) {
    const auto projection = PhotoFromGroundWithDerivatives(camera, pose, place.ground_m);
    if (!projection) continue;
    places.push_back(place.photo_mm);
    rows.push_back(projection->by_pose);
  }
  const double fade = exterior::kFilmCorrelationPerFrame * camera.frame_mm.minCoeff();
  Matrix6d normal = Matrix6d::Zero(), spread = Matrix6d::Zero();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    normal += rows[i].transpose() * rows[i];
    for (std::size_t j = 0; j < rows.size(); ++j)
      spread += rows[i].transpose() * rows[j] *
                std::exp(-(places[i] - places[j]).squaredNorm() / (fade * fade));
  }
  const Eigen::LDLT<Matrix6d> solver(normal);
  const Matrix6d half = solver.solve(spread);
  const Matrix6d covariance = sigma_mm * sigma_mm * solver.solve(half.transpose());
  return (covariance + covariance.transpose()) / 2;
}

}  // namespace

void AddFilmBends(const std::function<double(std::size_t photo)>& height_under_m,
                  AdjustedBlock* adjusted) {
  for (std::size_t i = 0; i < adjusted->block.photos.size(); ++i) {
    const BlockPhoto& given = adjusted->block.photos[i];
    AdjustedPhoto& photo = adjusted->result.photos[i];
    if (photo.state != PhotoState::kAdjusted || given.film_sigma_mm <= 0) continue;
    const Camera& camera = adjusted->result.cameras[given.camera];
    const Matrix6d bend =
        CovarianceOfBend(camera, photo.pose, given.film_sigma_mm, height_under_m(i));
    photo.covariance += bend;
    const auto& together = adjusted->result.covariance_photos;
    const auto k = std::find(together.begin(), together.end(), i) - together.begin();
    if (k < std::ssize(together))
      adjusted->result.pose_covariance.block<6, 6>(6 * k, 6 * k) += bend;
  }
}

void AddKnown(const PoseObservations& known, BlockPhoto* photo) {
  photo->prior = Known(known.approximations, photo->name);
  photo->gnss = Known(known.gnss, photo->name);
  photo->strip = Known(known.strip, photo->name).value_or("");
}

AdjustedBlock AdjustPhotos(const AdjustmentInputs& inputs) {
  AdjustedBlock adjusted;
  std::map<std::string, std::size_t> index;
  AddPhotos(inputs, &adjusted, &index);
  AddTies(inputs, index, &adjusted);
  AddPatches(inputs, &adjusted);
  if (inputs.measured) adjusted.surveyed = AddSurveyedPoints(*inputs.measured, &adjusted.block);
  BlockOptions options;
  options.self_calibration = inputs.choice.self_calibration;
  options.full_covariance = inputs.choice.pose_covariance;
  options.gnss = inputs.known.model;
  options.gnss_shift_sigma_m = kGnssShift_m;
  options.height_correlation_m = exterior::kHeightCorrelationPerHeight * FlyingHeight(inputs);
  // Errors of film and surface that neighbouring observations share hardly show in residuals, so
  // residuals below the stated variances do not make anything more precise.
  options.least_precision_factor = 1;
  options.control_shared_everywhere = exterior::kSharedEverywhere;
  options.control_shared_smoothly = exterior::kSharedSmoothly;
  options.most_photos = static_cast<std::size_t>(inputs.choice.sub_block_photos);
  adjusted.result = AdjustWholeOrInSubBlocks(adjusted.block, options);
  AddFilmBends(
      [&](std::size_t photo) {
        return GroundHeightUnder(inputs.surface,
                                 adjusted.result.cameras[adjusted.block.photos[photo].camera],
                                 adjusted.result.photos[photo].pose);
      },
      &adjusted);
  return adjusted;
}

}  // namespace orient::block

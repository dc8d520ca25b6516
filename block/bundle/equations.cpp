#include "block/bundle/equations.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

#include "core/geometry/dense_solvers.h"
#include "exterior/steps/error_model.h"

namespace orient::block {
namespace {

constexpr double kGnssDriftSigma_m = 1;  // from a strip's middle to its ends
constexpr double kHeldSigma_m = 1e-6;    // of unknowns in form only, held fixed

// Prior sigma of self-calibration, in units of LensUnknowns: a millimetre. It keeps parameters that
// a block cannot determine from diverging, and hardly affects those that it can.
constexpr double kLensSigma = 1.0;
// Half of a height error is common to all of its source (a datum, a systematic survey error), half
// of it to a cell as large as heights are correlated: see correlated_pose.h.
const double kShareRoot = std::sqrt(exterior::kCommonHeightShare);

Matrix6d RootOf(const Matrix6d& covariance) {
  const SymmetricEigen eigen = EigenOfSymmetric(covariance);
  return eigen.vectors * eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal();
}

// Six height unknowns per group; the same key always gets the same place.
class HeightPlaces {
 public:
  HeightUnknown Of(const std::string& key, const std::function<int()>& new_group) {
    const auto found = places_.find(key);
    if (found != places_.end()) return found->second;
    if (places_.size() % 6 == 0) group_ = new_group();
    const HeightUnknown place{group_, static_cast<int>(places_.size() % 6)};
    places_.emplace(key, place);
    return place;
  }

 private:
  std::map<std::string, HeightUnknown> places_;
  int group_ = -1;
};

std::string CellKey(const GroundControl& control, double side_m) {
  std::string key = control.source;
  for (int i = 0; i < 2; ++i)
    key += fmt::format("|{}", std::llround(std::floor(control.ground_m[i] / side_m)));
  return key;
}

}  // namespace

BlockSystem::BlockSystem(const BlockToAdjust& of_block, const BlockOptions& with_options)
    : block(of_block), options(with_options) {
  block.CheckIndices();
  weight.fill(1);
  FindOrigin();
  AddPhotos();
  AddImageRows();
  AddControlRows();
  AddPriorRows();
  AddGnssRows();
  AddUnknownRows();
}

void BlockSystem::FindOrigin() {
  for (const BlockPhoto& photo : block.photos) origin_ += photo.approximate.position_m;
  if (!block.photos.empty()) origin_ /= static_cast<double>(block.photos.size());
}

int BlockSystem::NewGroup() {
  groups.emplace_back(Vector6d::Zero());
  return static_cast<int>(groups.size()) - 1;
}

void BlockSystem::AddPhotos() {
  lens.resize(block.cameras.size());
  for (std::size_t i = 0; i < lens.size(); ++i) {
    lens[i].active.fill(options.self_calibration);
    const double radius = block.cameras[i].FrameRadius();
    for (int k = 0; k < 3; ++k) lens[i].unit[3 + k] = std::pow(radius, -(2 * k + 3));
  }
  for (std::size_t i = 0; i < block.photos.size(); ++i) pose_group.push_back(NewGroup());
  pose_groups = static_cast<int>(groups.size());
  for (std::size_t i = 0; i < block.cameras.size(); ++i)
    lens_group.push_back(options.self_calibration ? NewGroup() : -1);
  for (const BlockPhoto& photo : block.photos) {
    ImageOfPhoto image;
    image.camera = &block.cameras[photo.camera];
    image.start = {photo.approximate.position_m - origin_, photo.approximate.opk_rad};
    image.lens = options.self_calibration ? &lens[photo.camera] : nullptr;
    image.has_film = photo.interior.trace() > 0;
    if (image.has_film) image.film_root = RootOf(photo.interior);
    film_group.push_back(image.has_film ? NewGroup() : -1);
    images_.push_back(image);
  }
}

void BlockSystem::AddImageRows() {
  const std::size_t count = block.points.size();
  points.assign(count, Eigen::Vector3d::Zero());
  start_m_.assign(count, Eigen::Vector3d::Zero());
  image_rows_of_point.resize(count);
  control_row_of_point.assign(count, -1);
  for (std::size_t i = 0; i < count; ++i) {
    const BlockPoint& point = block.points[i];
    if (point.approximate_m) start_m_[i] = *point.approximate_m - origin_;
    if (point.control) start_m_[i] = point.control->ground_m - origin_;
  }
  rows.resize(block.observations.size());
  photo_mm_.resize(block.observations.size());
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    const ImageObservation& o = block.observations[i];
    const BlockPhoto& photo = block.photos[o.photo];
    photo_mm_[i] = PhotoFromPixel(photo.photo_from_pixel, photo.film_correction.get(), o.pixel);
    if (block.points[o.point].held_out) continue;
    BlockRows& row = rows[i];
    row.kind = ImageKindOf(block.points[o.point]);
    row.cost = MakeImageCost(images_[o.photo], start_m_[o.point],
                             {o.pixel, photo_mm_[i], ImageCovariance(i)},
                             &weight.at(static_cast<std::size_t>(row.kind)));
    row.active = true;
    row.point = static_cast<int>(o.point);
    row.source = i;
    row.groups[0] = pose_group[o.photo];
    row.group_count = 1;
    for (const int group : {film_group[o.photo], lens_group[photo.camera]})
      if (group >= 0) row.groups.at(static_cast<std::size_t>(row.group_count++)) = group;
    image_rows_of_point[o.point].push_back(i);
  }
}

void BlockSystem::AddControlRows() {
  const double cell_m = exterior::kShortHeightCorrelation * options.height_correlation_m;
  HeightPlaces common, cells;
  first_height_group_ = groups.size();
  const auto new_group = [this] { return NewGroup(); };
  for (std::size_t i = 0; i < block.points.size(); ++i) {
    const auto& control = block.points[i].control;
    if (!control || block.points[i].held_out || image_rows_of_point[i].empty()) continue;
    ControlTerm term;
    term.offset_m = start_m_[i] - (control->ground_m - origin_);
    term.whitening = WhiteningOf(control->covariance_m2, "a control patch");
    term.effect_m = control->height_effect * (control->height_sigma_m * kShareRoot);
    HeightUnknown of_source, of_cell;
    if (term.effect_m.squaredNorm() > 0) {
      of_source = common.Of(control->source, new_group);
      of_cell = cells.Of(CellKey(*control, cell_m), new_group);
      term.common_element = of_source.element;
      term.cell_element = of_cell.element;
    }
    control_row_of_point[i] = static_cast<int>(rows.size());
    for (const bool third : {false, true}) {
      BlockRows row;
      row.kind = GroundKindOf(block.points[i]);
      row.cost = MakeControlCost(term, third, &weight.at(static_cast<std::size_t>(row.kind)));
      row.active = true;
      row.point = static_cast<int>(i);
      row.source = i;
      if (of_source.group >= 0) {
        row.groups = {of_source.group, of_cell.group, -1};
        row.group_count = 2;
      }
      rows.push_back(std::move(row));
    }
  }
  past_heights_ = groups.size();
}

void BlockSystem::AddPriorRows() {
  prior_row.assign(block.photos.size(), -1);
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    if (!block.photos[i].prior || StatedElements(*block.photos[i].prior).empty()) continue;
    BlockRows row;
    row.kind = RowKind::kPosePrior;
    const Pose start = block.photos[i].approximate;
    row.cost = MakePosePriorCost(*block.photos[i].prior, start,
                                 &weight.at(static_cast<std::size_t>(row.kind)));
    row.active = true;
    row.source = i;
    row.groups[0] = pose_group[i];
    row.group_count = 1;
    prior_row[i] = static_cast<int>(rows.size());
    rows.push_back(std::move(row));
  }
}

void BlockSystem::AddGnssRow(std::size_t photo, int group) {
  const BlockPhoto& of = block.photos[photo];
  GnssTerm term;
  term.offset_m = of.approximate.position_m - of.gnss->position_m;
  term.whitening = WhiteningOf(of.gnss->covariance_m2, "a GNSS position");
  term.has_shift = group >= 0;
  term.time = of.gnss->along_strip;
  BlockRows row;
  row.kind = RowKind::kGnss;
  row.cost = MakeGnssCost(term, &weight.at(static_cast<std::size_t>(row.kind)));
  row.active = true;
  row.source = photo;
  row.groups = {pose_group[photo], group, -1};
  row.group_count = group >= 0 ? 2 : 1;
  gnss_group[photo] = group;
  gnss_row[photo] = static_cast<int>(rows.size());
  rows.push_back(std::move(row));
}

// Two positions that agree may do so by chance.
bool BlockSystem::ControlTestsGnss() const {
  constexpr int kLeastThatAgree = 3;
  int control = 0, positions = 0;
  for (const int row : control_row_of_point) control += row >= 0 ? 1 : 0;
  for (const BlockPhoto& photo : block.photos) positions += photo.gnss ? 1 : 0;
  return control > 0 && positions >= kLeastThatAgree;
}

void BlockSystem::AddGnssRows() {
  gnss_group.assign(block.photos.size(), -1);
  gnss_row.assign(block.photos.size(), -1);
  const bool plain = options.gnss == GnssModel::kPlain;
  std::map<std::string, std::vector<std::size_t>> strips;
  for (std::size_t i = 0; i < block.photos.size(); ++i)
    if (block.photos[i].gnss) strips[plain ? "" : block.photos[i].strip].push_back(i);
  // Film and height unknowns have a standard deviation of one by their definition.
  sigma_of_group_.assign(groups.size(), Vector6d::Ones());
  for (const auto& [name, photos] : strips) {
    const int group = plain && !ControlTestsGnss() ? -1 : NewGroup();
    if (plain) common_gnss_shift.group = group;
    for (const std::size_t i : photos) AddGnssRow(i, group);
    if (group < 0) continue;
    sigma_of_group_.resize(groups.size(), Vector6d::Ones());
    const double drift =
        options.gnss == GnssModel::kShiftAndDrift ? kGnssDriftSigma_m : kHeldSigma_m;
    sigma_of_group_[static_cast<std::size_t>(group)]
        << Eigen::Vector3d::Constant(options.gnss_shift_sigma_m),
        Eigen::Vector3d::Constant(drift);
  }
  for (const int group : lens_group)
    if (group >= 0) sigma_of_group_[static_cast<std::size_t>(group)].setConstant(kLensSigma);
}

std::size_t BlockSystem::AddUnknownRow(std::size_t group, const Vector6d& sigma) {
  BlockRows row;
  const bool of_heights = group >= first_height_group_ && group < past_heights_;
  row.kind = of_heights ? RowKind::kControlHeight : RowKind::kParameter;
  row.cost = MakeZeroCost(sigma, &weight.at(static_cast<std::size_t>(row.kind)));
  row.active = true;
  row.source = group;
  row.groups[0] = static_cast<int>(group);
  row.group_count = 1;
  rows.push_back(std::move(row));
  return rows.size() - 1;
}

void BlockSystem::AddUnknownRows() {
  for (auto group = static_cast<std::size_t>(pose_groups); group < groups.size(); ++group) {
    const std::size_t row = AddUnknownRow(group, sigma_of_group_[group]);
    if (static_cast<int>(group) != common_gnss_shift.group) continue;
    common_gnss_shift.unknown_row = row;
    common_gnss_shift.zero_row = AddUnknownRow(group, Vector6d::Constant(kHeldSigma_m));
    rows[common_gnss_shift.zero_row].active = false;
  }
}

void BlockSystem::HoldCommonGnssShift() {
  groups[static_cast<std::size_t>(common_gnss_shift.group)].setZero();
  rows[common_gnss_shift.unknown_row].active = false;
  rows[common_gnss_shift.zero_row].active = true;
}

void BlockSystem::SetFactor(RowKind kind, double factor) {
  weight.at(static_cast<std::size_t>(kind)) = 1 / std::sqrt(factor);
}

int BlockSystem::Rays(std::size_t point) const {
  return static_cast<int>(std::count_if(image_rows_of_point[point].begin(),
                                        image_rows_of_point[point].end(),
                                        [&](std::size_t row) { return rows[row].active; }));
}

void BlockSystem::SetControlActive(std::size_t point, bool active) {
  if (control_row_of_point[point] < 0) return;
  const auto row = static_cast<std::size_t>(control_row_of_point[point]);
  rows[row].active = active;
  rows[row + 1].active = active;
}

std::array<const double*, 4> BlockSystem::Unknowns(const BlockRows& row) const {
  std::array<const double*, 4> unknowns = {};
  std::size_t next = 0;
  if (row.point >= 0) unknowns.at(next++) = points[static_cast<std::size_t>(row.point)].data();
  for (int i = 0; i < row.group_count; ++i)
    unknowns.at(next++) =
        groups[static_cast<std::size_t>(row.groups.at(static_cast<std::size_t>(i)))].data();
  return unknowns;
}

PointRows BlockSystem::LinearisePoint(const BlockRows& row) const {
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
  std::array<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>, 3> by_group;
  std::array<double*, 4> jacobians = {by_point.data(), by_group[0].data(), by_group[1].data(),
                                      by_group[2].data()};
  PointRows linear;
  row.cost->Evaluate(Unknowns(row).data(), linear.residual.data(), jacobians.data());
  linear.by_point = by_point;
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.group_count); ++i)
    linear.by_group.at(i) = by_group.at(i);
  return linear;
}

OtherRows BlockSystem::LineariseOther(const BlockRows& row) const {
  std::array<std::array<double, 36>, 3> by_group;
  std::array<double*, 3> jacobians = {by_group[0].data(), by_group[1].data(), by_group[2].data()};
  OtherRows linear;
  linear.count = row.Residuals();
  row.cost->Evaluate(Unknowns(row).data(), linear.residual.data(), jacobians.data());
  using Rows6 = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>>;
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.group_count); ++i) {
    linear.by_group.at(i).setZero();
    linear.by_group.at(i).topRows(linear.count) = Rows6(by_group.at(i).data(), linear.count, 6);
  }
  return linear;
}

Pose BlockSystem::LocalPoseOf(std::size_t photo) const {
  const Vector6d& unknown = groups[static_cast<std::size_t>(pose_group[photo])];
  const Pose& start = images_[photo].start;
  Pose pose{start.position_m + unknown.head<3>(), start.opk_rad + unknown.tail<3>()};
  for (int i = 0; i < 3; ++i) pose.opk_rad[i] = NormalizeAngle(pose.opk_rad[i]);
  return pose;
}

Pose BlockSystem::PoseOf(std::size_t photo) const {
  Pose pose = LocalPoseOf(photo);
  pose.position_m += origin_;
  return pose;
}

Eigen::Vector3d BlockSystem::LocalGroundOf(std::size_t point) const {
  return start_m_[point] + points[point];
}

Eigen::Vector3d BlockSystem::GroundOf(std::size_t point) const {
  return origin_ + LocalGroundOf(point);
}

Eigen::Vector2d BlockSystem::ResidualMm(std::size_t observation) const {
  const BlockRows& row = rows[observation];
  const Eigen::Vector2d whitened = LinearisePoint(row).residual;
  const Eigen::LLT<Eigen::Matrix2d> root(ImageCovariance(observation));
  return -(root.matrixL() * whitened) / weight.at(static_cast<std::size_t>(row.kind));
}

Vector6d BlockSystem::InteriorCorrection(std::size_t photo) const {
  if (film_group[photo] < 0) return Vector6d::Zero();
  return images_[photo].film_root * groups[static_cast<std::size_t>(film_group[photo])];
}

Ray BlockSystem::LocalRay(std::size_t observation, bool* valid) const {
  const std::size_t photo = block.observations[observation].photo;
  const auto ray =
      GroundRayFromPhoto(*images_[photo].camera, LocalPoseOf(photo), photo_mm_[observation]);
  *valid = ray.has_value();
  return ray.value_or(Ray{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()});
}

// Only the image costs read the start value at every evaluation; control costs were built with it.
void BlockSystem::SetStart(std::size_t point, const Eigen::Vector3d& local_m) {
  if (control_row_of_point[point] >= 0)
    points[point] = local_m - start_m_[point];
  else {
    start_m_[point] = local_m;
    points[point].setZero();
  }
}

}  // namespace orient::block

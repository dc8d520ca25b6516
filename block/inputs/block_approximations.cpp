#include "block/inputs/block_approximations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "block/inputs/approximations.h"
#include "block/inputs/measurement_inputs.h"
#include "block/inputs/photo_metadata.h"
#include "block/inputs/strip_geometry.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/geometry/rotation.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient::block {
namespace {

// Share of the frame's shorter side on the ground: for an approximation at least this accurate, the
// whole photo need not be searched.
constexpr double kWellKnown = 0.1;
// A focal length that differs by more is another lens.
constexpr double kFocalLengthTolerance = 0.03;

double PositionSigma(const OrientationRow& row) { return row.sigma->head<2>().maxCoeff(); }

}  // namespace

bool LocatesStrip(const ExteriorResult& result, const OrientationRow* before) {
  constexpr double kMostSigmas = 5;
  if (!result.pose || !result.covariance || result.status == Status::kFailed) return false;
  if (result.status == Status::kOk) return true;
  if (before == nullptr || !before->sigma) return false;
  const Vector6d sigma = (before->sigma->cwiseAbs2() + result.covariance->diagonal()).cwiseSqrt();
  const Eigen::Vector3d off = result.pose->position_m - before->pose.position_m;
  if ((off.cwiseAbs().array() > kMostSigmas * sigma.head<3>().array()).any()) return false;
  const double turned = NormalizeAngle(result.pose->opk_rad[2] - before->pose.opk_rad[2]);
  return !before->attitude_known || std::abs(turned) <= kMostSigmas * sigma[5];
}

BlockApproximations::BlockApproximations(const BlockFile& block, const Camera& camera,
                                         const Measurements& measurements)
    : block_(block), camera_(camera) {
  if (!block.approximations.empty()) ReadTable();
  const std::vector<OrientationRow> gnss = ReadGnss(block, &remarks_);
  RefuseExchangedAxes(block, known_, gnss);
  NameOtherPhotos(gnss, block.gnss.positions, PhotosAndPlaces(), &remarks_, &not_there_);
  stated_ = StatedApproximations(block, known_, computed_heights_);
  observations_ = ObservationsOf(block, stated_, gnss);
  AddGnssPositions(gnss, &known_);
  ReadFiles();
  ApplyMeasurements(measurements);
  std::set<std::string> photos;
  for (const std::string& path : block.photos) photos.insert(PhotoName(path));
  NameAbsentOfStrips(block.flight, photos, &remarks_);
  Fill();
}

// A photo that is not scanned still locates the others of its strip.
std::set<std::string> BlockApproximations::PhotosAndPlaces() const {
  std::set<std::string> photos;
  for (const std::string& path : block_.photos) photos.insert(PhotoName(path));
  for (const UnusablePhoto& photo : block_.unusable) photos.insert(photo.name);
  for (const FlightStrip& strip : block_.flight.strips)
    photos.insert(strip.photos.begin(), strip.photos.end());
  return photos;
}

void BlockApproximations::ReadTable() {
  const auto height_m = block_.flight.FlyingHeight(camera_.principal_distance_mm);
  OrientationTable table = ReadApproximations(
      block_.approximations, block_.crs, height_m ? Heights::kMayBeAbsent : Heights::kRequired);
  table_.crs = table.crs;
  std::set<std::string> photos;
  for (const std::string& path : block_.photos) photos.insert(PhotoName(path));
  RequireOneCamera(table, block_.approximations, photos);
  remarks_ = RemarksOn(table, block_.approximations);
  if (height_m) computed_heights_ = CompleteHeights(block_.dem, block_.crs, *height_m, &table.rows);
  NameOtherPhotos(table.rows, block_.approximations, PhotosAndPlaces(), &remarks_, &not_there_);
  known_ = std::move(table.rows);
}

void BlockApproximations::ReadFiles() {
  // Metadata of a film photo describe the scanner, or the camera that reproduced the film.
  if (camera_.kind == CameraKind::kFilm) return;
  std::set<std::string> have;
  for (const OrientationRow& row : known_) have.insert(row.photo);
  int located = 0;
  std::vector<std::string> other_lens;
  double focal_length_mm = 0;
  for (const std::string& path : block_.photos) {
    const std::string name = PhotoName(path);
    if (have.contains(name)) continue;
    const PhotoMetadata metadata = ReadPhotoMetadata(path);
    if (auto row = LocatedByMetadata(name, metadata, block_.crs)) {
      known_.push_back(std::move(*row));
      ++located;
    }
    const auto& focal = metadata.focal_length_mm;
    if (!focal || std::abs(*focal / camera_.principal_distance_mm - 1) <= kFocalLengthTolerance)
      continue;
    focal_length_mm = *focal;
    other_lens.push_back(name);
  }
  if (located > 0)
    remarks_.push_back(
        {.reason = Reason::kLocatedByOwnFiles, .value = static_cast<double>(located)});
  if (!other_lens.empty())
    remarks_.push_back({.reason = Reason::kFocalLengthIsNotTheCameras,
                        .value = focal_length_mm,
                        .limit = camera_.principal_distance_mm,
                        .where = Listed(other_lens)});
}

// Takes positions given by a person; a strip that locates the photo adds angles and height.
void BlockApproximations::ApplyMeasurements(const Measurements& measurements) {
  std::set<std::string> in_strips, known;
  for (const FlightStrip& strip : block_.flight.strips)
    in_strips.insert(strip.photos.begin(), strip.photos.end());
  for (const OrientationRow& row : known_) known.insert(row.photo);
  const bool strips_are_located =
      std::any_of(in_strips.begin(), in_strips.end(),
                  [&](const std::string& photo) { return known.contains(photo); });
  std::vector<std::string> photos;
  for (const std::string& path : block_.photos) {
    const std::string photo = PhotoName(path);
    const auto position = measurements.PositionOf(photo);
    if (position && strips_are_located && in_strips.contains(photo) && !known.contains(photo))
      decided_positions_[photo] = *position;
    else
      photos.push_back(photo);
  }
  const auto height_at = [&](const Eigen::Vector2d& place) -> std::optional<ExpectedHeight> {
    const auto flying_height_m = block_.flight.FlyingHeight(camera_.principal_distance_mm);
    if (!flying_height_m) return std::nullopt;
    OrientationRow row;
    row.pose.position_m.head<2>() = place;
    return ExpectedHeight{HeightOver(SurfaceAround(block_.dem, block_.crs, {row}, *flying_height_m),
                                     row.pose.position_m, *flying_height_m),
                          kFlyingHeightSpread * *flying_height_m};
  };
  ApplyDecidedPositions(measurements, photos,
                        {block_.position_sigma_m, block_.attitude_sigma_rad, {}}, height_at,
                        &known_);
}

OrientationRow BlockApproximations::WithSigma(OrientationRow row) const {
  if (row.sigma) return row;
  row.sigma = SigmaOfApproximation(row, block_.position_sigma_m, block_.attitude_sigma_rad);
  return row;
}

double BlockApproximations::GroundUnder(const std::vector<OrientationRow>& rows) const {
  double reach_m = 0;
  for (const OrientationRow& row : rows)
    reach_m = std::max(reach_m, row.pose.position_m.z() - kLowestGround_m);
  const GroundSurface surface = SurfaceAround(block_.dem, block_.crs, rows, reach_m);
  std::vector<double> heights;
  for (const OrientationRow& row : rows)
    if (const auto height = surface.HeightAt(row.pose.position_m.x(), row.pose.position_m.y()))
      heights.push_back(*height);
  if (heights.empty())
    for (const OrientationRow& row : rows)
      heights.push_back(GroundAround(surface, row.pose.position_m, reach_m));
  return Median(std::move(heights));
}

void BlockApproximations::Fill() {
  table_.rows = known_;
  vague_strips_.clear();
  std::map<std::string, std::size_t> strip_of;
  for (std::size_t i = 0; i < block_.flight.strips.size(); ++i)
    for (const std::string& photo : block_.flight.strips[i].photos) strip_of[photo] = i;
  std::vector<OrientationRow> located;
  std::set<std::string> have;
  for (const OrientationRow& row : known_) {
    have.insert(row.photo);
    if (!strip_of.contains(row.photo)) continue;
    const auto now = oriented_.find(row.photo);
    located.push_back(now != oriented_.end() ? now->second : WithSigma(row));
  }
  for (const auto& [photo, row] : oriented_)
    if (!have.contains(photo) && strip_of.contains(photo)) located.push_back(row);
  if (std::all_of(strip_of.begin(), strip_of.end(),
                  [&](const auto& photo) { return have.contains(photo.first); }))
    return;
  if (located.empty())
    throw InputError(fmt::format(
        "no photo of the strips is located (strip {}: {}): neither {} nor the photos' files (EXIF; "
        "digital images only) give a position; give the position of one photo",
        block_.flight.strips.front().name, Listed(block_.flight.strips.front().photos),
        block_.approximations.empty() ? "a table of approximations" : block_.approximations));
  const double ground_m = GroundUnder(located);
  std::vector<OrientationRow> filled = FillStrips(block_.flight, located, camera_, ground_m);
  for (OrientationRow& row : filled) {
    if (const auto at = decided_positions_.find(row.photo); at != decided_positions_.end()) {
      row.pose.position_m.head<2>() = at->second.ground_m;
      if (row.sigma) row.sigma->head<2>().setConstant(at->second.sigma_m);
    }
    const double side_m = camera_.frame_mm.minCoeff() / camera_.principal_distance_mm *
                          (row.pose.position_m.z() - ground_m);
    if (PositionSigma(row) > kWellKnown * side_m) vague_strips_[row.photo] = strip_of.at(row.photo);
    table_.rows.push_back(std::move(row));
  }
  // Of an oriented photo the strips say nothing more; what it was oriented with is not needed
  // again.
  for (const auto& [photo, row] : oriented_)
    if (!have.contains(photo) && strip_of.contains(photo)) table_.rows.push_back(row);
}

void BlockApproximations::Learn(const std::vector<ExteriorResult>& results) {
  bool more = false;
  for (const ExteriorResult& result : results) {
    std::optional<OrientationRow> before;
    if (const auto* row = table_.Find(result.photo)) before = WithSigma(*row);
    if (!LocatesStrip(result, before ? &*before : nullptr)) continue;
    OrientationRow row;
    row.photo = result.photo;
    row.pose = *result.pose;
    row.sigma = result.covariance->diagonal().cwiseSqrt();
    more = oriented_.emplace(row.photo, row).second || more;
  }
  if (more && !block_.flight.Empty()) Fill();
}

std::vector<std::size_t> BlockApproximations::Next(const std::vector<std::string>& open) const {
  std::vector<std::size_t> next;
  for (std::size_t i = 0; i < open.size(); ++i)
    if (!vague_strips_.contains(open[i])) next.push_back(i);
  if (!next.empty()) return next;
  std::map<std::size_t, std::pair<double, std::size_t>> best;  // of each strip
  for (std::size_t i = 0; i < open.size(); ++i) {
    const double sigma = PositionSigma(*table_.Find(open[i]));
    const auto [known, is_new] = best.try_emplace(vague_strips_.at(open[i]), sigma, i);
    if (!is_new && sigma < known->second.first) known->second = {sigma, i};
  }
  for (const auto& [strip, photo] : best) next.push_back(photo.second);
  return next;
}

}  // namespace orient::block

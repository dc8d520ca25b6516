#include "block/bundle/joined_sub_blocks.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <set>

#include "block/bundle/adjusted_findings.h"
#include "block/bundle/outcome.h"

namespace orient::block {
namespace {

// The groups of variance components that a point's observations, and its control, belong to.
std::vector<RowKind> GroupsOf(const BlockPoint& point) {
  std::vector<RowKind> kinds = {ImageKindOf(point)};
  if (point.control) kinds.push_back(GroundKindOf(point));
  if (point.control && !point.by_hand) kinds.push_back(RowKind::kControlHeight);
  return kinds;
}

Finding RemarkOn(const SubBlockSummary& summary) {
  Finding finding{.reason = Reason::kAdjustedInSubBlocks, .value = summary.count};
  finding.where = fmt::format(" of up to {} photos", summary.largest);
  if (summary.compared > 0)
    finding.where += fmt::format(
        ": beside their borders, poses of the same photo differ by {:.2f} standard "
        "deviations from one to the next (RMS of {})",
        summary.differences, summary.compared);
  return finding;
}

}  // namespace

JoinedSubBlocks::JoinedSubBlocks(const BlockToAdjust& block)
    : block_(block),
      owner_of_point_(block.points.size(), -1),
      held_by_control_(block.points.size(), false),
      parts_of_photo_(block.photos.size()) {
  result_.photos.resize(block.photos.size());
  result_.points.resize(block.points.size());
  result_.observations.resize(block.observations.size());
  for (std::size_t i = 0; i < block.points.size(); ++i)
    if (block.points[i].control)
      result_.points[i].ground_m = block.points[i].control->ground_m;
    else if (block.points[i].approximate_m)
      result_.points[i].ground_m = *block.points[i].approximate_m;
}

void JoinedSubBlocks::Add(const AdjustedSubBlock& adjusted) {
  const BlockResult& of = adjusted.result;
  AddPhotos(adjusted);
  AddPoints(adjusted);
  AddParts(adjusted);
  AddComponents(adjusted);
  AddStrips(adjusted);
  AddTimings(of.timings);
  // A sub-block in which nothing can be adjusted does not count as one that failed to converge.
  any_converged_ = any_converged_ || of.converged;
  any_failed_ =
      any_failed_ || std::any_of(of.findings.begin(), of.findings.end(), [](const auto& f) {
        return f.reason == Reason::kAdjustmentNotConverged;
      });
  result_.cameras = of.cameras;
  VarianceFactors& factors = result_.factors;
  factors.control = std::max(factors.control, of.factors.control);
  factors.gnss = std::max(factors.gnss, of.factors.gnss);
  factors.approximations = std::max(factors.approximations, of.factors.approximations);
  factors.measured_image = std::max(factors.measured_image, of.factors.measured_image);
  factors.surveyed_ground = std::max(factors.surveyed_ground, of.factors.surveyed_ground);
  largest_ = std::max(largest_, static_cast<int>(adjusted.sub.photos.size()));
  ++count_;
}

void JoinedSubBlocks::AddPhotos(const AdjustedSubBlock& adjusted) {
  const auto& beside = adjusted.sub.beside;
  for (std::size_t k = 0; k < adjusted.sub.photos.size(); ++k) {
    const std::size_t photo = adjusted.sub.photos[k];
    const AdjustedPhoto& of = adjusted.result.photos[k];
    if (adjusted.sub.IsInCore(photo))
      result_.photos[photo] = of;
    else if (of.state == PhotoState::kAdjusted &&
             std::binary_search(beside.begin(), beside.end(), photo))
      beside_.emplace_back(photo, of.pose);
  }
}

// Takes points that a core photo shows; the sub-block has all photos that show these. If several
// sub-blocks do, takes one that determines the point, preferably by control.
void JoinedSubBlocks::AddPoints(const AdjustedSubBlock& adjusted) {
  std::vector<bool> of_core(block_.points.size(), false), by_control(block_.points.size(), false);
  std::vector<bool> photo_by_control(block_.photos.size(), false);
  for (const BlockPart& part : adjusted.result.parts)
    for (const std::size_t k : part.photos)
      photo_by_control[adjusted.sub.photos[k]] = part.by_control;
  for (const std::size_t i : adjusted.observations) {
    const ImageObservation& o = block_.observations[i];
    if (!adjusted.sub.IsInCore(o.photo)) continue;
    of_core[o.point] = true;
    by_control[o.point] = photo_by_control[o.photo];
  }
  for (std::size_t k = 0; k < adjusted.points.size(); ++k) {
    const std::size_t point = adjusted.points[k];
    const AdjustedPoint &of = adjusted.result.points[k], &known = result_.points[point];
    if (!of_core[point]) continue;
    const bool better =
        of.adjusted && (!known.adjusted || (by_control[point] && !held_by_control_[point]));
    if (owner_of_point_[point] >= 0 && !better) continue;
    owner_of_point_[point] = count_;
    held_by_control_[point] = by_control[point];
    result_.points[point] = of;
  }
  for (std::size_t k = 0; k < adjusted.observations.size(); ++k)
    if (owner_of_point_[block_.observations[adjusted.observations[k]].point] == count_)
      result_.observations[adjusted.observations[k]] = adjusted.result.observations[k];
}

void JoinedSubBlocks::AddParts(const AdjustedSubBlock& adjusted) {
  for (const BlockPart& part : adjusted.result.parts) {
    core_of_part_.emplace_back();
    for (const std::size_t k : part.photos) {
      const std::size_t photo = adjusted.sub.photos[k];
      parts_of_photo_[photo].push_back(parts_.size());
      if (adjusted.sub.IsInCore(photo)) core_of_part_.back().push_back(photo);
    }
    parts_.push_back(part);
  }
}

// How much of each group of observations is taken from the sub-block.
std::map<std::string, JoinedSubBlocks::Share> JoinedSubBlocks::SharesOf(
    const AdjustedSubBlock& adjusted) const {
  std::map<std::string, Share> shares;
  for (const std::size_t i : adjusted.observations) {
    const std::size_t point = block_.observations[i].point;
    for (const RowKind kind : GroupsOf(block_.points[point])) {
      Share& share = shares[GroupName(kind)];
      share.all += 1;
      share.taken += owner_of_point_[point] == count_ ? 1 : 0;
    }
  }
  for (const RowKind kind : {RowKind::kGnss, RowKind::kPosePrior})
    shares[GroupName(kind)] = {static_cast<double>(adjusted.sub.core.size()),
                               static_cast<double>(adjusted.sub.photos.size())};
  return shares;
}

void JoinedSubBlocks::AddComponents(const AdjustedSubBlock& adjusted) {
  auto shares = SharesOf(adjusted);
  double redundancy = 0;
  for (const VarianceComponent& component : adjusted.result.components) {
    const double share = shares[component.group].Value();
    const double weight = share * std::max(component.redundancy, 1e-6);
    if (!(weight > 0)) continue;
    redundancy += share * component.redundancy;
    auto known = std::find_if(components_.begin(), components_.end(), [&](const Component& other) {
      return other.sum.group == component.group;
    });
    if (known == components_.end()) known = components_.insert(known, {{component.group, 0}, 0});
    known->weight += weight;
    known->sum.factor += weight * component.factor;
    known->sum.redundancy += share * component.redundancy;
    known->sum.sigma0_px += weight * component.sigma0_px * component.sigma0_px;
    known->sum.estimated = known->sum.estimated || component.estimated;
  }
  redundancy_ += redundancy;
  squares_ += redundancy * adjusted.result.sigma0 * adjusted.result.sigma0;
}

void JoinedSubBlocks::FillComponents() {
  result_.redundancy = redundancy_;
  if (redundancy_ > 0.5) result_.sigma0 = std::sqrt(squares_ / redundancy_);
  for (Component& component : components_) {
    component.sum.factor /= component.weight;
    component.sum.sigma0_px = std::sqrt(component.sum.sigma0_px / component.weight);
    result_.components.push_back(component.sum);
  }
}

// Takes each strip's GNSS from the sub-block with most of the strip's positions in its core.
void JoinedSubBlocks::AddStrips(const AdjustedSubBlock& adjusted) {
  const auto& core = adjusted.sub.core;
  for (const StripGnss& strip : adjusted.result.strips) {
    const auto photos = std::count_if(core.begin(), core.end(), [&](std::size_t i) {
      const BlockPhoto& photo = block_.photos[i];
      return photo.gnss && (strip.of_all || photo.strip == strip.strip);
    });
    const auto [known, is_new] = strips_.emplace(strip.strip, std::pair(photos, strip));
    if (!is_new && photos > known->second.first) known->second = {photos, strip};
  }
}

void JoinedSubBlocks::AddTimings(const BlockTimings& of) {
  BlockTimings& sum = result_.timings;
  sum.setup += of.setup;
  sum.solve += of.solve;
  sum.snooping += of.snooping;
  sum.covariance += of.covariance;
  sum.ceres += of.ceres;
  sum.solves += of.solves;
  sum.iterations += of.iterations;
}

// A point's sub-block may have adjusted a photo that the photo's own sub-block could not. The
// observations left may be too few for the point.
void JoinedSubBlocks::DropSightingsOfUnadjusted() {
  const auto drop = [&](std::size_t i, ObservationState state) {
    result_.observations[i] = {};
    result_.observations[i].state = state;
  };
  std::vector<int> rays(block_.points.size(), 0);
  for (std::size_t i = 0; i < block_.observations.size(); ++i) {
    const ImageObservation& o = block_.observations[i];
    const ObservationState state = result_.observations[i].state;
    if (state == ObservationState::kHeldOut)
      drop(i, state);  // check patches hold their own residuals
    else if (result_.photos[o.photo].state != PhotoState::kAdjusted)
      drop(i, ObservationState::kUnusable);
    else if (state == ObservationState::kUsed)
      ++rays[o.point];
  }
  for (AdjustedPhoto& photo : result_.photos) photo.observations = 0;
  for (std::size_t i = 0; i < block_.observations.size(); ++i) {
    const ImageObservation& o = block_.observations[i];
    if (result_.observations[i].state != ObservationState::kUsed) continue;
    if (IsTie(o.point) && rays[o.point] < 2)
      drop(i, ObservationState::kAlone);
    else
      ++result_.photos[o.photo].observations;
  }
  for (std::size_t i = 0; i < rays.size(); ++i) {
    AdjustedPoint& point = result_.points[i];
    if (rays[i] < (IsTie(i) ? 2 : 1)) {
      const Eigen::Vector3d ground_m = point.ground_m;
      point = {};
      point.ground_m = ground_m;
      rays[i] = 0;
    }
    point.rays = rays[i];
    point.adjusted = rays[i] > 0;
  }
}

// Whether its rays alone determine it.
bool JoinedSubBlocks::IsTie(std::size_t point) const {
  return !block_.points[point].control || result_.points[point].control_rejected;
}

void JoinedSubBlocks::FillParts() {
  Forest forest(parts_.size());
  for (const auto& common : parts_of_photo_)
    for (const std::size_t part : common) forest.Join(common[0], part);
  std::map<std::size_t, std::vector<std::size_t>> connected;  // parts of the result, by root
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    if (core_of_part_[part].empty()) continue;
    for (const std::size_t photo : core_of_part_[part])
      result_.photos[photo].part = static_cast<int>(result_.parts.size());
    connected[forest.Root(part)].push_back(result_.parts.size());
    result_.parts.push_back(std::move(parts_[part]));
    result_.parts.back().photos = std::move(core_of_part_[part]);
  }
  for (const auto& [root, together] : connected)
    ReportConnectedParts(together, connected.size() == 1);
}

// Adds the findings for parts of sub-blocks that are connected with one another.
void JoinedSubBlocks::ReportConnectedParts(const std::vector<std::size_t>& together, bool only) {
  BlockPart all;
  std::set<std::optional<Reason>> lacking;
  for (const std::size_t part : together) {
    const BlockPart& of = result_.parts[part];
    const auto finding = FindingOf(block_, of, false);
    const bool sound = !finding || finding->reason == Reason::kPartNotConnected;
    lacking.insert(sound ? std::nullopt : std::optional(finding->reason));
    if (!sound) result_.parts[part].finding = finding;
    all.photos.insert(all.photos.end(), of.photos.begin(), of.photos.end());
    all.has_datum = of.has_datum;
    all.by_control = of.by_control;
    all.control_points = of.control_points;
  }
  const auto of_all = FindingOf(block_, all, only);
  if (lacking.size() == 1) {  // the same for all parts
    for (const std::size_t part : together) result_.parts[part].finding = of_all;
  } else if (!only) {
    result_.findings.push_back({.reason = Reason::kPartNotConnected,
                                .value = static_cast<double>(all.photos.size()),
                                .where = NamesOf(block_, all.photos)});
  }
}

SubBlockSummary JoinedSubBlocks::Compared() const {
  SubBlockSummary summary{count_, largest_};
  double sum = 0;
  for (const auto& [photo, pose] : beside_) {
    const AdjustedPhoto& counts = result_.photos[photo];
    if (counts.state != PhotoState::kAdjusted) continue;
    const Vector6d variance = counts.covariance.diagonal();
    if (variance.minCoeff() <= 0) continue;
    sum += (PoseDifference(pose, counts.pose).cwiseAbs2().array() / variance.array()).mean();
    ++summary.compared;
  }
  if (summary.compared > 0) summary.differences = std::sqrt(sum / summary.compared);
  return summary;
}

BlockResult JoinedSubBlocks::Result(const BlockOptions& options) {
  result_.converged = any_converged_ && !any_failed_;
  DropSightingsOfUnadjusted();
  FillParts();
  FillComponents();
  FillChecks(block_, &result_);
  for (auto& [name, strip] : strips_) result_.strips.push_back(std::move(strip.second));
  if (any_failed_) result_.findings.push_back({.reason = Reason::kAdjustmentNotConverged});
  const Findings findings = FindingsOfAdjusted(block_, options, result_);
  result_.findings.insert(result_.findings.end(), findings.begin(), findings.end());
  result_.sub_blocks = Compared();
  result_.findings.push_back(RemarkOn(*result_.sub_blocks));
  return std::move(result_);
}

}  // namespace orient::block

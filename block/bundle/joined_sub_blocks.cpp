#include "block/bundle/joined_sub_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "block/bundle/adjusted_findings.h"
#include "block/bundle/connected_parts.h"

namespace orient::block {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// Sums over sub-blocks, each counted by the share of its observations that are the whole's.
class JoinedComponents {
 public:
  void Add(const BlockResult& of, double share) {
    redundancy_ += share * of.redundancy;
    square_ += share * of.redundancy * of.sigma0 * of.sigma0;
    for (const VarianceComponent& component : of.components) AddGroup(component, share);
  }
  void Fill(BlockResult* result) {
    result->redundancy = redundancy_;
    if (redundancy_ > 0.5) result->sigma0 = std::sqrt(square_ / redundancy_);
    for (Group& group : groups_) {
      group.sum.factor /= group.weight;
      group.sum.sigma0_px = std::sqrt(group.sum.sigma0_px / group.weight);
      result->components.push_back(group.sum);
    }
  }

 private:
  struct Group {
    VarianceComponent sum;
    double weight = 0;
  };

  void AddGroup(const VarianceComponent& component, double share) {
    auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& other) {
      return other.sum.group == component.group;
    });
    if (group == groups_.end()) {
      groups_.push_back({{component.group, 0}, 0});
      group = std::prev(groups_.end());
    }
    const double weight = share * std::max(component.redundancy, 1e-6);
    group->weight += weight;
    group->sum.factor += weight * component.factor;
    group->sum.redundancy += share * component.redundancy;
    group->sum.sigma0_px += weight * component.sigma0_px * component.sigma0_px;
    group->sum.estimated = group->sum.estimated || component.estimated;
  }

  double redundancy_ = 0, square_ = 0;
  std::vector<Group> groups_;
};

// The sub-blocks' connected parts are parts of the whole's: those with a photo in common are one,
// unless one of them has a datum and the other has not.
class JoinedParts {
 public:
  explicit JoinedParts(std::size_t photos) : in_core_(photos, kNone), in_any_(photos) {}

  void Add(const AdjustedSubBlock& adjusted) {
    for (std::size_t k = 0; k < adjusted.sub.photos.size(); ++k) {
      const std::size_t photo = adjusted.sub.photos[k];
      const auto part = static_cast<std::size_t>(adjusted.result.photos[k].part);
      in_any_[photo].push_back(parts_.size() + part);
      if (adjusted.sub.IsInCore(photo)) in_core_[photo] = parts_.size() + part;
    }
    parts_.insert(parts_.end(), adjusted.result.parts.begin(), adjusted.result.parts.end());
  }

  void Fill(const BlockToAdjust& block, BlockResult* result) {
    Forest forest(parts_.size());
    for (const auto& common : in_any_)
      for (const std::size_t a : common)
        for (const std::size_t b : common)
          if (parts_[a].has_datum == parts_[b].has_datum) forest.Join(a, b);
    std::map<std::size_t, std::size_t> of_root;
    for (std::size_t i = 0; i < in_core_.size(); ++i) {
      const std::size_t root = forest.Root(in_core_[i]);
      const auto [place, is_new] = of_root.emplace(root, result->parts.size());
      if (is_new) result->parts.emplace_back().has_datum = parts_[root].has_datum;
      result->parts[place->second].photos.push_back(i);
      result->photos[i].part = static_cast<int>(place->second);
    }
    for (std::size_t part = 0; part < parts_.size(); ++part)
      if (const auto place = of_root.find(forest.Root(part)); place != of_root.end())
        result->parts[place->second].by_control |= parts_[part].by_control;
    CountControl(block, result);
    for (BlockPart& part : result->parts)
      part.finding = FindingOf(block, part, result->parts.size() == 1);
  }

 private:
  static void CountControl(const BlockToAdjust& block, BlockResult* result) {
    std::vector<bool> counted(block.points.size(), false);
    for (std::size_t i = 0; i < block.observations.size(); ++i) {
      const ImageObservation& o = block.observations[i];
      if (counted[o.point] || result->observations[i].state != ObservationState::kUsed ||
          !block.points[o.point].control || result->points[o.point].control_rejected)
        continue;
      counted[o.point] = true;
      const auto part = static_cast<std::size_t>(result->photos[o.photo].part);
      ++result->parts[part].control_points;
    }
  }

  std::vector<BlockPart> parts_;                  // of all sub-blocks, one after the other
  std::vector<std::size_t> in_core_;              // of each photo
  std::vector<std::vector<std::size_t>> in_any_;  // of each photo
};

Finding FindingOf(const SubBlockSummary& summary) {
  Finding finding{.reason = Reason::kAdjustedInSubBlocks, .value = summary.count};
  if (summary.compared > 0)
    finding.where = fmt::format(
        ": the poses of {} photos beside their borders differ by {:.2f} standard deviations (RMS) "
        "from one to the next",
        summary.compared, summary.differences);
  return finding;
}

class Joining {
 public:
  Joining(const BlockToAdjust& block, const std::vector<AdjustedSubBlock>& adjusted)
      : block_(block),
        core_of_photo_(block.photos.size()),
        owner_of_point_(block.points.size(), kNone),
        parts_(block.photos.size()) {
    for (std::size_t s = 0; s < adjusted.size(); ++s)
      for (const std::size_t photo : adjusted[s].sub.core) core_of_photo_[photo] = s;
    // A sub-block has all photos that show a point which one of its core's shows.
    for (const ImageObservation& o : block.observations)
      if (owner_of_point_[o.point] == kNone) owner_of_point_[o.point] = core_of_photo_[o.photo];
    result_.converged = true;
    result_.photos.resize(block.photos.size());
    result_.points.resize(block.points.size());
    result_.observations.resize(block.observations.size());
    for (std::size_t i = 0; i < block.points.size(); ++i)
      if (const BlockPoint& point = block.points[i]; owner_of_point_[i] == kNone)
        result_.points[i].ground_m = point.control
                                         ? point.control->ground_m
                                         : point.approximate_m.value_or(Eigen::Vector3d::Zero());
  }

  void Add(std::size_t number, const AdjustedSubBlock& adjusted) {
    const BlockResult& of = adjusted.result;
    parts_.Add(adjusted);
    const auto owned =
        std::count_if(adjusted.observations.begin(), adjusted.observations.end(),
                      [&](std::size_t observation) { return Owns(number, observation); });
    components_.Add(of, static_cast<double>(owned) / static_cast<double>(std::max<std::size_t>(
                                                         adjusted.observations.size(), 1)));
    AddPhotos(number, adjusted.sub, of);
    for (std::size_t k = 0; k < adjusted.points.size(); ++k)
      if (owner_of_point_[adjusted.points[k]] == number)
        result_.points[adjusted.points[k]] = of.points[k];
    for (std::size_t k = 0; k < adjusted.observations.size(); ++k)
      if (Owns(number, adjusted.observations[k]))
        result_.observations[adjusted.observations[k]] = of.observations[k];
    AddChecks(number, adjusted);
    AddStrips(adjusted.sub, of);
    result_.converged = result_.converged && of.converged;
    result_.cameras = of.cameras;
    AddTimings(of.timings);
  }

  BlockResult Joined(const BlockOptions& options, std::size_t sub_blocks) {
    parts_.Fill(block_, &result_);
    components_.Fill(&result_);
    std::sort(result_.checks.begin(), result_.checks.end(),
              [](const CheckPatch& a, const CheckPatch& b) { return a.point < b.point; });
    for (const auto& [name, strip] : strips_) result_.strips.push_back(strip.second);
    if (!result_.converged) result_.findings.push_back({.reason = Reason::kAdjustmentNotConverged});
    const Findings findings = FindingsOfAdjusted(block_, options, result_);
    result_.findings.insert(result_.findings.end(), findings.begin(), findings.end());
    result_.sub_blocks = Compared(static_cast<int>(sub_blocks));
    result_.findings.push_back(FindingOf(*result_.sub_blocks));
    return std::move(result_);
  }

 private:
  bool Owns(std::size_t sub_block, std::size_t observation) const {
    return owner_of_point_[block_.observations[observation].point] == sub_block;
  }

  void AddPhotos(std::size_t number, const SubBlock& sub, const BlockResult& of) {
    for (std::size_t k = 0; k < sub.photos.size(); ++k) {
      const std::size_t photo = sub.photos[k];
      if (core_of_photo_[photo] == number)
        result_.photos[photo] = of.photos[k];
      else if (of.photos[k].state == PhotoState::kAdjusted &&
               std::binary_search(sub.beside.begin(), sub.beside.end(), photo))
        beside_.emplace_back(photo, of.photos[k].pose);
    }
  }

  void AddChecks(std::size_t number, const AdjustedSubBlock& adjusted) {
    for (CheckPatch check : adjusted.result.checks) {
      check.point = adjusted.points[check.point];
      if (owner_of_point_[check.point] != number) continue;
      for (std::size_t& i : check.observations) i = adjusted.observations[i];
      result_.checks.push_back(std::move(check));
    }
  }

  // Of the sub-block with most of the strip's photos in its core.
  void AddStrips(const SubBlock& sub, const BlockResult& of) {
    for (const StripGnss& strip : of.strips) {
      const auto photos = std::count_if(sub.core.begin(), sub.core.end(), [&](std::size_t i) {
        return strip.of_all || block_.photos[i].strip == strip.strip;
      });
      const auto [known, is_new] = strips_.emplace(strip.strip, std::pair(photos, strip));
      if (!is_new && photos > known->second.first) known->second = {photos, strip};
    }
  }

  void AddTimings(const BlockTimings& of) {
    BlockTimings& sum = result_.timings;
    sum.setup += of.setup;
    sum.solve += of.solve;
    sum.snooping += of.snooping;
    sum.covariance += of.covariance;
    sum.ceres += of.ceres;
    sum.solves += of.solves;
    sum.iterations += of.iterations;
  }

  SubBlockSummary Compared(int count) const {
    SubBlockSummary summary{count};
    double sum = 0;
    for (const auto& [photo, pose] : beside_) {
      const AdjustedPhoto& counts = result_.photos[photo];
      if (counts.state != PhotoState::kAdjusted) continue;
      const Vector6d variance = counts.covariance.diagonal();
      if (variance.minCoeff() <= 0) continue;
      sum += (Difference(pose, counts.pose).cwiseAbs2().array() / variance.array()).mean();
      ++summary.compared;
    }
    if (summary.compared > 0) summary.differences = std::sqrt(sum / summary.compared);
    return summary;
  }

  // Angles modulo a full turn.
  static Vector6d Difference(const Pose& a, const Pose& b) {
    Vector6d difference = a.AsVector() - b.AsVector();
    for (Eigen::Index i = 3; i < 6; ++i)
      difference[i] = std::remainder(difference[i], 2 * std::numbers::pi);
    return difference;
  }

  const BlockToAdjust& block_;
  std::vector<std::size_t> core_of_photo_, owner_of_point_;
  JoinedParts parts_;
  JoinedComponents components_;
  std::map<std::string, std::pair<std::ptrdiff_t, StripGnss>> strips_;
  std::vector<std::pair<std::size_t, Pose>> beside_;  // poses that do not count
  BlockResult result_;
};

}  // namespace

BlockResult JoinSubBlocks(const BlockToAdjust& block, const BlockOptions& options,
                          const std::vector<AdjustedSubBlock>& adjusted) {
  Joining joining(block, adjusted);
  for (std::size_t s = 0; s < adjusted.size(); ++s) joining.Add(s, adjusted[s]);
  return joining.Joined(options, adjusted.size());
}

}  // namespace orient::block

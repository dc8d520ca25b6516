#include "block/bundle/sub_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "block/bundle/adjusted_view.h"
#include "block/bundle/adjustment.h"
#include "tests/block/bundle/bundle_verdict.h"
#include "tools/bench/bundle_simulation.h"

namespace orient::block {
namespace {

constexpr int kStrips = 3, kInStrip = 60;
constexpr std::size_t kMost = 100;

// Control under every seventh photo.
BundleSimulationOptions LongBlock() {
  BundleSimulationOptions options;
  options.strips = kStrips;
  options.photos_in_strip = kInStrip;
  options.ties_per_photo = 12;
  options.control_photos.clear();
  for (int i = 0; i < kStrips * kInStrip; i += 7) options.control_photos.push_back(i);
  return options;
}

BlockOptions AtMost(std::size_t photos) {
  BlockOptions options;
  options.most_photos = photos;
  return options;
}

int Column(std::size_t photo) { return static_cast<int>(photo) % kInStrip; }

// Photos, points, observations, checks and parts say the same of one another.
void ExpectConsistent(const BlockToAdjust& block, const BlockResult& result) {
  std::vector<int> of_photo(block.photos.size(), 0), of_point(block.points.size(), 0);
  std::vector<Eigen::Vector2d> of_checks(block.observations.size(), Eigen::Vector2d::Zero());
  for (const CheckPatch& check : result.checks)
    for (std::size_t k = 0; k < check.observations.size(); ++k) {
      const std::size_t i = check.observations[k];
      EXPECT_EQ(result.photos[block.observations[i].photo].state, PhotoState::kAdjusted);
      of_checks[i] = check.image_residuals_px[k];
    }
  for (std::size_t i = 0; i < of_checks.size(); ++i)
    if (result.observations[i].state == ObservationState::kHeldOut) {
      EXPECT_EQ(result.observations[i].residual_px, of_checks[i]);
    }
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    if (result.observations[i].state != ObservationState::kUsed) continue;
    const ImageObservation& o = block.observations[i];
    EXPECT_EQ(result.photos[o.photo].state, PhotoState::kAdjusted) << i;
    ++of_photo[o.photo];
    ++of_point[o.point];
  }
  for (std::size_t i = 0; i < of_photo.size(); ++i)
    EXPECT_EQ(result.photos[i].observations, of_photo[i]) << i;
  for (std::size_t i = 0; i < of_point.size(); ++i) {
    EXPECT_EQ(result.points[i].rays, of_point[i]) << i;
    EXPECT_EQ(result.points[i].adjusted, of_point[i] > 0) << i;
    const bool tie = !block.points[i].control || result.points[i].control_rejected;
    EXPECT_FALSE(tie && of_point[i] == 1) << i;
  }
  std::vector<int> parts(block.photos.size(), 0);
  for (std::size_t part = 0; part < result.parts.size(); ++part)
    for (const std::size_t photo : result.parts[part].photos) {
      ++parts[photo];
      EXPECT_EQ(result.photos[photo].part, static_cast<int>(part));
    }
  EXPECT_EQ(std::count(parts.begin(), parts.end(), 1), std::ssize(parts));
}

TEST(SubBlocks, EveryPhotoIsInOneCoreWithAllThatShowsItsPoints) {
  const BlockToAdjust block = SimulateBundle(LongBlock()).block;
  const std::vector<SubBlock> subs = DivideBlock(block, kMost);
  EXPECT_EQ(subs.size(), 4u);
  std::vector<int> cores(block.photos.size(), 0);
  for (const SubBlock& sub : subs) {
    EXPECT_LE(sub.photos.size(), kMost);
    EXPECT_TRUE(std::is_sorted(sub.photos.begin(), sub.photos.end()));
    for (const std::size_t photo : sub.core) ++cores[photo];
    std::vector<bool> shown(block.points.size(), false);
    for (const ImageObservation& o : block.observations)
      if (sub.IsInCore(o.photo)) shown[o.point] = true;
    for (const ImageObservation& o : block.observations) {
      if (!shown[o.point]) continue;
      EXPECT_NE(sub.IsInCore(o.photo),
                std::binary_search(sub.beside.begin(), sub.beside.end(), o.photo));
      EXPECT_TRUE(std::binary_search(sub.photos.begin(), sub.photos.end(), o.photo));
    }
  }
  EXPECT_EQ(std::count(cores.begin(), cores.end(), 1), std::ssize(cores));
}

TEST(SubBlocks, PhotosThatAllShowTheSamePointsAreNotDivided) {
  BundleSimulationOptions options;
  options.forward_overlap = 0.95;
  options.side_overlap = 0.9;
  options.ties_per_photo = 2;
  const BlockToAdjust block = SimulateBundle(options).block;
  EXPECT_EQ(DivideBlock(block, 4).size(), 1u);
  EXPECT_FALSE(AdjustWholeOrInSubBlocks(block, AtMost(4)).sub_blocks);
}

TEST(SubBlocks, PhotosWithoutPointsOrPlacesAreDividedToo) {
  BlockToAdjust block;
  block.cameras.emplace_back();
  block.photos.resize(12);
  EXPECT_EQ(DivideBlock(block, 1).size(), 12u);
  block.photos[3].approximate.position_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(DivideBlock(block, 1).size(), 12u);
  EXPECT_EQ(DivideBlock(BlockToAdjust(), 1).size(), 1u);
}

TEST(SubBlocks, ABlockThatIsNotTooLargeIsAdjustedAsAWhole) {
  const BundleSimulation simulation = SimulateBundle({});
  const BlockResult whole = AdjustBlock(simulation.block);
  const BlockResult result = AdjustWholeOrInSubBlocks(simulation.block, AtMost(15));
  EXPECT_FALSE(result.sub_blocks);
  for (std::size_t i = 0; i < whole.photos.size(); ++i)
    EXPECT_EQ(result.photos[i].pose.AsVector(), whole.photos[i].pose.AsVector());
}

// As accurate as the whole, and as precise as stated; what is tested is judged alike.
TEST(SubBlocks, JoinedTheyAreHardlyWorseThanTheWhole) {
  BundleSimulationOptions options = LongBlock();
  options.gross_ties = options.gross_control = 0.01;
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult whole = AdjustBlock(simulation.block);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(kMost));
  ASSERT_TRUE(joined.sub_blocks);
  EXPECT_EQ(joined.sub_blocks->count, 4);
  EXPECT_EQ(joined.sub_blocks->compared, 36) << "two columns on both sides of three borders";
  EXPECT_GT(joined.sub_blocks->differences, 0.01);
  EXPECT_LT(joined.sub_blocks->differences, 0.4);
  EXPECT_TRUE(joined.converged);
  ASSERT_EQ(joined.findings.size(), whole.findings.size() + 1);
  EXPECT_EQ(joined.findings.back().reason, Reason::kAdjustedInSubBlocks);
  EXPECT_NE(Sentence(joined.findings.back()).find("in 4 overlapping sub-blocks of up to "),
            std::string::npos)
      << Sentence(joined.findings.back());
  ExpectConsistent(simulation.block, joined);
  EXPECT_NEAR(joined.sigma0, whole.sigma0, 0.02);
  ASSERT_EQ(joined.components.size(), whole.components.size());
  for (std::size_t i = 0; i < whole.components.size(); ++i) {
    const VarianceComponent &of = joined.components[i], &in_whole = whole.components[i];
    EXPECT_EQ(of.group, in_whole.group);
    EXPECT_NEAR(of.factor, in_whole.factor, 0.2 * in_whole.factor) << of.group;
    EXPECT_NEAR(of.redundancy, in_whole.redundancy, 0.05 * in_whole.redundancy) << of.group;
    EXPECT_NEAR(of.sigma0_px, in_whole.sigma0_px, 0.05 * in_whole.sigma0_px + 1e-9) << of.group;
    EXPECT_EQ(of.estimated, in_whole.estimated);
  }
  const BundleVerdict of_whole = JudgeBundle(simulation, whole),
                      of_joined = JudgeBundle(simulation, joined);
  EXPECT_LT(of_joined.horizontal_gsd, 1.05 * of_whole.horizontal_gsd);
  EXPECT_LT(of_joined.height_gsd, 1.05 * of_whole.height_gsd);
  EXPECT_NEAR(of_joined.PoseChi(), of_whole.PoseChi(), 0.1);
  double worst = 0;
  for (std::size_t i = 0; i < whole.photos.size(); ++i)
    worst = std::max(worst, std::sqrt(joined.photos[i]
                                          .covariance.diagonal()
                                          .cwiseQuotient(whole.photos[i].covariance.diagonal())
                                          .maxCoeff()));
  EXPECT_LT(worst, 1.1);
  int alike = 0;
  for (std::size_t i = 0; i < whole.observations.size(); ++i)
    alike += joined.observations[i].state == whole.observations[i].state ? 1 : 0;
  EXPECT_GT(alike, 0.995 * static_cast<double>(whole.observations.size()));
}

TEST(SubBlocks, ChecksAreOfTheSamePointsAsTheWholes) {
  BundleSimulationOptions options = LongBlock();
  options.control_seen_by_all = true;
  BundleSimulation simulation = SimulateBundle(options);
  for (std::size_t i = 0; i < simulation.block.points.size(); ++i)
    if (simulation.block.points[i].control && i % 5 == 0)
      simulation.block.points[i].held_out = true;
  const BlockResult whole = AdjustBlock(simulation.block);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(kMost));
  ASSERT_EQ(joined.checks.size(), whole.checks.size());
  ASSERT_GT(whole.checks.size(), 10u);
  for (std::size_t i = 0; i < whole.checks.size(); ++i) {
    const CheckPatch &check = joined.checks[i], &of_whole = whole.checks[i];
    EXPECT_EQ(check.point, of_whole.point);
    EXPECT_EQ(check.observations, of_whole.observations);
    EXPECT_LT((check.image_residuals_px[0] - of_whole.image_residuals_px[0]).norm(), 0.5);
    ASSERT_EQ(check.ground_residual_m.has_value(), of_whole.ground_residual_m.has_value());
    if (check.ground_residual_m) {
      EXPECT_LT((*check.ground_residual_m - *of_whole.ground_residual_m).norm(), 0.2);
    }
  }
}

// Control in the west and nothing else: the sub-blocks without it have no datum, and say so.
TEST(SubBlocks, ASubBlockWithoutControlIsNotAdjusted) {
  BundleSimulationOptions options = LongBlock();
  options.prior = false;
  options.control_photos = {0, 1, 2, 60, 61, 62};
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(kMost));
  EXPECT_TRUE(joined.converged) << "the others have";
  EXPECT_FALSE(Has(joined.findings, Reason::kAdjustmentNotConverged));
  ExpectConsistent(simulation.block, joined);
  ASSERT_EQ(joined.parts.size(), 4u);
  for (std::size_t i = 0; i < joined.photos.size(); ++i) {
    const bool in_west = Column(i) < 15;
    EXPECT_EQ(joined.photos[i].state, in_west ? PhotoState::kAdjusted : PhotoState::kNoDatum);
    const BlockPart& part = joined.parts[static_cast<std::size_t>(joined.photos[i].part)];
    EXPECT_EQ(part.has_datum, in_west);
    EXPECT_EQ(part.by_control, in_west);
    ASSERT_NE(part.finding.has_value(), in_west);
    if (!in_west) {
      EXPECT_EQ(part.finding->reason, Reason::kPartWithoutDatum);
    }
  }
}

// Points at the border to it are those of the sub-block that can be adjusted.
TEST(SubBlocks, WhatASubBlockWithoutControlCannotDetermineItsNeighbourDoes) {
  BundleSimulationOptions options = LongBlock();
  options.prior = false;
  options.control_photos = {57, 58, 59, 117, 118, 119, 3, 9, 15, 22, 30, 37, 44};
  options.control_seen_by_all = true;
  BlockToAdjust block = SimulateBundle(options).block;
  for (BlockPoint& point : block.points)
    point.held_out = point.control && point.control->ground_m.x() < 500000 + 48 * 920.0;
  const BlockResult joined = AdjustWholeOrInSubBlocks(block, AtMost(kMost));
  ExpectConsistent(block, joined);
  std::vector<int> seen(block.points.size(), 0);
  for (const ImageObservation& o : block.observations)
    if (joined.photos[o.photo].state == PhotoState::kAdjusted) ++seen[o.point];
  int with_rays = 0, adjusted = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    with_rays += seen[i] > 1 ? 1 : 0;
    adjusted += seen[i] > 1 && joined.points[i].adjusted ? 1 : 0;
  }
  EXPECT_GT(with_rays, 100);
  EXPECT_GT(adjusted, 0.99 * with_rays);
}

TEST(SubBlocks, WhatAllOfThemLackIsSaidOnceOfTheBlock) {
  BundleSimulationOptions options = LongBlock();
  options.control_photos.clear();
  const BlockResult with_priors =
      AdjustWholeOrInSubBlocks(SimulateBundle(options).block, AtMost(kMost));
  ASSERT_EQ(with_priors.findings.size(), 2u);
  EXPECT_EQ(with_priors.findings[0].reason, Reason::kBlockWithoutControl);
  EXPECT_EQ(with_priors.findings[1].reason, Reason::kAdjustedInSubBlocks);
  options.prior = false;
  const BlockResult without =
      AdjustWholeOrInSubBlocks(SimulateBundle(options).block, AtMost(kMost));
  ASSERT_EQ(without.findings.size(), 2u);
  EXPECT_EQ(without.findings[0].reason, Reason::kBlockWithoutDatum);
}

// Approximations may determine a border's points in one sub-block, control in the other.
TEST(SubBlocks, PointsAreThoseOfTheSubBlockWithControl) {
  BundleSimulationOptions options = LongBlock();
  options.control_photos = {57, 58, 59, 117, 118, 119, 177, 178, 179};
  const BlockToAdjust block = SimulateBundle(options).block;
  const BlockResult joined = AdjustWholeOrInSubBlocks(block, AtMost(kMost));
  const auto by_control = [&](const ImageObservation& o) {
    return joined.parts[static_cast<std::size_t>(joined.photos[o.photo].part)].by_control;
  };
  int at_border = 0;
  for (std::size_t i = 0; i < block.points.size(); ++i) {
    if (block.points[i].control || !joined.points[i].adjusted) continue;
    double residual = 0;
    int with = 0, without = 0;
    for (const ImageObservation& o : block.observations) {
      if (o.point != i) continue;
      (by_control(o) ? with : without) += 1;
      if (!by_control(o)) continue;
      const PhotoView view = AdjustedView(block, joined, o.photo);
      residual =
          std::max(residual, (*view.PixelFromGround(joined.points[i].ground_m) - o.pixel).norm());
    }
    if (with == 0 || without == 0) continue;
    ++at_border;
    EXPECT_LT(residual, 2) << i;
  }
  EXPECT_GT(at_border, 20);
}

// Whether ties could show an error of a photo's control is asked of its own sub-block.
TEST(SubBlocks, ControlOfOtherSubBlocksIsNotCounted) {
  BundleSimulationOptions options = LongBlock();  // with approximations as observations
  options.control_photos = {0, 1, 2, 60, 61, 62};
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(kMost));
  const auto part_of = [&](std::size_t photo) {
    return joined.parts[static_cast<std::size_t>(joined.photos[photo].part)];
  };
  EXPECT_TRUE(part_of(0).by_control);
  EXPECT_EQ(joined.photos[kInStrip - 1].state, PhotoState::kAdjusted);
  EXPECT_FALSE(part_of(kInStrip - 1).by_control);
  EXPECT_EQ(part_of(kInStrip - 1).control_points, 0);
  EXPECT_EQ(part_of(kInStrip - 1).finding->reason, Reason::kPartWithoutControl);
}

TEST(SubBlocks, UnconnectedPartsStayApart) {
  BundleSimulation simulation = SimulateBundle(LongBlock());
  BlockToAdjust& block = simulation.block;
  // Nothing connects columns 25 and 26.
  for (std::size_t i = 0; i < block.points.size(); ++i) {
    std::vector<std::size_t> east;
    bool west = false;
    for (std::size_t k = 0; k < block.observations.size(); ++k) {
      if (block.observations[k].point != i) continue;
      if (Column(block.observations[k].photo) > 25)
        east.push_back(k);
      else
        west = true;
    }
    if (!west) continue;
    for (auto k = east.rbegin(); k != east.rend(); ++k)
      block.observations.erase(block.observations.begin() + static_cast<std::ptrdiff_t>(*k));
  }
  BlockPhoto lost = block.photos[0];
  lost.name = "lost";
  lost.prior.reset();
  block.photos.push_back(lost);
  const BlockResult joined = AdjustWholeOrInSubBlocks(block, AtMost(kMost));
  ExpectConsistent(block, joined);
  EXPECT_TRUE(joined.converged);
  EXPECT_EQ(joined.photos.back().state, PhotoState::kUndetermined);
  EXPECT_TRUE(Has(joined.findings, Reason::kPartNotConnected));
  for (std::size_t i = 0; i + 1 < block.photos.size(); ++i) {
    EXPECT_EQ(joined.photos[i].state, PhotoState::kAdjusted);
    for (const std::size_t other :
         joined.parts[static_cast<std::size_t>(joined.photos[i].part)].photos)
      EXPECT_EQ(Column(other) > 25, Column(i) > 25) << i << " and " << other;
  }
}

// A strip that borders cut has a shift in every sub-block.
TEST(SubBlocks, AStripsShiftIsThatOfTheSubBlockWithMostOfItsPositions) {
  BundleSimulationOptions options = LongBlock();
  options.gnss_sigma_m = 0.05;
  BundleSimulation simulation = SimulateBundle(options);
  const Eigen::Vector3d east_m(4, 0, 0);
  for (std::size_t i = 0; i < simulation.block.photos.size(); ++i) {
    // The easternmost sub-block has ten positions of each strip in its core, others fifteen.
    if (Column(i) >= 50)
      simulation.block.photos[i].gnss->position_m += east_m;
    else if (Column(i) >= 37)
      simulation.block.photos[i].gnss.reset();
  }
  BlockOptions how = AtMost(kMost);
  how.gnss = GnssModel::kShift;
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, how);
  ASSERT_EQ(joined.strips.size(), 3u);
  for (const StripGnss& strip : joined.strips) EXPECT_LT(strip.shift_m.norm(), 0.5);
}

TEST(SubBlocks, ACommonShiftOfGnssIsToldOfThePositionsThatShowIt) {
  BundleSimulationOptions options = LongBlock();
  options.gnss_sigma_m = 0.05;
  options.gnss_shift_m = {0.6, -0.4, 0.5};
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(kMost));
  ASSERT_EQ(joined.strips.size(), 1u);
  EXPECT_TRUE(joined.strips[0].of_all);
  EXPECT_LE(joined.strips[0].observed, static_cast<int>(kMost));
  const auto finding =
      std::find_if(joined.findings.begin(), joined.findings.end(),
                   [](const Finding& f) { return f.reason == Reason::kGnssPerhapsOfAnotherDatum; });
  ASSERT_NE(finding, joined.findings.end());
  EXPECT_EQ(finding->limit, joined.strips[0].observed);
}

TEST(SubBlocks, OneThatDoesNotConvergeIsNotPassedOver) {
  BundleSimulation simulation = SimulateBundle(LongBlock());
  BlockOptions how = AtMost(kMost);
  how.max_rounds = 1;
  while (!AdjustWholeOrInSubBlocks(simulation.block, how).converged) {
    ASSERT_LT(how.max_rounds, 10);
    ++how.max_rounds;
  }
  // In the east it needs more rounds than that.
  std::mt19937 random(1);
  std::normal_distribution<double> off(0, 20);
  for (ImageObservation& o : simulation.block.observations)
    if (Column(o.photo) > 50 && random() % 4 == 0)
      o.pixel += Eigen::Vector2d(off(random), off(random));
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, how);
  EXPECT_FALSE(joined.converged);
  EXPECT_EQ(joined.findings.front().reason, Reason::kAdjustmentNotConverged);
}

// The deformation of a source is that of all of its control, whichever part a sub-block has.
TEST(SubBlocks, ASourcesErrorIsNotTakenForSmaller) {
  BundleSimulationOptions options = LongBlock();
  options.source_sigma_m = 0.3;
  options.prior = false;
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult whole = AdjustBlock(simulation.block);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(kMost));
  double least = 2;
  for (std::size_t i = 0; i < whole.photos.size(); ++i)
    least = std::min(
        least, std::sqrt(joined.photos[i].covariance(0, 0) / whole.photos[i].covariance(0, 0)));
  EXPECT_GT(least, 0.95);
}

TEST(SubBlocks, BadInputIsRefused) {
  BundleSimulation simulation = SimulateBundle(LongBlock());
  BlockOptions how = AtMost(kMost);
  how.self_calibration = true;
  EXPECT_THROW(AdjustWholeOrInSubBlocks(simulation.block, how), std::invalid_argument);
  EXPECT_THROW(AdjustWholeOrInSubBlocks(simulation.block, AtMost(0)), std::invalid_argument);
  simulation.block.observations[0].photo = 999;
  EXPECT_THROW(AdjustWholeOrInSubBlocks(simulation.block, AtMost(kMost)), std::invalid_argument);
}

}  // namespace
}  // namespace orient::block

// Time of the block adjustment compared with that of Ceres' solver alone, and how both grow:
//   block_speed [--ties N] [--sub-blocks N] [PHOTOS...]        default: 100 300 1000
// With --sub-blocks, also how much worse poses from sub-blocks of at most N photos are than those
// of the whole block: errors (RMS), stated standard deviations (mean and largest ratio), memory,
// and time. Simulated blocks of film photos with 60/30 % overlap, 100 (or N) new ties per photo,
// control under every tenth photo, 1 % gross errors; precisions as stated by `orient block`. Times
// are wall-clock times with one thread, that of Ceres as it reports it; the ratio is that of all
// rounds together, including the tests of the observations, to Ceres.
#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <vector>

#include "block/bundle/sub_blocks.h"
#include "tools/bench/bundle_simulation.h"

namespace {

orient::BundleSimulationOptions BlockOf(int photos, int ties_per_photo) {
  orient::BundleSimulationOptions options;
  options.strips = std::max(1, static_cast<int>(std::sqrt(photos / 2.5)));
  options.photos_in_strip = photos / options.strips;
  options.ties_per_photo = ties_per_photo;
  options.control_photos.clear();
  for (int i = 0; i < options.strips * options.photos_in_strip; i += 10)
    options.control_photos.push_back(i);
  options.gross_ties = options.gross_control = 0.01;
  return options;
}

double PeakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

struct InSubBlocks {
  orient::block::BlockResult result;
  double memory_mb = 0;
};

InSubBlocks AdjustInSubBlocks(const orient::block::BlockToAdjust& block,
                              orient::block::BlockOptions options, int most_photos,
                              double before_mb) {
  options.most_photos = static_cast<std::size_t>(most_photos);
  InSubBlocks divided{orient::block::AdjustWholeOrInSubBlocks(block, options)};
  divided.memory_mb = PeakMegabytes() - before_mb;
  return divided;
}

// RMS of the position errors, m.
double PositionError(const orient::BundleSimulation& simulation,
                     const orient::block::BlockResult& result) {
  double sum = 0;
  for (std::size_t i = 0; i < result.photos.size(); ++i)
    sum += (result.photos[i].pose.position_m - simulation.true_poses[i].position_m).squaredNorm();
  return std::sqrt(sum / static_cast<double>(result.photos.size()));
}

void Compare(const orient::BundleSimulation& simulation, const orient::block::BlockResult& whole,
             const InSubBlocks& divided) {
  const orient::block::BlockResult& joined = divided.result;
  if (!joined.sub_blocks) return;
  double mean = 0, worst = 0;
  for (std::size_t i = 0; i < joined.photos.size(); ++i) {
    const orient::Vector6d ratio = joined.photos[i]
                                       .covariance.diagonal()
                                       .cwiseQuotient(whole.photos[i].covariance.diagonal())
                                       .cwiseSqrt();
    mean += ratio.mean() / static_cast<double>(joined.photos.size());
    worst = std::max(worst, ratio.maxCoeff());
  }
  const auto& t = joined.timings;
  const double seconds = t.setup + t.solve + t.snooping + t.covariance;
  std::printf(
      "  in %d sub-blocks: positions %.4f m (whole %.4f), sigmas %.4f (mean), %.3f (largest) "
      "of the whole's, %d poses beside borders differ by %.3f sigma; %.0f MB, %.0f s\n",
      joined.sub_blocks->count, PositionError(simulation, joined), PositionError(simulation, whole),
      mean, worst, joined.sub_blocks->compared, joined.sub_blocks->differences, divided.memory_mb,
      seconds);
}

void Measure(int photos, int ties_per_photo, int sub_blocks) {
  const auto simulation = orient::SimulateBundle(BlockOf(photos, ties_per_photo));
  malloc_trim(0);
  const double before_mb = PeakMegabytes();
  orient::block::BlockOptions options;
  options.least_precision_factor = 1;
  std::optional<InSubBlocks> divided;  // first, because peaks of memory never fall
  if (sub_blocks > 0) divided = AdjustInSubBlocks(simulation.block, options, sub_blocks, before_mb);
  const orient::block::BlockResult result = orient::block::AdjustBlock(simulation.block, options);
  const auto& t = result.timings;
  const double total = t.solve + t.snooping;
  double worst_mm = 0;
  int ties = 0, rejected = 0, gross = 0;
  for (std::size_t i = 0; i < result.points.size(); ++i)
    if (result.points[i].adjusted && !simulation.block.points[i].control) ++ties;
  for (std::size_t i = 0; i < simulation.gross.size(); ++i) {
    gross += simulation.gross[i] ? 1 : 0;
    rejected += result.observations[i].state == orient::block::ObservationState::kRejected ? 1 : 0;
  }
  for (std::size_t i = 0; i < result.photos.size(); ++i)
    worst_mm = std::max(
        worst_mm,
        1e3 * (result.photos[i].pose.position_m - simulation.true_poses[i].position_m).norm());
  std::printf("%6zu %8d %9zu %8.2f %8.2f %9.2f %8.2f %7.2f %6d %6d %8.0f %8.0f %6d/%d\n",
              simulation.block.photos.size(), ties, simulation.gross.size(), t.setup, t.ceres,
              t.snooping, t.covariance, total / t.ceres, t.solves, t.iterations,
              PeakMegabytes() - before_mb, worst_mm, rejected, gross);
  if (divided) Compare(simulation, result, *divided);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes;
  int ties_per_photo = 100, sub_blocks = 0;
  for (int i = 1; i < argc; ++i)
    if (std::string_view(argv[i]) == "--ties" && i + 1 < argc)
      ties_per_photo = std::atoi(argv[++i]);
    else if (std::string_view(argv[i]) == "--sub-blocks" && i + 1 < argc)
      sub_blocks = std::atoi(argv[++i]);
    else
      sizes.push_back(std::atoi(argv[i]));
  if (ties_per_photo < 1 || std::any_of(sizes.begin(), sizes.end(), [](int n) { return n < 1; })) {
    std::fprintf(stderr, "usage: block_speed [--ties N] [--sub-blocks N] [PHOTOS...]\n");
    return 1;
  }
  if (sizes.empty()) sizes = {100, 300, 1000};
  std::printf(
      "photos     ties      rays   setup_s  ceres_s snooping_s covar_s  ratio solves iterat. "
      "memory_MB worst_mm rejected/gross\n");
  for (const int photos : sizes) Measure(photos, ties_per_photo, sub_blocks);
  return 0;
}

// Trends in the residuals of a pose: what no single residual shows and all of them together do.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace orient::exterior {

// Shift, scale and rotation of all residuals are nearly parameters of the pose: what remains of
// them shows per source. Radial: with the cube of the distance from the centre, as errors of a lens
// or heights act. Quadrants: each shifted by itself.
enum class TrendKind { kShift, kScale, kRotation, kRadial, kQuadrants };

struct ResidualTrend {
  TrendKind kind = TrendKind::kShift;
  std::optional<std::int64_t> source = {};  // whose residuals alone have it; absent: all have
  double rms_px = 0;                        // of the trend in one coordinate, over its places
};

struct TrendInput {
  std::vector<Eigen::Vector2d> pixels, residuals_px;
  std::vector<std::int64_t> sources;
};

// Those that residuals without trends, independent and as large as these, would show less often
// than once in a thousand photos (chi-square tests of their least-squares fits, Bonferroni over all
// of them), and that amount to a twentieth of a pixel at least; the largest first. Fewer than 30
// residuals, of all or of a source, are not tested.
std::vector<ResidualTrend> FindTrends(const TrendInput& input);

}  // namespace orient::exterior

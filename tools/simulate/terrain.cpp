#include "tools/simulate/terrain.h"

#include "tools/simulate/noise.h"

namespace orient::simulation {
namespace {

// Amplitude falls faster than the wavelength: hills, but fields smooth enough to plough.
constexpr double kRoughness = 1.15;

double RawHeight(double x, double y, const TerrainOptions& options) {
  double sum = 0;
  std::uint32_t octave = 0;
  for (double wave = options.longest_wave_m; wave > 4 * options.cell_m; wave /= 2, ++octave) {
    const double weight = std::pow(wave / options.longest_wave_m, kRoughness);
    sum += weight * static_cast<double>(ValueNoise(options.seed + octave,
                                                   static_cast<float>(std::fmod(x, 1e6) / wave),
                                                   static_cast<float>(std::fmod(y, 1e6) / wave)));
  }
  return sum;
}

}  // namespace

Terrain::Terrain(Eigen::MatrixXf heights_m, double west_m, double north_m, double cell_m)
    : heights_(std::move(heights_m)), west_(west_m), north_(north_m), cell_(cell_m) {}

Terrain Terrain::Make(const Bounds& extent, const TerrainOptions& options) {
  const double west = std::floor(extent.min_x / options.cell_m) * options.cell_m;
  const double north = std::ceil(extent.max_y / options.cell_m) * options.cell_m;
  const auto cols = static_cast<Eigen::Index>(std::ceil((extent.max_x - west) / options.cell_m));
  const auto rows = static_cast<Eigen::Index>(std::ceil((north - extent.min_y) / options.cell_m));
  Eigen::MatrixXd raw(rows, cols);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const double y = north - (static_cast<double>(row) + 0.5) * options.cell_m;
    for (Eigen::Index col = 0; col < cols; ++col)
      raw(row, col) =
          RawHeight(west + (static_cast<double>(col) + 0.5) * options.cell_m, y, options);
  }
  const double low = raw.minCoeff(), range = raw.maxCoeff() - low;
  const double scale = range > 0 ? options.relief_m / range : 0;
  const Eigen::MatrixXd heights =
      (raw.array() - low) * scale + (options.mean_height_m - 0.5 * options.relief_m);
  return Terrain(heights.cast<float>(), west, north, options.cell_m);
}

double Terrain::Bilinear(const Eigen::MatrixXf& grid, double x_m, double y_m) const {
  const double last_col = static_cast<double>(grid.cols() - 1);
  const double last_row = static_cast<double>(grid.rows() - 1);
  const double col = std::clamp((x_m - west_) / cell_ - 0.5, 0.0, last_col);
  const double row = std::clamp((north_ - y_m) / cell_ - 0.5, 0.0, last_row);
  const auto i =
      std::min(static_cast<Eigen::Index>(col), std::max<Eigen::Index>(grid.cols() - 2, 0));
  const auto j =
      std::min(static_cast<Eigen::Index>(row), std::max<Eigen::Index>(grid.rows() - 2, 0));
  const Eigen::Index i1 = std::min(i + 1, grid.cols() - 1), j1 = std::min(j + 1, grid.rows() - 1);
  const double fx = col - static_cast<double>(i), fy = row - static_cast<double>(j);
  const double a = grid(j, i), b = grid(j, i1), c = grid(j1, i), d = grid(j1, i1);
  const double top = a + fx * (b - a), bottom = c + fx * (d - c);
  return top + fy * (bottom - top);
}

Eigen::MatrixXf Terrain::Shading(const Eigen::Vector3d& sun) const {
  const Eigen::Index rows = heights_.rows(), cols = heights_.cols();
  Eigen::MatrixXf shading(rows, cols);
  for (Eigen::Index row = 0; row < rows; ++row)
    for (Eigen::Index col = 0; col < cols; ++col) {
      const Eigen::Index w = std::max<Eigen::Index>(col - 1, 0), e = std::min(col + 1, cols - 1);
      const Eigen::Index n = std::max<Eigen::Index>(row - 1, 0), s = std::min(row + 1, rows - 1);
      const double dx = static_cast<double>(std::max<Eigen::Index>(e - w, 1)) * cell_;
      const double dy = static_cast<double>(std::max<Eigen::Index>(s - n, 1)) * cell_;
      const double gx = static_cast<double>(heights_(row, e) - heights_(row, w)) / dx;
      const double gy = static_cast<double>(heights_(n, col) - heights_(s, col)) / dy;
      const Eigen::Vector3d normal = Eigen::Vector3d(-gx, -gy, 1).normalized();
      shading(row, col) = static_cast<float>(std::clamp(normal.dot(sun) / sun.z(), 0.35, 1.5));
    }
  return shading;
}

double Terrain::MaxSlope() const {
  double steepest = 0;
  for (Eigen::Index row = 0; row < heights_.rows(); ++row)
    for (Eigen::Index col = 0; col < heights_.cols(); ++col) {
      const double z = heights_(row, col);
      if (col + 1 < heights_.cols())
        steepest = std::max(steepest, std::abs(static_cast<double>(heights_(row, col + 1)) - z));
      if (row + 1 < heights_.rows())
        steepest = std::max(steepest, std::abs(static_cast<double>(heights_(row + 1, col)) - z));
    }
  return steepest / cell_;
}

}  // namespace orient::simulation

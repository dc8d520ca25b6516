#include "core/terrain/ground_surface.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/terrain/dem_grid.h"
#include "core/terrain/dem_raster.h"
#include "core/terrain/grid_mapping.h"
#include "core/terrain/map_scale.h"

namespace orient {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Bounds kNothing = {kInfinity, kInfinity, -kInfinity, -kInfinity};
constexpr int kAlong = 20;  // steps along a rectangle's side where its outline is transformed

void Enclose(const Eigen::Vector2d& point, Bounds* bounds) {
  bounds->min_x = std::min(bounds->min_x, point.x());
  bounds->min_y = std::min(bounds->min_y, point.y());
  bounds->max_x = std::max(bounds->max_x, point.x());
  bounds->max_y = std::max(bounds->max_y, point.y());
}

// The bounds of a rectangle's image; of its inside too, since a curved outline may bend inwards.
template <class Map>
Bounds BoundsOfImage(const Bounds& rectangle, Map map) {
  Bounds image = kNothing;
  for (int j = 0; j <= kAlong; ++j) {
    for (int i = 0; i <= kAlong; ++i) {
      const Eigen::Vector2d point(
          rectangle.min_x + (rectangle.max_x - rectangle.min_x) * i / kAlong,
          rectangle.min_y + (rectangle.max_y - rectangle.min_y) * j / kAlong);
      const std::optional<Eigen::Vector2d> mapped = map(point);
      if (mapped) Enclose(*mapped, &image);
    }
  }
  return image;
}

std::string Text(const Bounds& bounds) {
  return fmt::format("x {:.0f} ... {:.0f}, y {:.0f} ... {:.0f}", bounds.min_x, bounds.max_x,
                     bounds.min_y, bounds.max_y);
}

struct Window {
  int column, row, columns, rows;
};

// The window of nodes around `nodes`, with a border; empty where there are fewer than 2 x 2.
std::optional<Window> WindowAround(const Bounds& nodes, const DemRaster& dem) {
  if (!(nodes.min_x <= nodes.max_x)) return std::nullopt;
  // The outline was sampled: between the samples it may bend by a small part of the window.
  const double border = 2 + 0.002 * std::max(nodes.max_x - nodes.min_x, nodes.max_y - nodes.min_y);
  const auto inside = [border](double value, double sign, int size) {
    return static_cast<int>(std::clamp(std::floor(value + sign * border), 0.0, size - 1.0));
  };
  Window window;
  window.column = inside(nodes.min_x, -1, dem.Columns());
  window.row = inside(nodes.min_y, -1, dem.Rows());
  window.columns = inside(nodes.max_x, 1, dem.Columns()) - window.column + 1;
  window.rows = inside(nodes.max_y, 1, dem.Rows()) - window.row + 1;
  const bool beside = nodes.max_x < 0 || nodes.max_y < 0 || nodes.min_x > dem.Columns() - 1 ||
                      nodes.min_y > dem.Rows() - 1;
  if (beside || window.columns < 2 || window.rows < 2) return std::nullopt;
  return window;
}

// In memory if it is small, otherwise tile by tile: neighbouring points hardly ever need
// another tile.
DemGrid GridOf(std::shared_ptr<const DemRaster> dem, const Window& window) {
  constexpr std::int64_t kMostInMemory = std::int64_t{1} << 24;  // nodes; 64 MB
  if (std::int64_t{window.columns} * window.rows <= kMostInMemory)
    return {dem->Read(window.column, window.row, window.columns, window.rows), window.columns,
            window.rows};
  const auto read = [dem = std::move(dem), window](int column, int row, int columns, int rows) {
    return dem->Read(window.column + column, window.row + row, columns, rows);
  };
  return {read, window.columns, window.rows};
}

// Exact transformation between DEM nodes and the block's ground, by PROJ if the CRSs differ.
class DemFrame {
 public:
  DemFrame(const std::string& path, const DemRaster& dem, const Crs& block_crs)
      : node_from_dem_(dem.NodeFromDem()), dem_from_node_(dem.NodeFromDem().Inverse()) {
    if (SameHorizontalCrs(dem.Wkt(), block_crs.Wkt())) return;
    try {
      dem_from_block_ = CoordinateTransform::Between(dem.Wkt(), block_crs.Wkt());
      block_from_dem_ = CoordinateTransform::Between(block_crs.Wkt(), dem.Wkt());
      full_turn_ = FullTurnOf(dem.Wkt());
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}; reproject the DEM with gdalwarp", path, error.what()));
    }
  }

  // Longitudes may be counted from 0 to 360 in the DEM and from -180 to 180 by PROJ, or otherwise:
  // from now on they are those of the DEM at this place.
  void CountAsAt(const Eigen::Vector2d& xy, const DemRaster& dem) {
    const auto in_dem = full_turn_ ? (*dem_from_block_)(xy) : std::nullopt;
    if (!in_dem) return;
    const Eigen::Vector2d middle =
        dem_from_node_ * (0.5 * Eigen::Vector2d(dem.Columns(), dem.Rows()));
    turn_ = *full_turn_ * std::round((middle.x() - in_dem->x()) / *full_turn_);
  }

  std::optional<Eigen::Vector2d> NodeFromBlock(const Eigen::Vector2d& xy) const {
    const auto in_dem = dem_from_block_ ? (*dem_from_block_)(xy) : std::optional(xy);
    if (!in_dem) return std::nullopt;
    return node_from_dem_ * Eigen::Vector2d(in_dem->x() + turn_, in_dem->y());
  }

  std::optional<Eigen::Vector2d> BlockFromNode(const Eigen::Vector2d& node) const {
    const Eigen::Vector2d in_dem = dem_from_node_ * node - Eigen::Vector2d(turn_, 0);
    return block_from_dem_ ? (*block_from_dem_)(in_dem) : std::optional(in_dem);
  }

  // Into the nodes of a window whose first node is `corner`; empty where that cannot be tabulated.
  std::optional<GridMapping> MappingTo(const Eigen::Vector2d& corner, const Bounds& extent) const {
    if (!dem_from_block_) {
      Affine2d node_from_block = node_from_dem_;
      node_from_block.t -= corner;
      return GridMapping(node_from_block);
    }
    if (extent.Empty()) return std::nullopt;
    const auto exact = [&](const Eigen::Vector2d& xy) {
      auto node = NodeFromBlock(xy);
      if (node) *node -= corner;
      return node;
    };
    return GridMapping::Tabulate(exact, extent);
  }

 private:
  Affine2d node_from_dem_, dem_from_node_;
  std::optional<CoordinateTransform> dem_from_block_, block_from_dem_;  // empty: the same CRS
  std::optional<double> full_turn_;  // of a geographic DEM, in its unit
  double turn_ = 0;                  // added to PROJ's longitudes
};

}  // namespace

struct GroundSurface::Impl {
  DemGrid grid;
  GridMapping mapping;
  Bounds extent;
  double cell_m;

  std::optional<std::pair<double, double>> Clip(const Ray& ray) const;
  std::optional<Eigen::Vector3d> Intersect(const Ray& ray) const;
};

GroundSurface::GroundSurface(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GroundSurface::GroundSurface(GroundSurface&&) noexcept = default;
GroundSurface& GroundSurface::operator=(GroundSurface&&) noexcept = default;
GroundSurface::~GroundSurface() = default;

GroundSurface GroundSurface::FromFile(const std::string& path, const Crs& block_crs,
                                      const std::optional<Bounds>& bounds) {
  auto raster = std::make_shared<const DemRaster>(path);
  const DemRaster& dem = *raster;
  DemFrame frame(path, dem, block_crs);
  const auto middle = bounds
                          ? std::optional<Eigen::Vector2d>({0.5 * (bounds->min_x + bounds->max_x),
                                                            0.5 * (bounds->min_y + bounds->max_y)})
                          : frame.BlockFromNode(0.5 * Eigen::Vector2d(dem.Columns(), dem.Rows()));
  if (middle) frame.CountAsAt(*middle, dem);
  const auto node_from_block = [&](const Eigen::Vector2d& xy) { return frame.NodeFromBlock(xy); };
  const auto block_from_node = [&](const Eigen::Vector2d& uv) { return frame.BlockFromNode(uv); };

  const Bounds all = {0, 0, dem.Columns() - 1.0, dem.Rows() - 1.0};
  const auto window_of = [&](const Bounds& region) {
    return WindowAround(BoundsOfImage(region, node_from_block), dem);
  };
  const auto window = bounds ? window_of(*bounds) : WindowAround(all, dem);
  const std::string region = bounds ? Text(*bounds) : "enough nodes for a surface";
  if (!window) {
    const bool exchanged =
        bounds && window_of({bounds->min_y, bounds->min_x, bounds->max_y, bounds->max_x});
    throw InputError(fmt::format(
        "{}: the DEM covers {} of the block's CRS and not {}; {}", path,
        Text(BoundsOfImage(all, block_from_node)), region,
        exchanged ? "with x and y exchanged it does: are easting and northing swapped in the "
                    "positions that locate the photos?"
                  : "give a DEM of the block's region"));
  }
  DemGrid grid = GridOf(std::move(raster), *window);
  if (!std::isfinite(grid.Min()))
    throw InputError(path + ": the DEM has no heights, only nodata, in the region asked for (" +
                     region + "); give a DEM of the block's region");

  const Eigen::Vector2d corner(window->column, window->row);
  const Bounds extent = BoundsOfImage(
      {corner.x(), corner.y(), corner.x() + window->columns - 1, corner.y() + window->rows - 1},
      block_from_node);
  RefuseFalseScale(block_crs, extent);  // here, as every command that uses heights calls this
  const auto mapping = frame.MappingTo(corner, extent);
  if (!mapping)
    throw InputError(path +
                     ": the DEM's CRS is too curved relative to the block's; reproject the "
                     "DEM with gdalwarp to " +
                     block_crs.Name());
  const double cell_m =
      mapping->CellSizeAt(0.5 * (extent.min_x + extent.max_x), 0.5 * (extent.min_y + extent.max_y));
  return GroundSurface(std::make_unique<Impl>(Impl{std::move(grid), *mapping, extent, cell_m}));
}

GroundSurface GroundSurface::FromGrid(const Eigen::MatrixXf& heights_m, double west_m,
                                      double north_m, double cell_m) {
  if (!(cell_m > 0)) throw std::invalid_argument("the cell size of a height grid must be positive");
  const int columns = static_cast<int>(heights_m.cols()), rows = static_cast<int>(heights_m.rows());
  std::vector<float> heights;
  heights.reserve(static_cast<std::size_t>(heights_m.size()));
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) heights.push_back(heights_m(row, column));
  Affine2d node_from_block;
  node_from_block.A = Eigen::Vector2d(1 / cell_m, -1 / cell_m).asDiagonal();
  node_from_block.t = {-west_m / cell_m - 0.5, north_m / cell_m - 0.5};
  const Bounds extent = {west_m + 0.5 * cell_m, north_m - (rows - 0.5) * cell_m,
                         west_m + (columns - 0.5) * cell_m, north_m - 0.5 * cell_m};
  return GroundSurface(std::make_unique<Impl>(Impl{DemGrid(std::move(heights), columns, rows),
                                                   GridMapping(node_from_block), extent, cell_m}));
}

std::optional<double> GroundSurface::HeightAt(double x_m, double y_m) const {
  const Eigen::Vector2d node = impl_->mapping.NodeFromBlock(x_m, y_m);
  return impl_->grid.HeightAt(node.x(), node.y());
}

std::optional<Eigen::Vector3d> GroundSurface::Intersect(const Ray& ray) const {
  if (!ray.origin_m.allFinite() || !ray.direction.allFinite() || ray.direction.z() > 0)
    return std::nullopt;
  return impl_->Intersect(ray);
}

// The t of the ray between the highest and the lowest ground, within the DEM's extent.
std::optional<std::pair<double, double>> GroundSurface::Impl::Clip(const Ray& ray) const {
  constexpr double kMargin_m = 1.0;
  const Eigen::Vector3d low(extent.min_x, extent.min_y, grid.Min());
  const Eigen::Vector3d high(extent.max_x, extent.max_y, grid.Max());
  double begin = 0, end = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double to_low = low[axis] - kMargin_m - ray.origin_m[axis];
    const double to_high = high[axis] + kMargin_m - ray.origin_m[axis];
    const double speed = ray.direction[axis];
    if (speed == 0 && (to_low > 0 || to_high < 0)) return std::nullopt;
    if (speed == 0) continue;
    begin = std::max(begin, std::min(to_low / speed, to_high / speed));
    end = std::min(end, std::max(to_low / speed, to_high / speed));
  }
  if (!(begin <= end) || !std::isfinite(end)) return std::nullopt;
  return std::pair(begin, end);
}

std::optional<Eigen::Vector3d> GroundSurface::Impl::Intersect(const Ray& ray) const {
  const auto clipped = Clip(ray);
  if (!clipped) return std::nullopt;
  const auto [begin, end] = *clipped;
  const Eigen::Vector3d &origin = ray.origin_m, &direction = ray.direction;
  const double length_m = (end - begin) * direction.head<2>().norm();
  const int pieces = std::max(1, static_cast<int>(std::ceil(length_m / mapping.StraightLength())));
  DemGrid::Side side = DemGrid::Side::kUnknown;
  const auto node_at = [&](double t) {
    return mapping.NodeFromBlock(origin.x() + t * direction.x(), origin.y() + t * direction.y());
  };
  Eigen::Vector2d from = node_at(begin);
  for (int i = 0; i < pieces; ++i) {
    // Each piece counts its own t from its beginning: coordinates stay small.
    const double t0 = begin + (end - begin) * i / pieces;
    const double t1 = begin + (end - begin) * (i + 1) / pieces;
    const Eigen::Vector2d to = node_at(t1);
    const Eigen::Vector2d speed =
        t1 > t0 ? Eigen::Vector2d((to - from) / (t1 - t0)) : Eigen::Vector2d::Zero();
    const GridRay piece = {from.x(),  from.y(),  origin.z() + t0 * direction.z(),
                           speed.x(), speed.y(), direction.z(),
                           0,         t1 - t0};
    if (from.allFinite() && to.allFinite()) {
      if (const auto t = grid.Trace(piece, &side)) return origin + (t0 + *t) * direction;
    } else {
      side = DemGrid::Side::kUnknown;
    }
    if (side == DemGrid::Side::kBelow) return std::nullopt;
    from = to;
  }
  return std::nullopt;
}

double GroundSurface::MinHeight() const { return impl_->grid.Min(); }
double GroundSurface::MaxHeight() const { return impl_->grid.Max(); }
double GroundSurface::MeanHeight() const { return impl_->grid.Mean(); }
double GroundSurface::CellSize() const { return impl_->cell_m; }
double GroundSurface::CellAlongX() const {
  const Bounds& extent = impl_->extent;
  return impl_->mapping.CellAlongXAt(0.5 * (extent.min_x + extent.max_x),
                                     0.5 * (extent.min_y + extent.max_y));
}
Bounds GroundSurface::Extent() const { return impl_->extent; }

}  // namespace orient

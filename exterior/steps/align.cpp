#include "exterior/steps/align.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "exterior/steps/pixel_lattice.h"

namespace orient::exterior {
namespace {

// Chip positions are exact on a lattice and interpolated linearly between its nodes. Heights are
// several pixels apart, so nothing is lost, and the lens inverse is not called for every sample.
constexpr double kLatticeStep = 2.0;
constexpr int kMaxRayIterations = 12;
constexpr int kMaxSupersampling = 32;

// East and north offset from the patch's point at which a scan pixel's ray meets the patch's
// heights. Fixed-point iteration on the height; converges where the ray is steeper than the slope.
std::optional<Eigen::Vector2d> OffsetAt(const PhotoView& view, const patchdb::Patch& patch,
                                        const Eigen::Vector2d& pixel) {
  const auto ray = GroundRayFromPhoto(view.camera, view.pose, view.PhotoFromPixel(pixel));
  if (!ray || ray->direction.z() >= -1e-3) return std::nullopt;
  double height = patch.ground_m.z();
  Eigen::Vector2d offset;
  for (int i = 0; i < kMaxRayIterations; ++i) {
    const Eigen::Vector3d point =
        ray->origin_m + ray->direction * ((height - ray->origin_m.z()) / ray->direction.z());
    offset = point.head<2>() - patch.ground_m.head<2>();
    const double next = patch.heights.At(offset.x(), offset.y());
    if (std::isnan(next)) return std::nullopt;
    if (std::abs(next - height) < 1e-3 * patch.gsd_m) return offset;
    height = next;
  }
  return offset;
}

Eigen::Vector2d ChipFromOffset(const patchdb::Patch& patch, const Eigen::Vector2d& offset) {
  return {patch.chip.width / 2.0 + offset.x() / patch.gsd_m,
          patch.chip.height / 2.0 - offset.y() / patch.gsd_m};
}

// Where a patch's point lies in the scan, and d chip / d scan pixel there.
struct PatchInScan {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d chip_per_pixel;
};

// Empty where the point is not seen.
std::optional<PatchInScan> InScan(const PhotoView& view, const patchdb::Patch& patch) {
  const auto pixel = view.PixelFromGround(patch.ground_m);
  if (!pixel) return std::nullopt;
  PatchInScan in_scan{*pixel, {}};
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = Eigen::Vector2d::Unit(axis);
    const auto ahead = OffsetAt(view, patch, *pixel + step);
    const auto behind = OffsetAt(view, patch, *pixel - step);
    if (!ahead || !behind) return std::nullopt;
    in_scan.chip_per_pixel.col(axis) =
        (ChipFromOffset(patch, *ahead) - ChipFromOffset(patch, *behind)) / 2;
  }
  return in_scan;
}

// Without the outermost pixel on each side, which is left to interpolation.
double ChipSide(const patchdb::Patch& patch) {
  return std::min(patch.chip.width, patch.chip.height) - 2.0;
}

// Side of the largest square, in image pixels, that the chip covers.
double SideOf(const patchdb::Patch& patch, const Eigen::Matrix2d& chip_per_pixel) {
  return ChipSide(patch) / chip_per_pixel.cwiseAbs().rowwise().sum().maxCoeff();
}

AlignedPatch Draw(const PhotoView& view, const patchdb::Patch& patch, const PatchInScan& in_scan,
                  double reduction, int side) {
  const Eigen::Matrix2d chip_per_pixel = in_scan.chip_per_pixel * reduction;
  const double chip_per_side = chip_per_pixel.colwise().norm().mean();
  const int samples = SamplesOfPixel(chip_per_side, kMaxSupersampling);

  AlignedPatch aligned;
  aligned.reduction = reduction;
  aligned.predicted_px = in_scan.pixel;
  aligned.image = Image(side, side, kNoData);
  const Eigen::Vector2d origin = in_scan.pixel - Eigen::Vector2d::Constant(reduction * side / 2.0);
  const PixelLattice lattice(
      side, kLatticeStep, [&](const Eigen::Vector2d& pixels) -> std::optional<Eigen::Vector2d> {
        const auto offset = OffsetAt(view, patch, origin + reduction * pixels);
        if (!offset) return std::nullopt;
        return ChipFromOffset(patch, *offset);
      });
  const auto in_chip = [&](double col, double row) { return lattice.At(col, row); };
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col)
      aligned.image.At(col, row) = MeanOverPixel(patch.chip, col, row, samples, in_chip);
  return aligned;
}

}  // namespace

std::optional<double> PatchSide(const PhotoView& view, const patchdb::Patch& patch) {
  const auto in_scan = InScan(view, patch);
  if (!in_scan) return std::nullopt;
  return SideOf(patch, in_scan->chip_per_pixel);
}

std::optional<double> PatchPixel(const PhotoView& view, const patchdb::Patch& patch) {
  const auto in_scan = InScan(view, patch);
  if (!in_scan) return std::nullopt;
  return 1 / std::sqrt(std::abs(in_scan->chip_per_pixel.determinant()));
}

std::optional<AlignedPatch> AlignPatch(const PhotoView& view, const patchdb::Patch& patch,
                                       double reduction, int min_side, int max_side) {
  const auto in_scan = InScan(view, patch);
  if (!in_scan) return std::nullopt;
  const double largest = SideOf(patch, in_scan->chip_per_pixel * reduction);
  if (!(largest >= min_side)) return std::nullopt;
  int side = static_cast<int>(std::min<double>(max_side, std::floor(largest)));
  if (side % 2 == 0) --side;
  if (side < min_side) return std::nullopt;
  return Draw(view, patch, *in_scan, reduction, side);
}

}  // namespace orient::exterior

#include "patchdb/maintenance/patch_transform.h"

#include <Eigen/Dense>
#include <algorithm>

namespace orient::patchdb {
namespace {

constexpr double kStep_m = 100;  // step of the differences; a CRS is smooth far beyond that
constexpr double kNegligible_px = 0.1;

// d target / d source, both horizontal.
std::optional<Eigen::Matrix2d> Derivatives(const CoordinateTransform& transform,
                                           const Eigen::Vector2d& place_m) {
  Eigen::Matrix2d derivatives;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d step = Eigen::Vector2d::Unit(i) * kStep_m;
    const auto after = transform(place_m + step), before = transform(place_m - step);
    if (!after || !before) return std::nullopt;
    derivatives.col(i) = (*after - *before) / (2 * kStep_m);
  }
  return derivatives;
}

// Bilinear at a pixel position; NaN outside the centres' square.
float Sample(const Image& image, double col, double row) {
  const double u = col - 0.5, v = row - 0.5;
  if (!(u >= 0 && v >= 0 && u <= image.width - 1 && v <= image.height - 1)) return kNoData;
  const int c0 = std::min(static_cast<int>(u), std::max(0, image.width - 2));
  const int r0 = std::min(static_cast<int>(v), std::max(0, image.height - 2));
  const int c1 = std::min(c0 + 1, image.width - 1), r1 = std::min(r0 + 1, image.height - 1);
  const auto a = static_cast<float>(u - c0), b = static_cast<float>(v - r0);
  return (1 - b) * ((1 - a) * image.At(c0, r0) + a * image.At(c1, r0)) +
         b * ((1 - a) * image.At(c0, r1) + a * image.At(c1, r1));
}

int OddAtMost(double size) {
  const int whole = std::max(1, static_cast<int>(size));
  return whole % 2 == 1 ? whole : whole - 1;
}

// Rotation of grids: `source_from_target` applies to offsets (east, north) from the centre.
struct Turn {
  Eigen::Matrix2d source_from_target;
  double scale = 1;  // target metres per source metre
  double Cut() const {
    const Eigen::Matrix2d turn = source_from_target * scale;
    return std::max(turn.row(0).cwiseAbs().sum(), turn.row(1).cwiseAbs().sum());
  }
};

Image TurnImage(const Image& image, double gsd_m, const Turn& turn) {
  const int side = OddAtMost((std::min(image.width, image.height) - 1) / turn.Cut());
  Image turned(side, side);
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col) {
      const Eigen::Vector2d offset_m =
          Eigen::Vector2d(col + 0.5 - 0.5 * side, 0.5 * side - row - 0.5) * gsd_m * turn.scale;
      const Eigen::Vector2d there = turn.source_from_target * offset_m / gsd_m;
      turned.At(col, row) =
          Sample(image, 0.5 * image.width + there.x(), 0.5 * image.height - there.y());
    }
  return turned;
}

HeightGrid TurnHeights(const HeightGrid& heights, const Turn& turn) {
  if (heights.size == 0) return {};
  HeightGrid turned;
  turned.size = OddAtMost(heights.size / turn.Cut());
  turned.step_m = heights.step_m * turn.scale;
  const double half = 0.5 * (turned.size - 1);
  for (int row = 0; row < turned.size; ++row)
    for (int col = 0; col < turned.size; ++col) {
      const Eigen::Vector2d there =
          turn.source_from_target * Eigen::Vector2d(col - half, half - row) * turned.step_m;
      turned.heights_m.push_back(static_cast<float>(heights.At(there.x(), there.y())));
    }
  return turned;
}

void TurnPictures(const Turn& turn, Patch* patch) {
  patch->heights = TurnHeights(patch->heights, turn);
  patch->chip = TurnImage(patch->chip, patch->gsd_m, turn);
  for (Image& band : patch->colour) band = TurnImage(band, patch->gsd_m, turn);
}

}  // namespace

PatchTransform::PatchTransform(const Crs& target, const Crs& source)
    : same_(target.SameAs(source)),
      target_from_source_(target, source),
      source_from_target_(source, target) {}

std::optional<Patch> PatchTransform::operator()(const Patch& patch) const {
  if (same_) return patch;
  const auto place = target_from_source_(patch.ground_m.head<2>());
  if (!place) return std::nullopt;
  const auto forward = Derivatives(target_from_source_, patch.ground_m.head<2>());
  const auto back = Derivatives(source_from_target_, *place);
  if (!forward || !back || !(std::abs(forward->determinant()) > 0.1)) return std::nullopt;
  Patch there = patch;
  there.ground_m.head<2>() = *place;
  Eigen::Matrix3d derivatives = Eigen::Matrix3d::Identity();
  derivatives.topLeftCorner<2, 2>() = *forward;
  there.covariance_m2 = derivatives * patch.covariance_m2 * derivatives.transpose();
  if (patch.height_effect) there.height_effect = derivatives * *patch.height_effect;
  const Turn turn{*back, std::sqrt(std::abs(forward->determinant()))};
  const double half_px = 0.5 * std::max(patch.chip.width, patch.chip.height);
  const double moved_px = (*back * turn.scale - Eigen::Matrix2d::Identity()).norm() * half_px;
  if (moved_px > kNegligible_px)
    TurnPictures(turn, &there);
  else
    there.heights.step_m *= turn.scale;
  there.gsd_m = patch.gsd_m * turn.scale;
  return there;
}

}  // namespace orient::patchdb

#include "tools/simulate/object_drawing.h"

#include "tools/simulate/noise.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2f;

constexpr float kShade = 0.42f;  // what is left of the light in a shadow

// Calls visit(position, index) for every cell of the band within the box.
template <typename Visit>
void ForCells(const GroundBand& band, const Vector2f& low, const Vector2f& high, Visit visit) {
  const int col0 = std::max(0, FloorInt((low.x() - band.west) / band.cell));
  const int col1 = std::min(band.width - 1, FloorInt((high.x() - band.west) / band.cell));
  const int row0 = std::max(0, FloorInt((band.north - high.y()) / band.cell));
  const int row1 = std::min(band.height - 1, FloorInt((band.north - low.y()) / band.cell));
  for (int row = row0; row <= row1; ++row)
    for (int col = col0; col <= col1; ++col) {
      const Vector2f p(band.west + (static_cast<float>(col) + 0.5f) * band.cell,
                       band.north - (static_cast<float>(row) + 0.5f) * band.cell);
      visit(p,
            static_cast<size_t>(row) * static_cast<size_t>(band.width) + static_cast<size_t>(col));
    }
}

Vector2f InBuilding(const Building& building, const Vector2f& p) {
  const Vector2f d = p - building.centre;
  return {building.axis.dot(d), building.axis.x() * d.y() - building.axis.y() * d.x()};
}

// Whether the segment from a to b (building axes) touches the building's outline.
bool Touches(const Building& building, const Vector2f& a, const Vector2f& b) {
  const Vector2f half(building.half_length, building.half_width);
  float enter = 0, leave = 1;
  for (int axis = 0; axis < 2; ++axis) {
    const float d = b[axis] - a[axis];
    if (std::abs(d) < 1e-6f) {
      if (std::abs(a[axis]) > half[axis]) return false;
      continue;
    }
    const float t0 = (-half[axis] - a[axis]) / d, t1 = (half[axis] - a[axis]) / d;
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter <= leave;
}

float RoofHeight(const Building& building, const Vector2f& local) {
  const float from_ridge = std::abs(local.y()) / building.half_width;
  return building.eave + (building.ridge - building.eave) * std::max(0.0f, 1 - from_ridge);
}

float RoofTone(const Building& building, const Vector2f& local, const Eigen::Vector3f& sun) {
  const float pitch = (building.ridge - building.eave) / building.half_width;
  const float side = local.y() > 0 ? 1.0f : -1.0f;
  const Vector2f across(-building.axis.y(), building.axis.x());
  const Eigen::Vector3f normal =
      Eigen::Vector3f(side * pitch * across.x(), side * pitch * across.y(), 1).normalized();
  float tone = building.tone * std::clamp(normal.dot(sun) / sun.z(), 0.35f, 1.5f);
  // Rows of tiles and a patchwork of older and newer ones.
  const std::uint32_t seed = Hash(77, static_cast<std::int32_t>(building.centre.x() * 10),
                                  static_cast<std::int32_t>(building.centre.y() * 10));
  tone += 0.05f * ValueNoise(seed, local.x() / 1.9f, local.y() / 0.7f);
  const float corner_x = (Unit(seed) - 0.5f) * building.half_length;
  const float corner_y = 0.4f * building.half_width;
  if (std::abs(local.x() - corner_x) < 0.6f && std::abs(local.y() - corner_y) < 0.5f)
    tone = 0.12f;  // a skylight
  return std::clamp(tone, 0.05f, 0.95f);
}

void DrawBuilding(const Building& building, const Eigen::Vector3f& sun, GroundBand* band) {
  const float radius = std::hypot(building.half_length, building.half_width);
  const Vector2f reach(radius, radius);
  ForCells(
      *band, building.centre - reach, building.centre + reach,
      [&](const Vector2f& p, size_t index) {
        const Vector2f local = InBuilding(building, p);
        if (std::abs(local.x()) > building.half_length || std::abs(local.y()) > building.half_width)
          return;
        band->object_m[index] = RoofHeight(building, local);
        band->tone[index] = RoofTone(building, local, sun);
      });
}

void DrawTree(const Tree& tree, Epoch epoch, const Eigen::Vector3f& sun, GroundBand* band) {
  const Vector2f reach(tree.radius * 1.15f, tree.radius * 1.15f);
  ForCells(*band, tree.centre - reach, tree.centre + reach, [&](const Vector2f& p, size_t index) {
    const Vector2f d = (p - tree.centre) / tree.radius;
    const float leaves = ValueNoise(tree.seed, p.x() / 1.1f, p.y() / 1.1f);
    const float r2 = d.squaredNorm() * (1 + 0.25f * leaves);
    if (r2 >= 1) return;
    const float dome = std::sqrt(1 - r2);
    const float height = tree.height * (0.45f + 0.55f * dome) + 0.35f * leaves;
    if (height <= band->object_m[index]) return;
    const Eigen::Vector3f normal = Eigen::Vector3f(d.x(), d.y(), dome + 0.15f).normalized();
    const float light = std::clamp(normal.dot(sun), 0.0f, 1.0f);
    const float season = epoch == Epoch::kOld ? 1.0f : 1.25f;
    const float small = ValueNoise(tree.seed + 1, p.x() / 0.6f, p.y() / 0.6f);
    band->object_m[index] = height;
    band->tone[index] = std::clamp(
        season * tree.tone * (0.35f + 0.95f * light) + 0.05f * leaves + 0.04f * small, 0.03f, 0.9f);
  });
}

bool InTreeShadow(const Tree& tree, const Vector2f& p, const Vector2f& per_metre) {
  const Vector2f a = tree.centre + per_metre * (0.25f * tree.height);
  const Vector2f ab = per_metre * (0.6f * tree.height);
  const float t = std::clamp((p - a).dot(ab) / std::max(ab.squaredNorm(), 1e-6f), 0.0f, 1.0f);
  return (p - a - t * ab).squaredNorm() < 0.85f * tree.radius * tree.radius;
}

bool OutsideBand(const GroundBand& band, float low_y, float high_y) {
  return low_y > band.north || high_y < band.north - static_cast<float>(band.height) * band.cell;
}

}  // namespace

void DrawShadows(const Scene& scene, Epoch epoch, GroundBand* band) {
  const Eigen::Vector3f sun = SunDirection(epoch).cast<float>();
  const Vector2f per_metre = -sun.head<2>() / sun.z();  // shift of a shadow per metre of height
  std::vector<char> shaded(band->tone.size(), 0);
  for (const Building& building : scene.buildings) {
    if (!Exists(building, epoch)) continue;
    const Vector2f shift = per_metre * (0.4f * building.eave + 0.6f * building.ridge);
    const float radius = std::hypot(building.half_length, building.half_width);
    const Vector2f reach(radius, radius), far = building.centre + shift;
    const Vector2f low = building.centre.cwiseMin(far) - reach;
    const Vector2f high = building.centre.cwiseMax(far) + reach;
    if (OutsideBand(*band, low.y(), high.y())) continue;
    ForCells(*band, low, high, [&](const Vector2f& p, size_t index) {
      if (Touches(building, InBuilding(building, p), InBuilding(building, p - shift)))
        shaded[index] = 1;
    });
  }
  for (const Tree& tree : scene.trees) {
    const Vector2f far = tree.centre + per_metre * tree.height;
    const Vector2f reach(tree.radius, tree.radius);
    const Vector2f low = tree.centre.cwiseMin(far) - reach,
                   high = tree.centre.cwiseMax(far) + reach;
    if (OutsideBand(*band, low.y(), high.y())) continue;
    ForCells(*band, low, high, [&](const Vector2f& p, size_t index) {
      if (InTreeShadow(tree, p, per_metre)) shaded[index] = 1;
    });
  }
  for (size_t i = 0; i < shaded.size(); ++i)
    if (shaded[i] != 0) band->tone[i] *= kShade;
}

void DrawObjects(const Scene& scene, Epoch epoch, GroundBand* band) {
  const Eigen::Vector3f sun = SunDirection(epoch).cast<float>();
  for (const Building& building : scene.buildings) {
    const float radius = std::hypot(building.half_length, building.half_width);
    if (!Exists(building, epoch) ||
        OutsideBand(*band, building.centre.y() - radius, building.centre.y() + radius))
      continue;
    DrawBuilding(building, sun, band);
  }
  for (const Tree& tree : scene.trees)
    if (!OutsideBand(*band, tree.centre.y() - 1.2f * tree.radius,
                     tree.centre.y() + 1.2f * tree.radius))
      DrawTree(tree, epoch, sun, band);
}

}  // namespace orient::simulation

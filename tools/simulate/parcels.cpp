#include "tools/simulate/parcels.h"

#include <algorithm>
#include <numbers>

#include "tools/simulate/noise.h"

namespace orient::simulation {
namespace {

using Polygon = std::vector<Eigen::Vector2f>;

constexpr float kRoadSpacing_m = 480;   // longer pieces of land are cut by a road
constexpr float kTrackSpacing_m = 170;  // and these perhaps by a track
constexpr float kWarp_m = 7;
constexpr float kWarpWave_m = 190;

float Area(const Polygon& polygon) {
  float twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const auto& a = polygon[i];
    const auto& b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5f * twice;
}

Eigen::Vector2f Centre(const Polygon& polygon) {
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  for (const auto& corner : polygon) sum += corner;
  return sum / static_cast<float>(polygon.size());
}

Eigen::Vector2f LongestSide(const Polygon& polygon) {
  Eigen::Vector2f longest = Eigen::Vector2f::UnitX();
  float best = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2f side = polygon[(i + 1) % polygon.size()] - polygon[i];
    if (side.norm() > best) {
      best = side.norm();
      longest = side / best;
    }
  }
  return longest;
}

// Extent of a polygon along a direction.
float Span(const Polygon& polygon, const Eigen::Vector2f& direction) {
  float low = 1e9f, high = -1e9f;
  for (const auto& corner : polygon) {
    low = std::min(low, corner.dot(direction));
    high = std::max(high, corner.dot(direction));
  }
  return high - low;
}

// The part of a convex polygon where sign * (normal . p - offset) >= 0.
Polygon Clip(const Polygon& polygon, const Eigen::Vector2f& normal, float offset, float sign) {
  Polygon kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const auto& a = polygon[i];
    const auto& b = polygon[(i + 1) % polygon.size()];
    const float da = sign * (normal.dot(a) - offset), db = sign * (normal.dot(b) - offset);
    if (da >= 0) kept.push_back(a);
    if ((da >= 0) != (db >= 0)) kept.push_back(a + (b - a) * (da / (da - db)));
  }
  return kept;
}

Border ChooseBorder(float span_m, RandomStream* random) {
  if (span_m > kRoadSpacing_m) return Border::kRoad;
  if (span_m > kTrackSpacing_m && random->Chance(0.6)) return Border::kTrack;
  return random->Chance(0.35) ? Border::kHedge : Border::kPlain;
}

Eigen::Vector2f Turned(const Eigen::Vector2f& v, float angle_rad) {
  const float c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

}  // namespace

LandDivision LandDivision::Make(float width_m, float height_m, std::uint32_t seed) {
  LandDivision land;
  land.seed_ = seed;
  RandomStream random(Mix(seed));
  const float margin = 3 * kWarp_m;
  const Polygon outline = {{-margin, -margin},
                           {width_m + margin, -margin},
                           {width_m + margin, height_m + margin},
                           {-margin, height_m + margin}};
  const int villages = std::max(1, static_cast<int>(width_m * height_m / 600e3f));
  for (int i = 0; i < villages; ++i) {
    const auto x = static_cast<float>(random.Uniform(0.25, 0.75)) * width_m;
    const auto y = static_cast<float>(random.Uniform(0.25, 0.75)) * height_m;
    land.villages_.emplace_back(x, y, static_cast<float>(random.Uniform(90, 150)));
  }
  land.root_ = land.Divide(outline, 0, &random);
  return land;
}

bool LandDivision::NearVillage(const Eigen::Vector2f& position) const {
  for (const auto& village : villages_)
    if ((position - village.head<2>()).norm() < village.z()) return true;
  return false;
}

int LandDivision::Divide(const Polygon& outline, int depth, RandomStream* random,
                         const Cut* through) {
  const bool village = NearVillage(Centre(outline));
  const double wanted = village ? random->Uniform(500, 1500) : random->Uniform(2500, 14000);
  const bool small = static_cast<double>(Area(outline)) < wanted || depth > 24;
  if (small && through == nullptr) return AddParcel(outline, random);

  const Cut cut = through != nullptr ? *through : ChooseCut(outline, random);
  const size_t index = cuts_.size();
  cuts_.push_back(cut);
  const Polygon front = Clip(outline, cut.normal, cut.offset, 1);
  const Polygon back = Clip(outline, cut.normal, cut.offset, -1);
  Cut crossing;
  const Cut* next = nullptr;
  if (through == nullptr && cut.border == Border::kRoad) {
    // The road across goes straight on: a crossing and not two junctions.
    crossing = ChooseCut(front, random);
    crossing.border = Border::kRoad;
    const float turn = std::abs(crossing.normal.dot(cut.normal));
    if (turn < 0.5f && Cuts(front, crossing) && Cuts(back, crossing)) next = &crossing;
  }
  const int front_node = Divide(front, depth + 1, random, next);
  const int back_node = Divide(back, depth + 1, random, next);
  cuts_[index].front = front_node;
  cuts_[index].back = back_node;
  return static_cast<int>(index);
}

LandDivision::Cut LandDivision::ChooseCut(const Polygon& outline, RandomStream* random) {
  // Across the longer way, roughly square to a side, near the middle.
  const float right_angle = std::numbers::pi_v<float> / 2;
  Eigen::Vector2f along = LongestSide(outline);
  if (Span(outline, along) < Span(outline, Turned(along, right_angle)))
    along = Turned(along, right_angle);
  const Eigen::Vector2f normal = Turned(along, static_cast<float>(0.07 * random->Gaussian()));
  const float span = Span(outline, normal);
  const float offset =
      normal.dot(Centre(outline)) + span * static_cast<float>(random->Uniform(-0.14, 0.14));
  return {normal, offset, ChooseBorder(span, random), 0, 0};
}

// Whether the cut leaves a sensible piece of land on both sides.
bool LandDivision::Cuts(const Polygon& outline, const Cut& cut) {
  constexpr float kSmallest_m2 = 1500;
  return Area(Clip(outline, cut.normal, cut.offset, 1)) > kSmallest_m2 &&
         Area(Clip(outline, cut.normal, cut.offset, -1)) > kSmallest_m2;
}

int LandDivision::AddParcel(const Polygon& outline, RandomStream* random) {
  Parcel parcel;
  parcel.outline = outline;
  parcel.centre = Centre(outline);
  parcel.area_m2 = Area(outline);
  const Eigen::Vector2f side = LongestSide(outline);
  parcel.direction_rad = std::atan2(side.y(), side.x());
  parcel.seed = static_cast<std::uint32_t>(random->Next());
  const double kind = random->Uniform();
  if (NearVillage(parcel.centre))
    parcel.use = kind < 0.88 ? LandUse::kVillage : LandUse::kMeadow;
  else
    parcel.use = kind < 0.12 ? LandUse::kWood : kind < 0.32 ? LandUse::kMeadow : LandUse::kField;
  parcels_.push_back(std::move(parcel));
  return -static_cast<int>(parcels_.size());
}

float LandDivision::BendX(float x, float y) const {
  return kWarp_m * ValueNoise(seed_ + 11, x / kWarpWave_m, y / kWarpWave_m);
}

float LandDivision::BendY(float x, float y) const {
  return kWarp_m * ValueNoise(seed_ + 12, x / kWarpWave_m, y / kWarpWave_m);
}

LandAt LandDivision::AtUnbent(const Eigen::Vector2f& p) const {
  LandAt at;
  int node = root_;
  while (node >= 0) {
    const Cut& cut = cuts_[static_cast<size_t>(node)];
    const float side = cut.normal.dot(p) - cut.offset;
    const float distance = std::abs(side);
    if (distance < at.border_m) {
      at.border_m = distance;
      at.hedge = cut.border == Border::kHedge;
    }
    if (cut.border == Border::kRoad) {
      if (distance < std::abs(at.road_m)) {
        at.second_road_m = std::abs(at.road_m);
        at.road_m = side;
        at.along_m = cut.normal.x() * p.y() - cut.normal.y() * p.x();
      } else {
        at.second_road_m = std::min(at.second_road_m, distance);
      }
    } else if (cut.border == Border::kTrack && distance < std::abs(at.track_m)) {
      at.track_m = side;
    }
    node = side >= 0 ? cut.front : cut.back;
  }
  at.parcel = -node - 1;
  return at;
}

}  // namespace orient::simulation

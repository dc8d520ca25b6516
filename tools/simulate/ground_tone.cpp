#include "tools/simulate/ground_tone.h"

#include <numbers>

#include "tools/simulate/noise.h"

namespace orient::simulation {
namespace {

void ChooseCrop(RandomStream* random, ParcelLook* look) {
  const double kind = random->Uniform();
  const auto pick = [&](double low, double high) {
    return static_cast<float>(random->Uniform(low, high));
  };
  look->soil = pick(0.07, 0.16);
  look->patch = pick(0.05, 0.13);
  look->fine = pick(0.05, 0.10);
  look->tramline = -pick(0.06, 0.14);
  if (kind < 0.25) {  // ploughed
    look->base = pick(0.22, 0.32);
    look->row = pick(0.05, 0.12);
    look->row_period_m = pick(1.6, 3.2);
    look->tramline = 0;
  } else if (kind < 0.55) {  // a green crop
    look->base = pick(0.34, 0.48);
    look->row = pick(0.03, 0.09);
    look->row_period_m = pick(0.9, 2.4);
  } else if (kind < 0.8) {  // ripe
    look->base = pick(0.58, 0.74);
    look->row = pick(0.02, 0.06);
    look->row_period_m = pick(1.2, 3.0);
  } else {  // stubble, mown in broad bands
    look->base = pick(0.48, 0.62);
    look->row = pick(0.06, 0.12);
    look->row_period_m = pick(4.0, 6.5);
  }
}

ParcelLook OldLook(const Parcel& parcel) {
  RandomStream random(parcel.seed);
  ParcelLook look;
  look.use = parcel.use;
  ChooseCrop(&random, &look);
  const float across = parcel.direction_rad + std::numbers::pi_v<float> / 2;
  look.row_cos = std::cos(across);
  look.row_sin = std::sin(across);
  if (parcel.use == LandUse::kField) return look;
  look.row = look.tramline = 0;
  const auto vary = static_cast<float>(random.Uniform(-0.05, 0.05));
  if (parcel.use == LandUse::kMeadow) look.base = 0.42f + vary;
  if (parcel.use == LandUse::kWood) look.base = 0.16f + vary * 0.5f;
  if (parcel.use == LandUse::kVillage) look.base = 0.44f + vary;
  return look;
}

ParcelLook NewLook(const Parcel& parcel, Change change) {
  ParcelLook look = OldLook(parcel);
  RandomStream random(Mix(parcel.seed + 5));
  if (change == Change::kTone) ChooseCrop(&random, &look);
  if (change == Change::kInverted) {
    look.base = 0.96f - look.base;
    look.soil = -look.soil;
    look.patch = -look.patch;
    look.row = -look.row;
    look.tramline = -look.tramline;
  }
  if (change != Change::kNone && parcel.use != LandUse::kField) look.row = look.tramline = 0;
  // The season: grass is greener, everything a little different.
  if (parcel.use == LandUse::kMeadow) look.base += 0.06f;
  look.base += static_cast<float>(random.Uniform(-0.04, 0.04));
  const auto contrast = static_cast<float>(random.Uniform(0.8, 1.15));
  look.soil *= contrast;
  look.patch *= contrast;
  look.row *= contrast;
  return look;
}

}  // namespace

GroundTone::GroundTone(const Scene& scene, Epoch epoch, float cell_m)
    : scene_(scene), epoch_(epoch), cell_(cell_m) {
  const auto& parcels = scene.land.Parcels();
  for (size_t i = 0; i < parcels.size(); ++i)
    looks_.push_back(epoch == Epoch::kOld ? OldLook(parcels[i])
                                          : NewLook(parcels[i], scene.parcel_change[i]));
}

float GroundTone::SmoothResolved(float cells) { return SmoothStep(2.0f, 4.0f, cells); }

float GroundTone::Cover(float distance, float half_width) const {
  const float share = std::min(1.0f, 2 * half_width / cell_);
  return share * std::clamp((half_width - std::abs(distance)) / cell_ + 0.5f, 0.0f, 1.0f);
}

SlowField GroundTone::SlowAt(float x, float y) const {
  return {scene_.land.BendX(x, y), scene_.land.BendY(x, y),
          FractalNoise(scene_.seed + 101, x / 75, y / 75, 4)};
}

float GroundTone::At(float x, float y, const SlowField& slow) const {
  const LandAt at = scene_.land.AtUnbent({x + slow.bend_x, y + slow.bend_y});
  const ParcelLook& look = looks_[static_cast<size_t>(at.parcel)];
  float tone = Parcelled(look, at, x, y, slow.soil);
  if (at.hedge) tone += (0.24f - tone) * Cover(at.border_m, 1.1f);
  if (look.use == LandUse::kField && !at.hedge)
    tone += (0.46f - tone) * 0.7f * Cover(at.border_m, 0.45f);  // the balk between two fields
  if (look.use == LandUse::kMeadow && !scene_.ponds.empty()) tone = Water(x, y, tone);
  if (std::abs(at.track_m) < 3) tone = Track(at, x, y, tone);
  if (std::abs(at.road_m) < 7) tone = Road(at, x, y, tone);
  return std::clamp(tone, 0.04f, 0.96f);
}

float GroundTone::Parcelled(const ParcelLook& look, const LandAt& at, float x, float y,
                            float soil) const {
  const std::uint32_t seed = scene_.seed;
  // What the soil is does not depend on the parcel or the date; how it shows does.
  float tone = look.base + look.soil * 1.6f * soil;
  const float blotch = ValueNoise(seed + 131, x / 8.5f, y / 8.5f) +
                       0.6f * ValueNoise(seed + 132, x / 3.3f, y / 3.3f);
  tone += look.patch * (SmoothStep(0.30f, 0.48f, blotch) - SmoothStep(-0.48f, -0.62f, blotch));
  if (look.use == LandUse::kVillage)
    tone += Garden(scene_.land.Parcels()[static_cast<size_t>(at.parcel)], x, y);
  tone += Rows(look, at, x, y);
  // Most of the small texture stays; some of it is of the day.
  const std::uint32_t today = epoch_ == Epoch::kOld ? 151u : 152u;
  const float medium = Resolved(1.7f), small = Resolved(0.55f);
  if (medium > 0)
    tone += look.fine * medium *
            (0.75f * ValueNoise(seed + 141, x / 1.7f, y / 1.7f) +
             0.30f * ValueNoise(seed + today, x / 1.3f, y / 1.3f));
  if (small > 0) tone += look.fine * small * ValueNoise(seed + 142, x / 0.55f, y / 0.55f);
  return tone;
}

float GroundTone::Rows(const ParcelLook& look, const LandAt& at, float x, float y) const {
  float tone = 0;
  const bool headland = at.border_m < 7;  // where the tractor turns: no rows, a little darker
  if (headland) return look.row != 0 ? -0.03f : 0.0f;
  const float across = look.row_cos * x + look.row_sin * y;
  const float resolved = Resolved(look.row_period_m);
  if (look.row != 0 && resolved > 0) {
    const float phase = across / look.row_period_m;
    const float t = std::abs(2 * (phase - static_cast<float>(FloorInt(phase))) - 1);
    tone += look.row * resolved * (2 * t * t * (3 - 2 * t) - 1);
  }
  if (look.tramline != 0) {
    const float pass = across / 18;
    const float in_pass = 18 * (pass - static_cast<float>(FloorInt(pass)));
    tone += look.tramline * (Cover(in_pass - 5.0f, 0.25f) + Cover(in_pass - 6.8f, 0.25f));
  }
  return tone;
}

// Vegetable beds, lawns and yards: rectangles of differing tones along the parcel's sides.
float GroundTone::Garden(const Parcel& parcel, float x, float y) const {
  const float c = std::cos(parcel.direction_rad), s = std::sin(parcel.direction_rad);
  const float u = (c * x + s * y) / 9, v = (c * y - s * x) / 6;
  const std::int32_t i = FloorInt(u), j = FloorInt(v);
  const std::uint32_t bed = Hash(parcel.seed, i, j);
  const std::uint32_t year = epoch_ == Epoch::kNew && Unit(Mix(bed + 3)) < 0.25f ? 17u : 0u;
  float tone = 0.34f * (Unit(Mix(bed + year)) - 0.5f);
  const float edge = 6 * std::min(v - static_cast<float>(j), 1 - (v - static_cast<float>(j)));
  tone += 0.22f * Cover(edge, 0.4f);  // a path between the beds
  return tone;
}

float GroundTone::Road(const LandAt& at, float x, float y, float below) const {
  const float d = std::abs(at.road_m);
  float tone = below + (0.55f - below) * Cover(d, 5.2f);  // the verge
  // Repairs of the surface: rectangles that stay where they are.
  const std::int32_t slab = FloorInt(at.along_m / 13);
  const std::uint32_t repair = Hash(scene_.seed + 201, slab, at.road_m > 0 ? 1 : 0);
  float asphalt = (epoch_ == Epoch::kOld ? 0.40f : 0.44f) + 0.12f * (Unit(repair) - 0.5f);
  asphalt += 0.05f * Resolved(0.8f) * ValueNoise(scene_.seed + 202, x / 0.8f, y / 0.8f);
  tone += (asphalt - tone) * Cover(d, 3.6f);
  if (at.second_road_m < 9) {
    tone += (asphalt - tone) * Cover(at.second_road_m, 3.6f);
    // The line at which one waits before the crossing.
    if (d < 3.2f) tone += (0.9f - tone) * Cover(at.second_road_m - 6.5f, 0.3f);
    return tone;
  }
  tone += (0.85f - tone) * Cover(d - 3.3f, 0.09f);
  const float dash = at.along_m / 9;
  if (dash - static_cast<float>(FloorInt(dash)) < 0.45f) tone += (0.9f - tone) * Cover(d, 0.10f);
  return tone;
}

float GroundTone::Track(const LandAt& at, float x, float y, float below) const {
  const float d = std::abs(at.track_m);
  float tone = below + (0.50f - below) * Cover(d, 1.9f);
  const float worn = 0.68f + 0.08f * ValueNoise(scene_.seed + 211, x / 4, y / 4);
  return tone + (worn - tone) * Cover(d - 0.85f, 0.4f);
}

float GroundTone::Water(float x, float y, float below) const {
  const Eigen::Vector2f p(x, y);
  for (const Pond& pond : scene_.ponds) {
    const float reach = (p - pond.centre).norm();
    if (reach > 1.5f * pond.radius) continue;
    const float shore =
        reach - pond.radius * (1 + 0.3f * ValueNoise(scene_.seed + 221, x / 17, y / 17));
    float tone = below + (0.62f - below) * SmoothStep(2.5f, 1.0f, shore) * SmoothStep(-2, 0, shore);
    return tone + ((epoch_ == Epoch::kOld ? 0.10f : 0.15f) - tone) * SmoothStep(0.3f, -0.3f, shore);
  }
  return below;
}

}  // namespace orient::simulation

// How bright the ground is at a place and date, before light and shadow: fields, meadows, gardens,
// roads, water. A reflectance of about 0.05 to 0.95.
#pragma once

#include <vector>

#include "tools/simulate/scene.h"

namespace orient::simulation {

// How one parcel looks at one date.
struct ParcelLook {
  LandUse use = LandUse::kField;
  float base = 0.4f;
  float soil = 0.1f;   // contrast of the soil's patches (tens of metres); negative: inverted
  float patch = 0.1f;  // contrast of sharp-edged blotches (metres)
  float fine = 0.05f;  // contrast below two metres
  float row = 0;       // contrast of the crop rows
  float row_period_m = 2;
  float row_cos = 1, row_sin = 0;  // across the rows
  float tramline = 0;              // contrast of the tractor's tracks
};

// What changes slowly over the ground, so that neighbouring cells can share it.
struct SlowField {
  float bend_x = 0, bend_y = 0;  // of the land division, m
  float soil = 0;                // -1 to 1
};

class GroundTone {
 public:
  // `cell_m`: size of the area a tone stands for; finer texture is left out.
  GroundTone(const Scene& scene, Epoch epoch, float cell_m);

  // x, y: metres east and north of the scene's south-west corner.
  float At(float x, float y, const SlowField& slow) const;

  // Computed at a place; between places about a metre apart it may be interpolated.
  SlowField SlowAt(float x, float y) const;

 private:
  float Parcelled(const ParcelLook& look, const LandAt& at, float x, float y, float soil) const;
  float Rows(const ParcelLook& look, const LandAt& at, float x, float y) const;
  float Garden(const Parcel& parcel, float x, float y) const;
  float Road(const LandAt& at, float x, float y, float below) const;
  float Track(const LandAt& at, float x, float y, float below) const;
  float Water(float x, float y, float below) const;
  // Share of the area within `half_width` of a line `distance` away.
  float Cover(float distance, float half_width) const;
  // 1 where the area resolves a wavelength, 0 where it does not.
  float Resolved(float wave_m) const { return SmoothResolved(wave_m / cell_); }
  static float SmoothResolved(float cells);

  const Scene& scene_;
  Epoch epoch_;
  float cell_;
  std::vector<ParcelLook> looks_;
};

}  // namespace orient::simulation

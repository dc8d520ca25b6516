// The scanner's share: blur, polarity, grain, and whole grey values.
#pragma once

#include <cstdint>
#include <vector>

#include "core/imaging/image.h"

namespace orient::simulation {

struct ScannerOptions {
  double blur_px = 0.6;   // sigma of the Gaussian point spread
  double grain = 3;       // sigma, in grey values of 8 bit
  bool negative = false;  // the film is a negative: bright ground is dark
  int bits = 8;           // 8 or 16
  std::uint32_t seed = 1;
};

// Gaussian blur in place; pixels beyond the edge take the edge's value.
void Blur(double sigma_px, Image* image);

// Grey values of the scan from the positive (0 to 1): blurred, inverted for a negative, with grain.
// 0 to 255 for 8 bit, 0 to 65535 for 16.
std::vector<std::uint16_t> Scan(Image positive, const ScannerOptions& options);

}  // namespace orient::simulation

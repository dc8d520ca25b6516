// The scanner's share: blur, and polarity, grain and whole grey values.
#pragma once

#include <cstdint>
#include <vector>

#include "core/raster/image.h"

namespace orient::simulation {

struct ScannerOptions {
  double grain = 3;       // sigma, in grey values of 8 bit
  bool negative = false;  // the film is a negative: bright ground is dark
  int bits = 8;           // 8 or 16
  std::uint32_t seed = 1;
};

// Gaussian blur in place; pixels beyond the edge take the edge's value.
void Blur(double sigma_px, Image* image);

// Grey values of the scan from the blurred positive (0 to 1): inverted for a negative, with grain.
// 0 to 255 for 8 bit, 0 to 65535 for 16.
std::vector<std::uint16_t> Scan(const Image& positive, const ScannerOptions& options);

}  // namespace orient::simulation

// The binary columns of a patch: chip, mask, heights and covariance as bytes of fixed layout. The
// layout is written beside the columns in patchdb/schema/ and in docs/patchdb.md.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "patchdb/store/patch.h"

namespace orient::patchdb {

using Bytes = std::vector<unsigned char>;

// PNG of the grey values rounded to whole numbers and clamped to 0 .. 2^bits - 1; NaN becomes 0.
Bytes EncodeChip(const Image& chip, int bits);
// The same of red, green and blue.
Bytes EncodeColourChip(const std::vector<Image>& colour, int bits);
// 255 where the chip has a value, 0 where it is NaN; empty where every pixel is valid.
std::optional<Bytes> EncodeChipMask(const Image& chip);
// Throws InputError for a damaged PNG, or a mask of another size.
Image DecodeChip(const Bytes& chip, const std::optional<Bytes>& mask);
// Red, green and blue; empty of a grey chip.
std::vector<Image> DecodeColour(const Bytes& chip, const std::optional<Bytes>& mask);

// size * size little-endian float32.
Bytes EncodeHeights(const HeightGrid& heights);
// Throws InputError where the bytes are not a grid of this size.
HeightGrid DecodeHeights(const Bytes& bytes, int size, double step_m);

// A grey PNG of the same grid, of 8 bits where the range allows: base_m + quantum_m * value; the
// largest value (255 or 65535) where unknown.
struct PackedHeights {
  Bytes png;
  double base_m = 0;  // the lowest height
  double quantum_m = 0;
};
// Empty where the heights' range is too large for that quantum.
std::optional<PackedHeights> PackHeights(const HeightGrid& heights, double quantum_m);
// Throws InputError where the bytes are not such a PNG of this size, or base and quantum no
// numbers.
HeightGrid UnpackHeights(const PackedHeights& packed, int size, double step_m);

// 6 little-endian float64: xx xy xz yy yz zz.
Bytes EncodeCovariance(const Eigen::Matrix3d& covariance_m2);
// Throws InputError where the bytes are not six finite numbers.
Eigen::Matrix3d DecodeCovariance(const Bytes& bytes);

// 3 little-endian float64: x y z.
Bytes EncodeVector(const Eigen::Vector3d& vector);
// Throws InputError where the bytes are not three finite numbers.
Eigen::Vector3d DecodeVector(const Bytes& bytes);

}  // namespace orient::patchdb

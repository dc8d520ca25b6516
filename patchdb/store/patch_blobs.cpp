#include "patchdb/store/patch_blobs.h"

#include <Eigen/Eigenvalues>
#include <bit>
#include <cstdint>
#include <cstring>

#include "core/base/error.h"
#include "core/raster/png_bands.h"
#include "core/raster/raster.h"

namespace orient::patchdb {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the BLOBs are little-endian; a big-endian machine must swap their bytes here");

constexpr int kMaxHeightsSize = 4096;  // a hostile file must not make us allocate without limit

// The value of an unknown height: the largest one of 8 or 16 bits.
constexpr float UnknownHeight(int bits) { return bits == 8 ? 255 : 65535; }

constexpr std::size_t kPngBits = 24;  // offset of the bit depth in a PNG's header

void CheckGrid(int size, double step_m) {
  if (size < 1 || size > kMaxHeightsSize || size % 2 == 0 || !(step_m > 0) ||
      !std::isfinite(step_m))
    throw InputError("the height grid has an impossible size or step");
}

void ApplyMask(const Image& valid, Image& image) {
  if (valid.width != image.width || valid.height != image.height)
    throw InputError("the mask's size differs from the chip's");
  for (std::size_t i = 0; i < image.values.size(); ++i)
    if (valid.values[i] == 0) image.values[i] = kNoData;
}

}  // namespace

Bytes EncodeChip(const Image& chip, int bits) { return EncodePngBands({chip}, bits); }

Bytes EncodeColourChip(const std::vector<Image>& colour, int bits) {
  return EncodePngBands(colour, bits);
}

std::optional<Bytes> EncodeChipMask(const Image& chip) {
  Image mask(chip.width, chip.height);
  bool complete = true;
  for (std::size_t i = 0; i < mask.values.size(); ++i) {
    mask.values[i] = std::isnan(chip.values[i]) ? 0 : 255;
    complete = complete && mask.values[i] != 0;
  }
  if (complete) return std::nullopt;
  return EncodePngBands({mask}, 8);
}

Image DecodeChip(const Bytes& chip, const std::optional<Bytes>& mask) {
  Image image = GreyOfBands(DecodePngBands(chip));
  if (mask) ApplyMask(GreyOfBands(DecodePngBands(*mask)), image);
  return image;
}

std::vector<Image> DecodeColour(const Bytes& chip, const std::optional<Bytes>& mask) {
  std::vector<Image> bands = DecodePngBands(chip);
  if (bands.size() == 1) return {};
  if (!mask) return bands;
  const Image valid = GreyOfBands(DecodePngBands(*mask));
  for (Image& band : bands) ApplyMask(valid, band);
  return bands;
}

Bytes EncodeHeights(const HeightGrid& heights) {
  Bytes bytes(heights.heights_m.size() * sizeof(float));
  std::memcpy(bytes.data(), heights.heights_m.data(), bytes.size());
  return bytes;
}

HeightGrid DecodeHeights(const Bytes& bytes, int size, double step_m) {
  CheckGrid(size, step_m);
  const auto count = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  if (bytes.size() != count * sizeof(float))
    throw InputError("the height grid's bytes do not fit its size");
  HeightGrid heights{size, step_m, std::vector<float>(count)};
  std::memcpy(heights.heights_m.data(), bytes.data(), bytes.size());
  return heights;
}

std::optional<PackedHeights> PackHeights(const HeightGrid& heights, double quantum_m) {
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  for (const float height : heights.heights_m) {
    if (std::isinf(height)) return std::nullopt;
    lowest = std::fmin(lowest, height);
    highest = std::fmax(highest, height);
  }
  if (!(lowest <= highest)) lowest = highest = 0;  // none is known
  const auto fits = [&](int bits) {
    return (highest - lowest) / quantum_m <= UnknownHeight(bits) - 1;
  };
  if (!(quantum_m > 0) || !fits(16)) return std::nullopt;
  const int bits = fits(8) ? 8 : 16;
  Image values(heights.size, heights.size, UnknownHeight(bits));
  for (std::size_t i = 0; i < values.values.size(); ++i)
    if (!std::isnan(heights.heights_m[i]))
      values.values[i] = static_cast<float>(
          std::lround((double{heights.heights_m[i]} - double{lowest}) / quantum_m));
  return PackedHeights{EncodePngBands({values}, bits), lowest, quantum_m};
}

HeightGrid UnpackHeights(const PackedHeights& packed, int size, double step_m) {
  CheckGrid(size, step_m);
  if (!std::isfinite(packed.base_m) || !std::isfinite(packed.quantum_m))
    throw InputError("the height grid's base or quantum is not a number");
  const std::vector<Image> bands = DecodePngBands(packed.png);
  if (bands.size() != 1 || bands[0].width != size || bands[0].height != size)
    throw InputError("the height grid's PNG does not fit its size");
  const float unknown = UnknownHeight(packed.png[kPngBits]);
  HeightGrid heights{size, step_m, std::vector<float>(bands[0].values.size(), kNoData)};
  for (std::size_t i = 0; i < heights.heights_m.size(); ++i)
    if (bands[0].values[i] != unknown)
      heights.heights_m[i] =
          static_cast<float>(packed.base_m + packed.quantum_m * double{bands[0].values[i]});
  return heights;
}

Bytes EncodeCovariance(const Eigen::Matrix3d& c) {
  const std::array<double, 6> values = {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2)};
  Bytes bytes(sizeof(values));
  std::memcpy(bytes.data(), values.data(), sizeof(values));
  return bytes;
}

Eigen::Matrix3d DecodeCovariance(const Bytes& bytes) {
  std::array<double, 6> v{};
  if (bytes.size() != sizeof(v)) throw InputError("the covariance is not six numbers");
  std::memcpy(v.data(), bytes.data(), sizeof(v));
  Eigen::Matrix3d c;
  c << v[0], v[1], v[2], v[1], v[3], v[4], v[2], v[4], v[5];
  if (!c.allFinite()) throw InputError("the covariance holds values that are not numbers");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(c, Eigen::EigenvaluesOnly);
  constexpr double kRounding = 1e-9;                        // of the largest
  const Eigen::Vector3d& variances = solver.eigenvalues();  // in increasing order
  if (!(variances[2] > 0 && variances[0] >= -kRounding * variances[2]))
    throw InputError("the covariance is not positive semidefinite");
  return c;
}

Bytes EncodeVector(const Eigen::Vector3d& vector) {
  Bytes bytes(3 * sizeof(double));
  std::memcpy(bytes.data(), vector.data(), bytes.size());
  return bytes;
}

Eigen::Vector3d DecodeVector(const Bytes& bytes) {
  Eigen::Vector3d vector;
  if (bytes.size() != 3 * sizeof(double)) throw InputError("a vector is not three numbers");
  std::memcpy(vector.data(), bytes.data(), bytes.size());
  if (!vector.allFinite()) throw InputError("a vector holds values that are not numbers");
  return vector;
}

}  // namespace orient::patchdb

#include "patchdb/patch_blobs.h"

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/error.h"
#include "core/imaging/raster.h"

namespace orient {
namespace {

static_assert(std::endian::native == std::endian::little,
              "the BLOBs are little-endian; a big-endian machine must swap their bytes here");

constexpr int kMaxHeightsSize = 4096;  // a hostile file must not make us allocate without limit

template <typename T>
T ClampedGrey(float value, float largest) {
  if (std::isnan(value)) return 0;
  return static_cast<T>(std::lround(std::clamp(value, 0.0f, largest)));
}

}  // namespace

Bytes EncodeChip(const Image& chip, int bits) {
  if (bits == 8) {
    Bytes grey(chip.values.size());
    for (std::size_t i = 0; i < grey.size(); ++i)
      grey[i] = ClampedGrey<unsigned char>(chip.values[i], 255);
    return EncodePng(chip.width, chip.height, 1, grey);
  }
  std::vector<std::uint16_t> grey(chip.values.size());
  for (std::size_t i = 0; i < grey.size(); ++i)
    grey[i] = ClampedGrey<std::uint16_t>(chip.values[i], 65535);
  return EncodePng16(chip.width, chip.height, grey);
}

std::optional<Bytes> EncodeChipMask(const Image& chip) {
  Bytes mask(chip.values.size());
  bool complete = true;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    mask[i] = std::isnan(chip.values[i]) ? 0 : 255;
    complete = complete && mask[i] != 0;
  }
  if (complete) return std::nullopt;
  return EncodePng(chip.width, chip.height, 1, mask);
}

Image DecodeChip(const Bytes& chip, const std::optional<Bytes>& mask) {
  Image image = DecodePng(chip);
  if (!mask) return image;
  const Image valid = DecodePng(*mask);
  if (valid.width != image.width || valid.height != image.height)
    throw InputError("the mask's size differs from the chip's");
  for (std::size_t i = 0; i < image.values.size(); ++i)
    if (valid.values[i] == 0) image.values[i] = kNoData;
  return image;
}

Bytes EncodeHeights(const HeightGrid& heights) {
  Bytes bytes(heights.heights_m.size() * sizeof(float));
  std::memcpy(bytes.data(), heights.heights_m.data(), bytes.size());
  return bytes;
}

HeightGrid DecodeHeights(const Bytes& bytes, int size, double step_m) {
  if (size < 1 || size > kMaxHeightsSize || size % 2 == 0 || !(step_m > 0) ||
      !std::isfinite(step_m))
    throw InputError("the height grid has an impossible size or step");
  const auto count = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  if (bytes.size() != count * sizeof(float))
    throw InputError("the height grid's bytes do not fit its size");
  HeightGrid heights{size, step_m, std::vector<float>(count)};
  std::memcpy(heights.heights_m.data(), bytes.data(), bytes.size());
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

}  // namespace orient

#include "tests/support/scan_making.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <stdexcept>

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

float Clamped(float value) { return std::clamp(value, 0.0f, 255.0f); }

// Bilinear interpolation; exact at pixel centres.
float ValueAt(const Image& image, const Vector2d& at, float fill) {
  constexpr double kSnap = 1e-6;
  const Vector2d low = (at.array() - 0.5 + kSnap).floor();
  const Vector2d part = (at.array() - 0.5 - low.array()).cwiseMax(0);
  const int col = static_cast<int>(low.x()), row = static_cast<int>(low.y());
  const auto pixel = [&](int c, int r) {
    const bool inside = c >= 0 && r >= 0 && c < image.width && r < image.height;
    return static_cast<double>(inside ? image.At(c, r) : fill);
  };
  if (part.maxCoeff() < kSnap) return static_cast<float>(pixel(col, row));
  const double top = (1 - part.x()) * pixel(col, row) + part.x() * pixel(col + 1, row);
  const double below = (1 - part.x()) * pixel(col, row + 1) + part.x() * pixel(col + 1, row + 1);
  return static_cast<float>((1 - part.y()) * top + part.y() * below);
}

void PutInto(const Image& part, int col, int row, Image* whole) {
  for (int r = 0; r < part.height; ++r)
    for (int c = 0; c < part.width; ++c)
      if (c + col < whole->width && r + row < whole->height)
        whole->At(c + col, r + row) = part.At(c, r);
}

// Bytes of a TIFF file, little-endian.
class Bytes {
 public:
  void Add16(std::uint32_t value) {
    bytes_.push_back(static_cast<char>(value & 0xffu));
    bytes_.push_back(static_cast<char>(value >> 8 & 0xffu));
  }
  void Add32(std::uint32_t value) {
    Add16(value & 0xffffu);
    Add16(value >> 16);
  }
  void AddEntry(std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::uint32_t value) {
    Add16(tag);
    Add16(type);
    Add32(count);
    Add32(value);
  }
  const std::vector<char>& All() const { return bytes_; }

 private:
  std::vector<char> bytes_;
};

std::vector<char> Row(const Image& scan, int row, bool one_bit) {
  const auto width = static_cast<size_t>(scan.width);
  std::vector<char> bytes(one_bit ? (width + 7) / 8 : width, 0);
  for (size_t col = 0; col < width; ++col) {
    const float value = Clamped(scan.At(static_cast<int>(col), row));
    if (!one_bit)
      bytes[col] = static_cast<char>(std::lround(value));
    else if (value > 127)
      bytes[col / 8] = static_cast<char>(bytes[col / 8] | (0x80 >> (col % 8)));
  }
  return bytes;
}

}  // namespace

TrueScan Moved(const TrueScan& scan, const Affine2d& map, int width, int height, float fill) {
  TrueScan moved{Image(width, height), map * scan.pixel_from_photo, scan.marks, scan.polarity};
  const Affine2d back = map.Inverse();
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col)
      moved.image.At(col, row) = ValueAt(scan.image, back * Vector2d(col + 0.5, row + 0.5), fill);
  for (TruePlace& mark : moved.marks) mark.pixel = map * mark.pixel;
  return moved;
}

TrueScan Cut(const TrueScan& scan, const Margins& m, float fill) {
  const Affine2d map{Matrix2d::Identity(), Vector2d(-m.left, -m.top)};
  return Moved(scan, map, scan.image.width - m.left - m.right, scan.image.height - m.top - m.bottom,
               fill);
}

TrueScan MirroredScan(const TrueScan& scan) {
  const Affine2d map{Vector2d(-1, 1).asDiagonal(), Vector2d(scan.image.width, 0)};
  return Moved(scan, map, scan.image.width, scan.image.height, 0);
}

TrueScan UpsideDown(const TrueScan& scan) {
  const Affine2d map{-Matrix2d::Identity(), Vector2d(scan.image.width, scan.image.height)};
  return Moved(scan, map, scan.image.width, scan.image.height, 0);
}

TrueScan TurnedScan(const TrueScan& scan, double degrees, float fill) {
  const double angle = -degrees * std::numbers::pi / 180;  // rows run down
  const Matrix2d turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
  const Vector2d size(scan.image.width, scan.image.height);
  const Vector2d room = (turn.cwiseAbs() * size).array().ceil();
  const Affine2d map{turn, 0.5 * room - turn * (0.5 * size)};
  return Moved(scan, map, static_cast<int>(room.x()), static_cast<int>(room.y()), fill);
}

TrueScan NegativeScan(const TrueScan& scan) {
  TrueScan negative = scan;
  for (float& value : negative.image.values) value = 255 - value;
  negative.polarity =
      scan.polarity == Polarity::kPositive ? Polarity::kNegative : Polarity::kPositive;
  return negative;
}

TrueScan NoisyScan(const TrueScan& scan, double sigma, unsigned seed) {
  TrueScan noisy = scan;
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0, static_cast<float>(sigma));
  for (float& value : noisy.image.values) value = Clamped(value + normal(random));
  return noisy;
}

TrueScan FoggedScan(const TrueScan& scan, double at_corners, float fog) {
  TrueScan fogged = scan;
  const Vector2d middle(0.5 * scan.image.width, 0.5 * scan.image.height);
  for (int row = 0; row < scan.image.height; ++row)
    for (int col = 0; col < scan.image.width; ++col) {
      const double r2 = (Vector2d(col, row) - middle).squaredNorm() / middle.squaredNorm();
      float& value = fogged.image.At(col, row);
      value = Clamped(value * static_cast<float>(1 - (1 - at_corners) * r2) + fog);
    }
  return fogged;
}

TrueScan Bilevel(const TrueScan& scan, std::optional<float> threshold) {
  TrueScan result = scan;
  Image& image = result.image;
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const float value = image.At(col, row);
      const float black_or_white = value > threshold.value_or(127.5f) ? 255.0f : 0.0f;
      image.At(col, row) = black_or_white;
      if (threshold) continue;
      const float error = value - black_or_white;
      const auto spread = [&](int c, int r, float share) {
        if (c >= 0 && c < image.width && r < image.height) image.At(c, r) += share * error;
      };
      spread(col + 1, row, 7.0f / 16);
      spread(col - 1, row + 1, 3.0f / 16);
      spread(col, row + 1, 5.0f / 16);
      spread(col + 1, row + 1, 1.0f / 16);
    }
  return result;
}

TrueScan Beside(const TrueScan& scan, const Image& next, int overlap) {
  const int at = scan.image.width - overlap;
  TrueScan both = Cut(scan, {0, 0, -(next.width - overlap), 0}, 18);
  PutInto(next, at, 0, &both.image);
  return both;
}

TrueScan Above(const TrueScan& scan, const Image& next, int overlap) {
  const int at = scan.image.height - overlap;
  TrueScan both = Cut(scan, {0, 0, 0, -(next.height - overlap)}, 18);
  PutInto(next, 0, at, &both.image);
  return both;
}

void WriteTiffScan(const std::string& path, const Image& scan, const TiffOptions& options) {
  constexpr std::uint32_t kShort = 3, kLong = 4, kRational = 5, kRowsOfStrip = 64;
  const bool tagged = options.dpi.x() > 0;
  const auto width = static_cast<std::uint32_t>(scan.width);
  const auto height = static_cast<std::uint32_t>(scan.height);
  const std::uint32_t strips = (height + kRowsOfStrip - 1) / kRowsOfStrip;
  const std::uint32_t row_bytes = options.one_bit ? (width + 7) / 8 : width;
  const std::uint32_t entries = tagged ? 12 : 9;
  const std::uint32_t dpi_at = 8 + 2 + 12 * entries + 4;
  const std::uint32_t offsets_at = dpi_at + 16, counts_at = offsets_at + 4 * strips;
  const std::uint32_t data_at = counts_at + 4 * strips;
  Bytes head;
  head.Add16(0x4949);
  head.Add16(42);
  head.Add32(8);
  head.Add16(entries);
  head.AddEntry(256, kLong, 1, width);
  head.AddEntry(257, kLong, 1, height);
  head.AddEntry(258, kShort, 1, options.one_bit ? 1 : 8);
  head.AddEntry(259, kShort, 1, 1);  // uncompressed
  head.AddEntry(262, kShort, 1, 1);  // black is zero
  head.AddEntry(273, kLong, strips, strips > 1 ? offsets_at : data_at);
  head.AddEntry(277, kShort, 1, 1);
  head.AddEntry(278, kLong, 1, kRowsOfStrip);
  head.AddEntry(279, kLong, strips, strips > 1 ? counts_at : height * row_bytes);
  if (tagged) {
    head.AddEntry(282, kRational, 1, dpi_at);
    head.AddEntry(283, kRational, 1, dpi_at + 8);
    head.AddEntry(296, kShort, 1, 2);  // pixels per inch
  }
  head.Add32(0);
  for (const double dpi : {options.dpi.x(), options.dpi.y()}) {
    head.Add32(static_cast<std::uint32_t>(std::lround(1000 * dpi)));
    head.Add32(1000);
  }
  for (std::uint32_t s = 0; s < strips; ++s) head.Add32(data_at + s * kRowsOfStrip * row_bytes);
  for (std::uint32_t s = 0; s < strips; ++s)
    head.Add32(std::min(kRowsOfStrip, height - s * kRowsOfStrip) * row_bytes);
  std::ofstream file(path, std::ios::binary);
  file.write(head.All().data(), static_cast<std::streamsize>(head.All().size()));
  for (int row = 0; row < scan.height; ++row) {
    const std::vector<char> bytes = Row(scan, row, options.one_bit);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

}  // namespace orient

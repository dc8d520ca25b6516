#include "tests/support/film_frame.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/raster/raster.h"
#include "core/raster/resample.h"
#include "tests/support/film_signs.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kBlack = 18;  // unexposed film

double Lattice(int x, int y, unsigned seed) {
  unsigned h = seed * 374761393u + static_cast<unsigned>(x) * 668265263u +
               static_cast<unsigned>(y) * 2246822519u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return static_cast<double>((h ^ (h >> 16)) & 0xffffu) / 65535.0;
}

double ValueNoise(double x, double y, unsigned seed) {
  const double fx = std::floor(x), fy = std::floor(y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const double u = x - fx, v = y - fy;
  const double top = (1 - u) * Lattice(ix, iy, seed) + u * Lattice(ix + 1, iy, seed);
  const double low = (1 - u) * Lattice(ix, iy + 1, seed) + u * Lattice(ix + 1, iy + 1, seed);
  return (1 - v) * top + v * low;
}

// Fields with borders, roads, and texture of all sizes; sizes in pixels.
double TextureAt(double x, double y, unsigned seed) {
  double value = 0, weight = 0, amplitude = 1;
  for (int octave = 0; octave < 6; ++octave) {
    const double size = 160.0 / (1 << octave);
    value += amplitude * ValueNoise(x / size, y / size, seed + 17u * octave);
    weight += amplitude;
    amplitude *= 0.75;
  }
  const double field = Lattice(static_cast<int>(std::floor(x / 37)),
                               static_cast<int>(std::floor(y / 29)), seed + 991u);
  const double road = std::abs(ValueNoise(x / 90, y / 90, seed + 5u) - 0.5) < 0.012 ? 60 : 0;
  return 20 + 130 * value / weight + 60 * field + road;
}

// Averages over a pixel: share of the surroundings that shows through, and brightness of the mark.
struct Paint {
  double surroundings = 0, mark = 0;
};

Paint PaintOver(const MarkDrawing& drawing, const Vector2d& corner_px, const Vector2d& mark_px,
                const Matrix2d& mm_from_px) {
  constexpr int kSamples = 8;
  Paint paint;
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      const Vector2d at = corner_px + Vector2d(i + 0.5, j + 0.5) / kSamples;
      const double brightness = PaintedBrightness(drawing.elements, mm_from_px * (at - mark_px));
      paint.surroundings += (1 - std::abs(brightness)) / (kSamples * kSamples);
      paint.mark += std::max(brightness, 0.0) / (kSamples * kSamples);
    }
  }
  return paint;
}

void DrawMark(const MarkDrawing& drawing, const Vector2d& mark_px, const Matrix2d& mm_from_px,
              double brightness, Image* scan) {
  const int reach = static_cast<int>(4 / std::sqrt(std::abs(mm_from_px.determinant())));
  const int col0 = static_cast<int>(mark_px.x()), row0 = static_cast<int>(mark_px.y());
  for (int row = row0 - reach; row <= row0 + reach; ++row) {
    for (int col = col0 - reach; col <= col0 + reach; ++col) {
      if (col < 0 || row < 0 || col >= scan->width || row >= scan->height) continue;
      const Paint paint = PaintOver(drawing, Vector2d(col, row), mark_px, mm_from_px);
      float& value = scan->At(col, row);
      value = static_cast<float>(paint.surroundings * static_cast<double>(value) +
                                 paint.mark * brightness);
    }
  }
}

// Film without marks: black rebate, round dark corners under the marks, texture elsewhere.
void DrawFilm(const FilmFrameSpec& spec, const Affine2d& photo_from_pixel, Image* scan) {
  constexpr double kCornerMm = 6;
  for (int row = 0; row < scan->height; ++row) {
    for (int col = 0; col < scan->width; ++col) {
      const Vector2d mm = photo_from_pixel * Vector2d(col + 0.5, row + 0.5);
      bool dark = !spec.camera.camera.InFrame(mm);
      for (const Fiducial& f : spec.camera.fiducials)
        dark = dark || (spec.dark_corners && (mm - f.position_mm).norm() < kCornerMm);
      scan->At(col, row) = static_cast<float>(dark ? kBlack : TextureAt(col, row, spec.seed));
    }
  }
}

void AddGrain(double sigma, Polarity polarity, unsigned seed, Image* scan) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0.0f, 1.0f);
  for (float& value : scan->values) {
    value = std::clamp(value + static_cast<float>(sigma) * normal(random), 0.0f, 255.0f);
    if (polarity == Polarity::kNegative) value = 255 - value;
  }
}

}  // namespace

FilmFrame RenderFilmFrame(const FilmFrameSpec& spec) {
  const Vector2d film = spec.camera.camera.frame_mm + Vector2d::Constant(2 * spec.rebate_mm);
  const Matrix2d axes = PhotoFromPixelAxes(spec.orientation);
  const Vector2d size = (axes.transpose() * film).cwiseAbs() / spec.pixel_mm;
  FilmFrame frame;
  frame.scan = Image(static_cast<int>(size.x()), static_cast<int>(size.y()));
  frame.pixel_from_photo.A = spec.scale.asDiagonal() *
                             Eigen::Rotation2Dd(spec.turn_rad).toRotationMatrix() *
                             axes.transpose() / spec.pixel_mm;
  frame.pixel_from_photo.t = 0.5 * size + spec.shift_px;
  DrawFilm(spec, frame.pixel_from_photo.Inverse(), &frame.scan);
  const Matrix2d mm_from_px = frame.pixel_from_photo.A.inverse();
  for (size_t i = 0; i < spec.camera.fiducials.size(); ++i) {
    const Fiducial& f = spec.camera.fiducials[i];
    frame.mark_pixels.push_back(frame.pixel_from_photo * f.position_mm);
    const bool missing = std::find(spec.missing.begin(), spec.missing.end(), static_cast<int>(i)) !=
                         spec.missing.end();
    if (spec.marks && !missing)
      DrawMark(spec.camera.marks.at(f.mark), frame.mark_pixels.back(), mm_from_px,
               spec.mark_brightness, &frame.scan);
  }
  const SignBrightness brightness{kBlack, spec.mark_brightness};
  DrawBorder(spec.camera, frame.pixel_from_photo, brightness, &frame.scan);
  if (spec.marks)
    DrawSymbols(spec.camera, frame.pixel_from_photo, brightness, spec.missing, &frame.scan);
  frame.scan = GaussianBlur(frame.scan, spec.blur_sigma_px);
  AddGrain(spec.noise, spec.polarity, spec.seed, &frame.scan);
  return frame;
}

Image RenderTexture(int width, int height, unsigned seed) {
  Image image(width, height);
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col)
      image.At(col, row) = static_cast<float>(TextureAt(col, row, seed));
  AddGrain(4, Polarity::kPositive, seed, &image);
  return image;
}

void WriteScan(const std::string& path, const Image& scan) {
  std::vector<unsigned char> bytes;
  bytes.reserve(scan.values.size());
  for (const float value : scan.values)
    bytes.push_back(static_cast<unsigned char>(std::lround(std::clamp(value, 0.0f, 255.0f))));
  WritePng(path, scan.width, scan.height, 1, bytes);
}

CameraFile RingCamera(double mark_mm, double frame_mm) {
  CameraFile file;
  file.camera.name = "ring";
  file.camera.principal_distance_mm = 153;
  file.camera.frame_mm = Vector2d(frame_mm, frame_mm);
  MarkDrawing corner;
  corner.elements = {CircleElement{1.7, 0.2}, CrossElement{3.52, 0.13, 0.56, std::numbers::pi / 4}};
  file.marks["corner"] = corner;
  const double m = mark_mm;
  const std::vector<Vector2d> places = {{-m, -m}, {m, m}, {-m, m}, {m, -m}};
  for (const Vector2d& place : places)
    file.fiducials.push_back(
        {std::to_string(file.fiducials.size() + 1), place, "corner", std::nullopt});
  return file;
}

}  // namespace orient

#include "tests/tools/simulate/film_scan.h"

#include <tbb/parallel_for.h>

#include "tools/simulate/film_drawing.h"
#include "tools/simulate/geotiff.h"
#include "tools/simulate/noise.h"
#include "tools/simulate/scanner.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr double kAroundMark_mm = 19;   // more than any search for it looks at
constexpr double kBorderInside_mm = 1;  // of the frame's edge
constexpr double kTallestBand_px = 2000;

struct Part {
  Vector2i origin, size;
};

// What of the scan the rectangle between two places of the film covers.
Part PartOfScan(const ScanGeometry& scan, const Vector2d& a, const Vector2d& b) {
  const Vector2d p = scan.PixelFromPhoto(a), q = scan.PixelFromPhoto(b);
  const Vector2d r = scan.PixelFromPhoto({a.x(), b.y()}), s = scan.PixelFromPhoto({b.x(), a.y()});
  const Vector2d low = p.cwiseMin(q).cwiseMin(r).cwiseMin(s);
  const Vector2d high = p.cwiseMax(q).cwiseMax(r).cwiseMax(s);
  const Vector2i from = low.array().floor().max(0.0).cast<int>();
  const Vector2i to = high.array().ceil().cast<int>();
  const Vector2i scan_px(scan.Setup().width, scan.Setup().height);
  return {from, (to.cwiseMin(scan_px) - from).cwiseMax(0)};
}

std::vector<Part> AroundMarks(const SimulatedCamera& camera, const ScanGeometry& scan) {
  std::vector<Part> parts;
  const Vector2d around = Vector2d::Constant(kAroundMark_mm);
  for (const Fiducial& fiducial : camera.file.fiducials)
    parts.push_back(PartOfScan(scan, fiducial.position_mm - around, fiducial.position_mm + around));
  return parts;
}

// The rebate on the four sides, in pieces that are small enough for memory.
std::vector<Part> Border(const SimulatedCamera& camera, const ScanGeometry& scan) {
  const Vector2d half = 0.5 * camera.file.camera.frame_mm;
  const Vector2d film = half.array() + (camera.film_half_mm - half.maxCoeff() + 1);
  const Vector2d edge = half.array() - kBorderInside_mm;
  std::vector<Part> parts = {PartOfScan(scan, {-film.x(), -film.y()}, {-edge.x(), film.y()}),
                             PartOfScan(scan, {edge.x(), -film.y()}, {film.x(), film.y()}),
                             PartOfScan(scan, {-film.x(), -film.y()}, {film.x(), -edge.y()}),
                             PartOfScan(scan, {-film.x(), edge.y()}, {film.x(), film.y()})};
  std::vector<Part> pieces;
  const auto most = static_cast<int>(kTallestBand_px);
  for (const Part& part : parts)
    for (int row = 0; row < part.size.y(); row += most)
      for (int col = 0; col < part.size.x(); col += most)
        pieces.push_back(
            {part.origin + Vector2i(col, row),
             {std::min(most, part.size.x() - col), std::min(most, part.size.y() - row)}});
  return pieces;
}

std::vector<Part> PartsToDraw(const SimulatedCamera& camera, const ScanGeometry& scan) {
  std::vector<Part> parts;
  if (camera.file.data_strip || !camera.file.border.empty()) parts = Border(camera, scan);
  const std::vector<Part> marks = AroundMarks(camera, scan);
  const std::int64_t all = static_cast<std::int64_t>(scan.Setup().width) *
                           static_cast<std::int64_t>(scan.Setup().height);
  std::int64_t drawn = 0;
  for (const Part& part : marks)
    drawn += static_cast<std::int64_t>(part.size.x()) * static_cast<std::int64_t>(part.size.y());
  if (drawn > all) return {{Vector2i::Zero(), {scan.Setup().width, scan.Setup().height}}};
  parts.insert(parts.end(), marks.begin(), marks.end());
  return parts;
}

// Interleaved bands of 8 bit; a warm tint keeps the grey value's order and nearly its contrast.
std::vector<std::uint16_t> Tinted(const std::vector<std::uint16_t>& grey) {
  std::vector<std::uint16_t> rgb;
  rgb.reserve(3 * grey.size());
  for (const std::uint16_t value : grey) {
    rgb.push_back(value);
    rgb.push_back(static_cast<std::uint16_t>(value * 15 / 16));
    rgb.push_back(static_cast<std::uint16_t>(value * 3 / 4));
  }
  return rgb;
}

}  // namespace

float PictureTone(std::uint32_t seed, const Vector2d& photo_mm) {
  const auto x = static_cast<float>(photo_mm.x()), y = static_cast<float>(photo_mm.y());
  const float bend = 0.6f * ValueNoise(seed + 1, 0.15f * x, 0.15f * y);
  const std::int32_t u = FloorInt(0.45f * x + bend), v = FloorInt(0.35f * y - bend);
  const float field = Unit(Hash(seed + 2, u, v));
  // Roads run between the fields: lines and crossings like a mark's own.
  const float across = 0.45f * x + bend - static_cast<float>(u);
  const float along = 0.35f * y - bend - static_cast<float>(v);
  const bool road = (u % 3 == 0 && across < 0.04f) || (v % 2 == 0 && along < 0.03f);
  if (road) return 0.75f;
  return std::clamp(0.15f + 0.5f * field + 0.18f * FractalNoise(seed + 3, 2.5f * x, 2.5f * y, 4),
                    0.0f, 1.0f);
}

void WriteFilmScan(const std::string& path, const SimulationOptions& options,
                   const FilmScanOptions& look, const SimulatedCamera& camera,
                   const PhotoPlan& plan) {
  FilmFrame film = FilmOf(camera, plan);
  film.mark_tone = look.mark_tone;
  const std::vector<Part> parts = PartsToDraw(camera, plan.scan);
  const ScanSetup& setup = plan.scan.Setup();
  SparseTiff tiff(path, {setup.width, setup.height, look.rgb ? 3 : 1, options.bits},
                  setup.pixel_size_mm);
  ScannerOptions scanner = ScannerOf(options, plan);
  for (const Part& part : parts) {
    if (part.size.minCoeff() <= 0) continue;
    Image image(part.size.x(), part.size.y());
    tbb::parallel_for(0, image.height, [&](int row) {
      for (int col = 0; col < image.width; ++col)
        image.At(col, row) = PictureTone(
            plan.seed,
            plan.scan.PhotoFromPixel(part.origin.cast<double>() + Vector2d(col + 0.5, row + 0.5)));
    });
    DrawFilm(film, plan.scan, options.blur_px, &image, part.origin);
    ++scanner.seed;
    const std::vector<std::uint16_t> grey = Scan(image, scanner);
    tiff.Write(part.origin, part.size, look.rgb ? Tinted(grey) : grey);
  }
  tiff.Finish();
}

}  // namespace orient::simulation

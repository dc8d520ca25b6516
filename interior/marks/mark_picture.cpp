#include "interior/marks/mark_picture.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/raster/grey_range.h"
#include "core/raster/picture_text.h"
#include "core/raster/resample.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr int kTile = 240;
constexpr int kGap = kMarkTileGap;
struct Colour {
  unsigned char r, g, b;
};
constexpr Colour kUsed{60, 255, 60};
constexpr Colour kRejected{255, 140, 0};
constexpr unsigned char kEmpty = 90;

void SetPixel(Picture* picture, int col, int row, Colour colour) {
  unsigned char* p = &picture->rgb[3 * (static_cast<size_t>(row) * picture->width + col)];
  p[0] = colour.r;
  p[1] = colour.g;
  p[2] = colour.b;
}

void DrawTile(const Image& image, double enlarged, int left, int top, Picture* picture) {
  const auto [low, brightest] = GreyRange(image);
  const float high = std::max(brightest, low + 1.0f);
  for (int row = 0; row < kTile; ++row) {
    for (int col = 0; col < kTile; ++col) {
      const float value = SampleBilinear(image, Vector2d(col + 0.5, row + 0.5) / enlarged);
      if (std::isnan(value)) continue;
      const float grey = std::clamp(255 * (value - low) / (high - low), 0.0f, 255.0f);
      const auto level = static_cast<unsigned char>(grey);
      SetPixel(picture, left + col, top + row, {level, level, level});
    }
  }
}

// Open at the centre, so that it hides nothing of what it points at.
void DrawCross(const Vector2d& at, int left, Colour colour, Picture* picture) {
  const int col = static_cast<int>(std::floor(at.x())), row = static_cast<int>(std::floor(at.y()));
  const auto set = [&](int c, int r) {
    if (c >= 0 && c < kTile && r >= 0 && r < kTile) SetPixel(picture, left + c, r, colour);
  };
  set(col, row);
  for (int d = 6; d < 30; ++d) {
    set(col + d, row);
    set(col - d, row);
    set(col, row + d);
    set(col, row - d);
  }
}

// Colours the pixels of a tile that an element's outline crosses. `mm_from_tile`: for offsets from
// the mark's centre.
void DrawOutline(const MarkDrawing& drawing, const Eigen::Matrix2d& mm_from_tile,
                 const Vector2d& centre, int left, int top, Colour colour, Picture* picture) {
  const double half_mm = 0.75 * std::sqrt(std::abs(mm_from_tile.determinant()));
  for (int row = 0; row < kTile; ++row)
    for (int col = 0; col < kTile; ++col) {
      const Vector2d mm = mm_from_tile * (Vector2d(col + 0.5, row + 0.5) - centre);
      if (std::abs(StrokeDistance(drawing, mm)) < half_mm)
        SetPixel(picture, left + col, top + row, colour);
    }
}

// The drawing, brighter or darker than its surroundings as on the scan; elsewhere even.
Image AsScanned(const DrawnMark& mark, const Eigen::Matrix2d& pixel_from_mm, int size,
                const Vector2d& centre, bool negative) {
  RenderOptions options;
  options.offset_px =
      centre - Vector2d(std::floor(centre.x()), std::floor(centre.y())) - Vector2d::Constant(0.5);
  options.whole_square = true;
  const MarkTemplate drawn = RenderMark(mark.shape, pixel_from_mm, options);
  Image image(size, size, mark.shape.picture ? kNoData : 0.0f);
  const int left = static_cast<int>(std::lround(centre.x() - drawn.centre.x()));
  const int top = static_cast<int>(std::lround(centre.y() - drawn.centre.y()));
  for (int row = std::max(0, -top); row < drawn.values.height && row + top < size; ++row)
    for (int col = std::max(0, -left); col < drawn.values.width && col + left < size; ++col)
      image.At(col + left, row + top) = (negative ? -1.0f : 1.0f) * drawn.values.At(col, row);
  return image;
}

}  // namespace

Picture DrawMarks(const Raster& scan, const InteriorResult& result,
                  const std::vector<Vector2d>& photo_mm, double pixel_mm, double reach_mm) {
  Picture picture;
  picture.width = std::max(1, static_cast<int>(result.marks.size()) * (kTile + kGap) - kGap);
  picture.height = kTile;
  picture.rgb.assign(3 * static_cast<size_t>(picture.width) * kTile, kEmpty);
  const int half = std::max(4, static_cast<int>(std::ceil(reach_mm / pixel_mm)));
  for (size_t i = 0; i < result.marks.size(); ++i) {
    const MarkResult& mark = result.marks[i];
    std::optional<Vector2d> at = mark.pixel;
    if (!at && result.photo_from_pixel) at = result.photo_from_pixel->Inverse() * photo_mm[i];
    if (!at) continue;
    const int left = static_cast<int>(i) * (kTile + kGap);
    const ImageWindow seen =
        scan.ReadGrey({static_cast<int>(std::floor(at->x())) - half,
                       static_cast<int>(std::floor(at->y())) - half, 2 * half + 1, 2 * half + 1});
    const double enlarged = static_cast<double>(kTile) / seen.image.width;
    DrawTile(seen.image, enlarged, left, 0, &picture);
    if (mark.state == MarkState::kMissing) continue;
    DrawCross(enlarged * seen.ImageFromRaster(*at), left,
              mark.state == MarkState::kUsed ? kUsed : kRejected, &picture);
  }
  return picture;
}

Picture DrawDrawings(const Raster& scan, const std::vector<DrawnMark>& marks,
                     const Eigen::Matrix2d& pixel_from_mm, bool negative) {
  constexpr double kAround_mm = 0.5;
  constexpr int kRows = 3, kTextHeight = 14;
  double reach_mm = 0;
  for (const DrawnMark& mark : marks) reach_mm = std::max(reach_mm, MarkRadius(mark.shape));
  const double pixels_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  const int half =
      std::max(4, static_cast<int>(std::ceil((reach_mm + kAround_mm) * pixels_per_mm)));
  const int size = 2 * half + 1;
  const double enlarged = static_cast<double>(kTile) / size;
  Picture picture;
  picture.width = std::max(1, static_cast<int>(marks.size()) * (kTile + kGap) - kGap);
  picture.height = kRows * (kTile + kGap) - kGap;
  picture.rgb.assign(3 * static_cast<size_t>(picture.width) * picture.height, kEmpty);
  for (size_t i = 0; i < marks.size(); ++i) {
    const DrawnMark& mark = marks[i];
    const int left = static_cast<int>(i) * (kTile + kGap);
    const ImageWindow seen =
        scan.ReadGrey({static_cast<int>(std::floor(mark.pixel.x())) - half,
                       static_cast<int>(std::floor(mark.pixel.y())) - half, size, size});
    const Vector2d centre = seen.ImageFromRaster(mark.pixel);
    DrawTile(seen.image, enlarged, left, 0, &picture);
    DrawTile(seen.image, enlarged, left, kTile + kGap, &picture);
    DrawOutline(mark.shape.drawing, pixel_from_mm.inverse() / enlarged, enlarged * centre, left,
                kTile + kGap, mark.found ? kUsed : kRejected, &picture);
    DrawTile(AsScanned(mark, pixel_from_mm, size, centre, negative), enlarged, left,
             2 * (kTile + kGap), &picture);
    DrawText(mark.id, left + 4, kTextHeight + 6, kTextHeight, {255, 255, 0}, picture.width,
             &picture.rgb);
  }
  return picture;
}

}  // namespace orient::interior

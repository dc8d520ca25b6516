#include "tests/support/film_signs.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace orient {
namespace {

using Eigen::Vector2d;

bool InSymbol(const MarkSymbol& symbol, const Vector2d& at) {
  constexpr double kBarLength = 0.9, kBarWidth = 0.16, kDotDiameter = 0.3;
  const Vector2d step = symbol.step_mm.value_or(kSymbolStep_mm);
  const Vector2d along = step.normalized();
  for (int i = 0; i < symbol.count; ++i) {
    const Vector2d d = at - symbol.at_mm.value_or(kSymbolAt_mm) - i * step;
    const double across = along.x() * d.y() - along.y() * d.x();
    const bool inside =
        symbol.kind == SymbolKind::kDots
            ? d.norm() < 0.5 * kDotDiameter
            : std::abs(along.dot(d)) < 0.5 * kBarWidth && std::abs(across) < 0.5 * kBarLength;
    if (inside) return true;
  }
  return false;
}

// Characters 1.7 mm high and 1.4 mm wide of 0.28 mm squares, a third of which are bright.
bool InWriting(const Vector2d& at) {
  const double u = at.x() / 0.28, v = at.y() / 0.28;
  const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
  if ((i % 6 + 6) % 6 == 5 || (j % 8 + 8) % 8 >= 6) return false;
  unsigned h = static_cast<unsigned>(i) * 668265263u + static_cast<unsigned>(j) * 2246822519u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return ((h ^ (h >> 16)) & 0xffu) < 85;
}

// Sets the tones given by `tone_at` between two corners (photo mm); NaN leaves the scan unchanged.
template <typename ToneAt>
void Paint(const Affine2d& pixel_from_photo, const Vector2d& low, const Vector2d& high,
           ToneAt tone_at, Image* scan) {
  constexpr int kSamples = 4;
  const Affine2d photo_from_pixel = pixel_from_photo.Inverse();
  Eigen::AlignedBox2d box;
  for (const double x : {low.x(), high.x()})
    for (const double y : {low.y(), high.y()}) box.extend(pixel_from_photo * Vector2d(x, y));
  const int col1 = std::min(scan->width, static_cast<int>(box.max().x()) + 1);
  const int row1 = std::min(scan->height, static_cast<int>(box.max().y()) + 1);
  for (int row = std::max(0, static_cast<int>(box.min().y())); row < row1; ++row) {
    for (int col = std::max(0, static_cast<int>(box.min().x())); col < col1; ++col) {
      double sum = 0;
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const int i = k % kSamples, j = k / kSamples;
        const Vector2d sub((i + 0.5) / kSamples, (j + 0.5) / kSamples);
        const Vector2d at = photo_from_pixel * (Vector2d(col, row) + sub);
        const bool inside = (at - low).minCoeff() >= 0 && (high - at).minCoeff() >= 0;
        const double tone = inside ? tone_at(at) : std::nan("");
        sum += std::isnan(tone) ? static_cast<double>(scan->At(col, row)) : tone;
      }
      scan->At(col, row) = static_cast<float>(sum / (kSamples * kSamples));
    }
  }
}

BorderFeature StripOf(const CameraFile& camera) {
  const FrameSide side = camera.data_strip.value();
  const Vector2d half = 0.5 * camera.camera.frame_mm, centre = camera.camera.frame_centre_mm;
  const int axis = side == FrameSide::kLeft || side == FrameSide::kRight ? 0 : 1;
  const double sign = side == FrameSide::kLeft || side == FrameSide::kBottom ? -1 : 1;
  const Vector2d reach = 2.0 / 3.0 * half;
  BorderFeature strip{BorderSign::kText, centre - reach, centre + reach};
  const double a = centre[axis] + sign * (half[axis] + 1), b = a + sign * 3;
  strip.from_mm[axis] = std::min(a, b);
  strip.to_mm[axis] = std::max(a, b);
  return strip;
}

}  // namespace

void DrawSymbols(const CameraFile& camera, const Affine2d& pixel_from_photo,
                 const SignBrightness& brightness, const std::vector<int>& missing, Image* scan) {
  const Vector2d reach = Vector2d::Constant(7);
  for (size_t i = 0; i < camera.fiducials.size(); ++i) {
    const Fiducial& f = camera.fiducials[i];
    const bool absent =
        std::find(missing.begin(), missing.end(), static_cast<int>(i)) != missing.end();
    if (!f.symbol || absent) continue;
    const auto tone = [&](const Vector2d& at) {
      return InSymbol(*f.symbol, at - f.position_mm) ? brightness.bright : std::nan("");
    };
    Paint(pixel_from_photo, f.position_mm - reach, f.position_mm + reach, tone, scan);
  }
}

void DrawBorder(const CameraFile& camera, const Affine2d& pixel_from_photo,
                const SignBrightness& brightness, Image* scan) {
  std::vector<BorderFeature> features = camera.border;
  if (camera.data_strip) features.push_back(StripOf(camera));
  for (const BorderFeature& feature : features) {
    const auto tone = [&](const Vector2d& at) {
      if (feature.shows == BorderSign::kBright) return brightness.bright;
      return feature.shows == BorderSign::kText && InWriting(at) ? brightness.bright
                                                                 : brightness.dark;
    };
    Paint(pixel_from_photo, feature.from_mm, feature.to_mm, tone, scan);
  }
}

}  // namespace orient

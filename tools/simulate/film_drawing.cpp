#include "tools/simulate/film_drawing.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numbers>

#include "tools/simulate/noise.h"
#include "tools/simulate/scanner.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;

constexpr float kRebate = 0.06f;       // unexposed film beside the frame, on the positive
constexpr float kHolder = 0.015f;      // what the scanner sees beyond the film
constexpr float kTextOfMark = 0.8f;    // the text's contrast, as a share of the marks'
constexpr double kSymbolReach_mm = 7;  // no symbol reaches farther from its mark
const Vector2d kSymbolAt_mm(2.4, 0), kSymbolStep_mm(0.5, 0);  // where the camera file does not say
constexpr double kMarkPadding_mm = 0.6;  // dark around a mark whose background is dark

// The film's characteristic curve: a toe, a straight part and a shoulder.
float Exposed(float tone) {
  const float t = std::clamp(1.2f * tone, 0.0f, 1.0f);
  return 0.08f + 0.84f * (0.55f * t + 0.45f * t * t * (3 - 2 * t));
}

// Share of a pixel that lies inside an edge `distance` away (positive inside).
float Inside(double distance_mm, double pixel_mm) {
  return static_cast<float>(std::clamp(distance_mm / pixel_mm + 0.5, 0.0, 1.0));
}

// A five by seven dot pattern that looks like a character.
bool InGlyph(std::uint32_t glyph, double u, double v) {
  const int col = static_cast<int>(std::floor(u * 6)), row = static_cast<int>(std::floor(v * 7));
  if (col < 0 || row < 0 || col >= 5 || row >= 7) return false;
  // Mirror half of the glyphs: strokes that look drawn and not scattered.
  const int stroke_col = (glyph & 1u) != 0 ? std::min(col, 4 - col) : col;
  const bool stem = stroke_col == 0 && (glyph & 2u) != 0;
  const bool bar = (row == 0 && (glyph & 4u) != 0) || (row == 3 && (glyph & 8u) != 0) ||
                   (row == 6 && (glyph & 16u) != 0);
  const bool foot = stroke_col == 2 && (glyph & 32u) != 0 && row > 2;
  return stem || bar || foot;
}

// The data strip runs along the photo's left side, read from the bottom up.
bool InDataStrip(const FilmFrame& film, const Vector2d& photo) {
  const Camera& camera = film.camera.camera;
  const double room = film.film_half_mm - 0.5 * camera.frame_mm.maxCoeff();
  const double size = 0.55 * room;  // of a character
  const double across = camera.frame_centre_mm.x() - 0.5 * camera.frame_mm.x() - photo.x();
  const double along = photo.y() - camera.frame_centre_mm.y() + 0.38 * camera.frame_mm.y();
  const double pitch = 0.8 * size;
  const auto letter = static_cast<std::int32_t>(std::floor(along / pitch));
  if (along < 0 || along > 0.76 * camera.frame_mm.y()) return false;
  const std::uint32_t glyph = Hash(film.seed, letter);
  if (Unit(Mix(glyph)) < 0.22f) return false;  // a space between words
  constexpr double kClearOfMarks_mm = 8;
  for (const Fiducial& fiducial : film.camera.fiducials)
    if ((fiducial.position_mm - photo).norm() < kClearOfMarks_mm) return false;
  const double v = (0.75 * room - across) / size;
  return InGlyph(glyph | 2u, along / pitch - letter, 1 - v);
}

bool InCross(const CrossElement& cross, const Vector2d& point) {
  const double c = std::cos(cross.angle_rad), s = std::sin(cross.angle_rad);
  const Vector2d at = point - cross.at_mm;
  const double u = std::abs(c * at.x() + s * at.y()), v = std::abs(c * at.y() - s * at.x());
  const auto in_arm = [&](double along, double across) {
    return across <= 0.5 * cross.width_mm && along <= 0.5 * cross.length_mm &&
           along >= 0.5 * cross.gap_mm;
  };
  return in_arm(u, v) || in_arm(v, u);
}

bool InElement(const MarkElement& element, const Vector2d& at) {
  if (const auto* cross = std::get_if<CrossElement>(&element)) return InCross(*cross, at);
  if (const auto* dot = std::get_if<DotElement>(&element))
    return (at - dot->at_mm).norm() <= 0.5 * dot->diameter_mm;
  return SignedDistance(element, at) <= 0;
}

// The rebate is equally wide on all sides of the frame.
Vector2d FilmHalf(const FilmFrame& film) {
  const Vector2d half = 0.5 * film.camera.camera.frame_mm;
  return half.array() + (film.film_half_mm - half.maxCoeff());
}

// The tone of what the camera file says of the border, else `tone`.
float BorderTone(const FilmFrame& film, const Vector2d& photo, float tone) {
  for (const BorderFeature& feature : film.camera.border) {
    const bool inside =
        (photo - feature.from_mm).minCoeff() >= 0 && (feature.to_mm - photo).minCoeff() >= 0;
    if (inside && feature.shows == BorderSign::kDark) return kRebate;
    if (inside && feature.shows == BorderSign::kBright) return film.mark_tone;
  }
  return tone;
}

// The rebate, the film's edge and the text, pixel by pixel.
void DrawRebate(const FilmFrame& film, const ScanGeometry& scan, const Eigen::Vector2i& origin,
                Image* image) {
  const float text = kRebate + kTextOfMark * (film.mark_tone - kRebate);
  const Camera& camera = film.camera.camera;
  const double pixel = scan.Setup().pixel_size_mm;
  tbb::parallel_for(0, image->height, [&](int row) {
    for (int col = 0; col < image->width; ++col) {
      const Vector2d photo =
          scan.PhotoFromPixel(origin.cast<double>() + Vector2d(col + 0.5, row + 0.5));
      const Vector2d from_centre = (photo - camera.frame_centre_mm).cwiseAbs();
      const double in_frame = (0.5 * camera.frame_mm - from_centre).minCoeff();
      float& value = image->At(col, row);
      const float picture = BorderTone(film, photo, Exposed(value));
      if (in_frame > pixel) {
        value = picture;
        continue;
      }
      float rebate = BorderTone(film, photo, kRebate);
      if (film.data_strip && InDataStrip(film, photo)) rebate = text;
      const float on_film = Inside((FilmHalf(film) - from_centre).minCoeff(), pixel);
      rebate = kHolder + (rebate - kHolder) * on_film;
      value = rebate + (picture - rebate) * Inside(in_frame, pixel);
    }
  });
}

float PaddingTone(const FilmFrame& film, size_t index, const Vector2d& at) {
  if (film.conditions[index] != MarkCondition::kDirty) return kRebate;
  // A hair across the mark and a bright blot over one part of it.
  const std::uint32_t seed = Hash(film.seed + 5, static_cast<std::int32_t>(index));
  const double angle = 3.1 * static_cast<double>(Unit(seed));
  const double across = at.x() * std::sin(angle) - at.y() * std::cos(angle) + 0.2;
  const Vector2d blot(0.5 * std::cos(angle), 0.5 * std::sin(angle));
  if (std::abs(across + 0.15 * std::sin(3 * at.x())) < 0.035) return 0.6f;
  return (at - blot).norm() < 0.22 ? 0.7f : kRebate;
}

// Three scratches within 0.6 mm of the mark's centre, the emulsion gone or the base gouged.
float Scratched(std::uint32_t seed, const Vector2d& at, float tone) {
  for (std::int32_t i = 0; i < 3; ++i) {
    const std::uint32_t scratch = Hash(seed, i);
    const double angle = 3.14 * static_cast<double>(Unit(scratch));
    const double past = 1.2 * static_cast<double>(Unit(Mix(scratch))) - 0.6;
    const double across = at.x() * std::sin(angle) - at.y() * std::cos(angle) + past;
    if (std::abs(across) < 0.025 + 0.01 * i) return i == 1 ? 0.02f : 0.95f;
  }
  return tone;
}

// Every third cell of 0.3 mm has a speck, bright or dark.
float Dusty(std::uint32_t seed, const Vector2d& at, float tone) {
  constexpr double kCell_mm = 0.3;
  const Vector2d cell = (at / kCell_mm).array().floor();
  const std::uint32_t speck =
      Hash(seed, static_cast<std::int32_t>(cell.x()), static_cast<std::int32_t>(cell.y()));
  if (Unit(speck) > 0.33f) return tone;
  const std::uint32_t look = Mix(speck);
  const double radius = 0.03 + 0.06 * static_cast<double>(Unit(look));
  const Vector2d middle(0.3 + 0.4 * static_cast<double>(Unit(Mix(look))),
                        0.3 + 0.4 * static_cast<double>(Unit(Mix(look + 1))));
  if ((at - kCell_mm * (cell + middle)).norm() > radius) return tone;
  return (look & 1u) != 0 ? 0.9f : 0.03f;
}

// Is this place in the quarter of the mark that was not exposed?
bool Lost(std::uint32_t seed, const CrossElement* cross, const Vector2d& at) {
  const double quarter = 0.5 * std::numbers::pi;
  const double arm = (cross ? cross->angle_rad : 0) + quarter * (seed % 4);
  return Vector2d(std::cos(arm), std::sin(arm)).dot(at) > std::cos(0.5 * quarter) * at.norm();
}

const CrossElement* CrossOf(const MarkDrawing& drawing) {
  for (const MarkElement& element : drawing.elements)
    if (const auto* cross = std::get_if<CrossElement>(&element)) return cross;
  return nullptr;
}

// Marks are drawn in so many finer pixels per axis and blurred there: the optics blur before the
// scanner's pixels average. Otherwise strokes of two pixels and less would be aliased too much.
constexpr int kFiner = 3;

// Where a finer pixel is sampled: a Fibonacci lattice, coarsest (1/11 of a scan's pixel) for edges
// at 34 and 56 degrees. Lattices of 5, 21 or 55 points are coarsest along the diagonals, along
// which marks are drawn, a square one along the pixels.
constexpr int kSamples = 13;
Vector2d Sample(int i) { return {(i + 0.5) / kSamples, (8 * i % kSamples + 0.5) / kSamples}; }

// Brightness 1 is the mark's tone, 0 what surrounds it and -1 black.
float MarkTone(const Fiducial& fiducial, const MarkDrawing& drawing, const Vector2d& at,
               float bright, float around) {
  if (fiducial.symbol && InSymbol(*fiducial.symbol, at)) return bright;
  const auto brightness = static_cast<float>(MarkBrightness(drawing, at));
  return std::max(brightness, 0.0f) * bright + (1 - std::abs(brightness)) * around;
}

// Whether a pixel may show part of the mark, its dark surroundings or its symbol.
bool MayShow(const Fiducial& fiducial, double padding, double pixel, const Vector2d& at) {
  if (at.cwiseAbs().maxCoeff() < padding + 2 * pixel) return true;
  if (!fiducial.symbol) return false;
  const Vector2d from_first = at - fiducial.symbol->at_mm.value_or(kSymbolAt_mm);
  const Vector2d step = fiducial.symbol->step_mm.value_or(kSymbolStep_mm);
  const double along = std::clamp(from_first.dot(step) / step.squaredNorm(), 0.0,
                                  static_cast<double>(fiducial.symbol->count));
  return (from_first - along * step).norm() < 0.7 + 2 * pixel;
}

// How far from its centre a mark, its dark surroundings or its symbol may be drawn.
double ReachOfMark(const FilmFrame& film, size_t index) {
  const Fiducial& fiducial = film.camera.fiducials[index];
  const double padding = MarkRadius(film.camera.marks.at(fiducial.mark)) + kMarkPadding_mm;
  return fiducial.symbol ? kSymbolReach_mm : 1.45 * padding;
}

// One mark, its dark surroundings and its symbol.
void DrawMark(const FilmFrame& film, size_t index, const ScanGeometry& scan,
              const Eigen::Vector2i& origin, Image* image) {
  const Fiducial& fiducial = film.camera.fiducials[index];
  const MarkDrawing& drawing = film.camera.marks.at(fiducial.mark);
  const bool dark = drawing.background == MarkBackground::kDark;
  const MarkCondition condition = film.conditions[index];
  const bool visible = condition != MarkCondition::kMissing;
  const std::uint32_t damage = Hash(film.seed + 6, static_cast<std::int32_t>(index));
  const double padding = MarkRadius(drawing) + kMarkPadding_mm;
  const double pixel = scan.Setup().pixel_size_mm;
  const double reach = ReachOfMark(film, index) + pixel;
  const Vector2d corner = origin.cast<double>();
  const Vector2d centre = scan.PixelFromPhoto(fiducial.position_mm) - corner;
  const int reach_px = static_cast<int>(std::ceil(reach / pixel)) + 1;
  const int col0 = std::max(0, static_cast<int>(centre.x()) - reach_px);
  const int row0 = std::max(0, static_cast<int>(centre.y()) - reach_px);
  const int col1 = std::min(image->width - 1, static_cast<int>(centre.x()) + reach_px);
  const int row1 = std::min(image->height - 1, static_cast<int>(centre.y()) + reach_px);
  tbb::parallel_for(row0, row1 + 1, [&](int row) {
    for (int col = col0; col <= col1; ++col) {
      const Vector2d middle =
          scan.PhotoFromPixel(corner + Vector2d(col + 0.5, row + 0.5)) - fiducial.position_mm;
      if (!MayShow(fiducial, padding, pixel, middle)) continue;
      const float below = image->At(col, row);
      float sum = 0;
      for (int i = 0; i < kSamples; ++i) {
        const Vector2d offset = Sample(i);
        const Vector2d at =
            scan.PhotoFromPixel(corner + Vector2d(col, row) + offset) - fiducial.position_mm;
        const bool padded = dark && at.cwiseAbs().maxCoeff() < padding;
        const float around = padded ? PaddingTone(film, index, at) : below;
        const bool drawn = visible && !(condition == MarkCondition::kArmLost &&
                                        Lost(damage, CrossOf(drawing), at));
        float tone = drawn ? MarkTone(fiducial, drawing, at, film.mark_tone, around) : around;
        if (condition == MarkCondition::kScratched) tone = Scratched(damage, at, tone);
        if (condition == MarkCondition::kDusty) tone = Dusty(damage, at, tone);
        sum += tone;
      }
      image->At(col, row) = sum / kSamples;
    }
  });
}

// A square of the film in kFiner times as many pixels.
struct FinePatch {
  Eigen::Vector2i origin;  // pixels of the scan
  Image image;
};

// Empty if the image does not show the square. Beyond its border, the border pixels are repeated.
FinePatch Enlarged(const Image& image, const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
  FinePatch patch{from, {}};
  if (to.x() < 0 || to.y() < 0 || from.x() >= image.width || from.y() >= image.height) return patch;
  patch.image = Image(kFiner * (to.x() - from.x()), kFiner * (to.y() - from.y()));
  for (int row = 0; row < patch.image.height; ++row)
    for (int col = 0; col < patch.image.width; ++col)
      patch.image.At(col, row) = image.At(std::clamp(from.x() + col / kFiner, 0, image.width - 1),
                                          std::clamp(from.y() + row / kFiner, 0, image.height - 1));
  return patch;
}

// Averages the patch, without its outermost `margin` pixels, into the scan's pixels.
void PutBack(const FinePatch& patch, int margin, Image* image) {
  const int last_row =
      std::min(patch.image.height / kFiner - margin, image->height - patch.origin.y());
  const int last_col =
      std::min(patch.image.width / kFiner - margin, image->width - patch.origin.x());
  for (int row = std::max(margin, -patch.origin.y()); row < last_row; ++row)
    for (int col = std::max(margin, -patch.origin.x()); col < last_col; ++col) {
      float sum = 0;
      for (int i = 0; i < kFiner; ++i)
        for (int j = 0; j < kFiner; ++j) sum += patch.image.At(kFiner * col + j, kFiner * row + i);
      image->At(col + patch.origin.x(), row + patch.origin.y()) = sum / (kFiner * kFiner);
    }
}

// The same film on a scanner of finer pixels.
ScanGeometry Finer(const ScanGeometry& scan) {
  ScanSetup setup = scan.Setup();
  setup.width *= kFiner;
  setup.height *= kFiner;
  setup.pixel_size_mm /= kFiner;
  return ScanGeometry(setup);
}

}  // namespace

double MarkRadius(const MarkDrawing& drawing) {
  double radius = 0;
  for (const MarkElement& element : drawing.elements) radius = std::max(radius, Reach(element));
  return radius;
}

double MarkBrightness(const MarkDrawing& drawing, const Vector2d& at_mm) {
  const auto& elements = drawing.elements;
  const auto top =
      std::find_if(elements.rbegin(), elements.rend(),
                   [&](const MarkElement& element) { return InElement(element, at_mm); });
  return top == elements.rend() ? 0 : BrightnessOf(*top);
}

bool InSymbol(const MarkSymbol& symbol, const Vector2d& at_mm) {
  constexpr double kBarLength_mm = 1.0, kBarWidth_mm = 0.15, kDotDiameter_mm = 0.35;
  const Vector2d first = symbol.at_mm.value_or(kSymbolAt_mm);
  const Vector2d step = symbol.step_mm.value_or(kSymbolStep_mm);
  const Vector2d along = step.normalized();
  for (int i = 0; i < symbol.count; ++i) {
    const Vector2d d = at_mm - first - i * step;
    if (symbol.kind == SymbolKind::kDots) {
      if (d.norm() <= 0.5 * kDotDiameter_mm) return true;
      continue;
    }
    const double across = std::abs(along.x() * d.y() - along.y() * d.x());
    if (std::abs(along.dot(d)) <= 0.5 * kBarWidth_mm && across <= 0.5 * kBarLength_mm) return true;
  }
  return false;
}

void DrawFilm(const FilmFrame& film, const ScanGeometry& scan, double blur_px, Image* image,
              const Eigen::Vector2i& origin) {
  DrawRebate(film, scan, origin, image);
  const Image sharp = *image;
  Blur(blur_px, image);
  const ScanGeometry finer = Finer(scan);
  const int margin = static_cast<int>(std::ceil(4 * blur_px));
  for (size_t index = 0; index < film.camera.fiducials.size(); ++index) {
    const double reach = ReachOfMark(film, index) / scan.Setup().pixel_size_mm + 2 * margin + 2;
    const Vector2d centre =
        scan.PixelFromPhoto(film.camera.fiducials[index].position_mm) - origin.cast<double>();
    FinePatch patch = Enlarged(sharp, (centre.array() - reach).floor().cast<int>(),
                               (centre.array() + reach).ceil().cast<int>());
    if (patch.image.Empty()) continue;
    // Neighbouring marks, too.
    for (size_t mark = 0; mark < film.camera.fiducials.size(); ++mark)
      DrawMark(film, mark, finer, kFiner * (origin + patch.origin), &patch.image);
    Blur(kFiner * blur_px, &patch.image);
    PutBack(patch, margin, image);
  }
}

}  // namespace orient::simulation

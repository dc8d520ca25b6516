#include "interior/locators/lines_locator.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/raster/resample.h"
#include "interior/locators/line_segments.h"
#include "interior/locators/template_search.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kPixelsOverStroke = 2.5;
// Images of strokes this wide are enlarged by this factor; still thinner strokes show no profile.
constexpr double kLeastStroke_px = 0.6, kMostStroke_px = 1.67, kEnlarged = 2;
constexpr double kPerpendicular = 0.05;   // tolerance of the arms' angle of 90 degrees, rad
constexpr double kStraightEnough = 0.05;  // rad from the scan's axes: no rotation needed

// The window with the cross's arms along its rows and columns.
struct Turned {
  Image image;
  Matrix2d window_from_turned = Matrix2d::Identity();
  Vector2d window_centre = Vector2d::Zero(), centre = Vector2d::Zero();

  Vector2d ToWindow(const Vector2d& at) const {
    return window_centre + window_from_turned * (at - centre);
  }
};

// Angle of the arms to the rows as they lie in the scan, within +-45 degrees.
double ArmAngle(const CrossElement& cross, const Matrix2d& pixel_from_mm) {
  const Vector2d arm =
      pixel_from_mm * Vector2d(std::cos(cross.angle_rad), std::sin(cross.angle_rad));
  const double quarter = std::numbers::pi / 2;
  return std::remainder(std::atan2(arm.y(), arm.x()), quarter);
}

Turned TurnWindow(const Image& window, double angle) {
  Turned turned;
  turned.window_centre = 0.5 * Vector2d(window.width, window.height);
  turned.centre = turned.window_centre;
  if (std::abs(angle) < kStraightEnough) {
    turned.image = window;
    return turned;
  }
  turned.window_from_turned = Eigen::Rotation2Dd(angle).toRotationMatrix();
  const int side = static_cast<int>(std::ceil(std::hypot(window.width, window.height)));
  turned.image = Image(side, side, kNoData);
  turned.centre = Vector2d::Constant(0.5 * side);
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col)
      turned.image.At(col, row) =
          SampleBilinear(window, turned.ToWindow(Vector2d(col + 0.5, row + 0.5)));
  return turned;
}

Image Transposed(const Image& image) {
  Image result(image.height, image.width);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) result.At(row, col) = image.At(col, row);
  return result;
}

struct Crossing {
  Vector2d at = Vector2d::Zero();  // turned window
  int points = 0;
};

// Crossing of a nearly horizontal and a nearly vertical line (the latter transposed).
std::optional<Crossing> Cross(const LineSegment& across, const LineSegment& down) {
  if (std::abs(across.slope + down.slope) > kPerpendicular) return std::nullopt;
  // Quick test, as most pairs are far apart.
  if (std::abs(across.offset - down.middle) > down.reach + std::abs(across.slope) * across.reach)
    return std::nullopt;
  double x = down.offset, y = across.offset;
  for (int i = 0; i < 4; ++i) {  // slopes are small: converges at once
    y = across.At(x);
    x = down.At(y);
  }
  if (std::abs(x - across.middle) > across.reach || std::abs(y - down.middle) > down.reach)
    return std::nullopt;
  return Crossing{{x, y}, across.points + down.points};
}

std::vector<LineSegment> OfPolarity(const std::vector<LineSegment>& lines, bool bright) {
  std::vector<LineSegment> chosen;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(chosen),
               [bright](const LineSegment& line) { return line.bright == bright; });
  return chosen;
}

// Lines by their offset, so that not all of them need be asked whether they are near.
class LinesByOffset {
 public:
  explicit LinesByOffset(const std::vector<LineSegment>& lines) {
    for (size_t i = 0; i < lines.size(); ++i) {
      sorted_.emplace_back(lines[i].offset, i);
      most_ = std::max(most_, std::abs(lines[i].slope) * lines[i].reach);
    }
    std::sort(sorted_.begin(), sorted_.end());
  }

  // Indices, in order, of all lines that anywhere come as near as `distance` to `place`.
  std::vector<size_t> Near(double place, double distance) const {
    const double far = distance + most_;
    std::vector<size_t> near;
    for (auto next =
             std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(place - far, size_t{0}));
         next != sorted_.end() && next->first <= place + far; ++next)
      near.push_back(next->second);
    std::sort(near.begin(), near.end());
    return near;
  }

 private:
  std::vector<std::pair<double, size_t>> sorted_;
  double most_ = 0;  // largest deviation of a line from its offset
};

// Crossings of one polarity, those with the most points first, none twice.
std::vector<Crossing> Crossings(const std::vector<LineSegment>& all_across,
                                const std::vector<LineSegment>& all_down, bool bright,
                                double min_distance, size_t max_count) {
  const auto across = OfPolarity(all_across, bright), down = OfPolarity(all_down, bright);
  const LinesByOffset down_by_offset(down);
  std::vector<Crossing> all;
  for (const LineSegment& a : across)
    for (const size_t i : down_by_offset.Near(a.middle, a.reach))
      if (const auto crossing = Cross(a, down[i])) all.push_back(*crossing);
  std::stable_sort(all.begin(), all.end(),
                   [](const Crossing& a, const Crossing& b) { return a.points > b.points; });
  std::vector<Crossing> kept;
  for (const Crossing& crossing : all) {
    if (kept.size() >= max_count) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Crossing& other) {
      return (other.at - crossing.at).norm() < min_distance;
    });
    if (!known) kept.push_back(crossing);
  }
  return kept;
}

}  // namespace

const CrossElement* CrossOf(const MarkShape& shape) {
  const CrossElement* longest = nullptr;
  for (const MarkElement& element : shape.drawing.elements) {
    const auto* cross = std::get_if<CrossElement>(&element);
    if (cross != nullptr && (longest == nullptr || cross->length_mm > longest->length_mm))
      longest = cross;
  }
  return longest;
}

// The mark as drawn, rotated with the film.
struct LinesLocator::TurnedMark {
  SpotTemplate spot;
  Vector2d centre = Vector2d::Zero();  // the mark's, in the template
  Vector2d cross = Vector2d::Zero();   // the cross's, from the mark's centre
};

namespace {

// The mark whose cross lies at `cross_at`, in the rotation of the drawing that best fits the image
// within a pixel.
template <typename Turns>
MarkCandidate MarkAt(const SpotImage& image, const Turns& turns, const Vector2d& cross_at,
                     double sign) {
  constexpr double kMinValid = 0.7;
  MarkCandidate best;
  for (const auto& t : turns) {
    const Vector2d at = cross_at - t.cross;
    const Vector2d corner = (at - t.centre).array().round();
    for (int dr = -1; dr <= 1; ++dr)
      for (int dc = -1; dc <= 1; ++dc) {
        const double ncc = sign * image.Correlate(t.spot, static_cast<int>(corner.x()) + dc,
                                                  static_cast<int>(corner.y()) + dr, kMinValid);
        if (ncc > best.ncc) best = {at, ncc};
      }
  }
  return best;
}

}  // namespace

LinesLocator::LinesLocator() = default;
LinesLocator::~LinesLocator() = default;

const std::vector<LinesLocator::TurnedMark>& LinesLocator::TurnsOf(
    const MarkShape& shape, const Vector2d& cross_mm, const Matrix2d& window_from_mm,
    const std::vector<double>& turns_rad, double blur_px) const {
  const Matrix2d& m = window_from_mm;
  Key key{&shape, {m(0, 0), m(0, 1), m(1, 0), m(1, 1)}};
  key.second.insert(key.second.end(), turns_rad.begin(), turns_rad.end());
  const std::lock_guard lock(mutex_);
  const auto known = made_.find(key);
  if (known != made_.end()) return known->second;
  RenderOptions render;
  render.blur_sigma_px = blur_px;
  render.background_sigma_px = kBackgroundSigmaMm * std::sqrt(std::abs(m.determinant()));
  std::vector<TurnedMark> turns;
  for (const double turn : turns_rad) {
    const Matrix2d turned = Eigen::Rotation2Dd(turn).toRotationMatrix() * m;
    const MarkTemplate drawn = RenderMark(shape, turned, render);
    turns.push_back({SpotTemplate(drawn.values), drawn.centre, turned * cross_mm});
  }
  return made_.emplace(std::move(key), std::move(turns)).first->second;
}

MarkCandidates LinesLocator::Find(ScanWindows& scan, const MarkShape& shape,
                                  const MarkSearch& search) const {
  const CrossElement* cross = CrossOf(shape);
  const double pixel_mm = 1 / std::sqrt(std::abs(search.pixel_from_mm.determinant()));
  MarkCandidates result;
  result.searched_mm2 = search.window.width * pixel_mm * search.window.height * pixel_mm;
  result.coarse_pixel_mm = pixel_mm;
  if (cross == nullptr || search.window.width <= 0 || search.window.height <= 0) return result;
  const double stroke_px = cross->width_mm / pixel_mm;
  const bool thin =
      search.interpolate && stroke_px >= kLeastStroke_px && stroke_px < kMostStroke_px;
  const double reduction = thin ? 1 / kEnlarged : std::max(1.0, stroke_px / kPixelsOverStroke);
  const Matrix2d window_from_mm = search.pixel_from_mm / reduction;
  result.coarse_pixel_mm = reduction * pixel_mm;
  const double px_per_mm = 1 / result.coarse_pixel_mm;

  const int reach = static_cast<int>(std::ceil((MarkRadius(shape) + 0.5) / pixel_mm)) + 1;
  const ImageWindow& seen = scan.Read(Grow(search.window, reach), reduction);
  const Image flat = RemoveBackground(seen.image, kBackgroundSigmaMm * px_per_mm);
  const Turned turned = TurnWindow(flat, ArmAngle(*cross, window_from_mm));
  LineSearch lines;
  lines.length_px = cross->length_mm * px_per_mm;
  lines.gap_px = cross->gap_mm * px_per_mm;
  lines.width_px = cross->width_mm * px_per_mm;
  const auto across = FindLineSegments(turned.image, lines);
  const auto down = FindLineSegments(Transposed(turned.image), lines);

  const std::vector<TurnedMark>& turns =
      TurnsOf(shape, cross->at_mm, window_from_mm, search.turns_rad,
              RenderOptions().blur_sigma_px / std::min(reduction, 1.0));
  const SpotImage spots(flat);
  const auto found = [&](bool bright) {
    // A cross drawn darker than its surroundings is dark on a positive.
    const bool bright_lines = bright == (cross->brightness > 0);
    // More than requested, as the final order is that of the correlation.
    const size_t looked_at = 3 * static_cast<size_t>(search.max_count);
    std::vector<MarkCandidate> candidates;
    for (const Crossing& crossing :
         Crossings(across, down, bright_lines, 2 * lines.width_px + 2, looked_at)) {
      const MarkCandidate mark =
          MarkAt(spots, turns, turned.ToWindow(crossing.at), bright ? 1.0 : -1.0);
      if (mark.ncc >= search.min_ncc)
        candidates.push_back({seen.RasterFromImage(mark.pixel), mark.ncc});
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.ncc > b.ncc; });
    if (candidates.size() > static_cast<size_t>(search.max_count))
      candidates.resize(static_cast<size_t>(search.max_count));
    return candidates;
  };
  result.bright = found(true);
  result.dark = found(false);
  return result;
}

}  // namespace orient::interior

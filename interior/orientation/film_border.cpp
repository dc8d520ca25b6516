#include "interior/orientation/film_border.h"

#include <algorithm>
#include <numeric>

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kStepMm = 0.1;
constexpr double kStripWidthMm = 10;  // of rebate; beyond it is another frame or the scanner
constexpr double kFromFrameMm = 0.5;  // the frame's edge is blurred
constexpr double kMarkReachMm = 7;    // marks and their symbols
constexpr double kDark = 0.3;         // tones
constexpr double kStrokeEdge = 0.35;  // difference of tone across a stroke's edge
constexpr double kEdgeReachMm = 0.3;
constexpr double kMinOnScan = 0.3;  // of a cell
constexpr double kMinCells = 0.5;   // of a place

// Probabilities of each answer, given that the feature is there, and that it is not.
struct Odds {
  double yes_there, no_there, yes_elsewhere, no_elsewhere;
};

Odds OddsOf(BorderSign sign) {
  switch (sign) {
    case BorderSign::kText:
      return {0.90, 0.05, 0.02, 0.90};
    case BorderSign::kDark:  // shadow and water are dark as well
      return {0.95, 0.01, 0.10, 0.80};
    case BorderSign::kBright:  // what is exposed there may be dark as well
      break;
  }
  return {0.80, 0.15, 0.02, 0.95};
}

// A piece of a border place, across its whole width.
struct Cell {
  int pixels = 0, on_scan = 0, dark = 0, edges = 0, pairs = 0;

  bool Counts() const { return on_scan > kMinOnScan * pixels; }
  double Dark() const { return static_cast<double>(dark) / std::max(on_scan, 1); }
  double Edges() const { return static_cast<double>(edges) / std::max(pairs, 1); }
};

bool NearMark(const Vector2d& at, const std::vector<Vector2d>& marks_mm) {
  return std::any_of(marks_mm.begin(), marks_mm.end(),
                     [&](const Vector2d& mark) { return (mark - at).norm() < kMarkReachMm; });
}

// Edges are looked for along the place only: the film's own edge lies across it everywhere.
std::vector<Cell> CellsOf(const BorderPlace& place, const TonePicture& picture, double cell_mm,
                          const std::vector<Vector2d>& marks_mm) {
  const Vector2d size = place.high_mm - place.low_mm;
  const int axis = size.x() >= size.y() ? 0 : 1;
  const Vector2d ahead = kEdgeReachMm * Vector2d(axis == 0 ? 1 : 0, axis == 0 ? 0 : 1);
  std::vector<Cell> cells(static_cast<size_t>(std::max(1.0, std::ceil(size[axis] / cell_mm))));
  for (int j = 0; j < picture.tone.height; ++j) {
    for (int i = 0; i < picture.tone.width; ++i) {
      const Vector2d at = picture.low_mm + picture.step_mm * Vector2d(i + 0.5, j + 0.5);
      const auto k = static_cast<size_t>((at - place.low_mm)[axis] / cell_mm);
      Cell& cell = cells[std::min(k, cells.size() - 1)];
      ++cell.pixels;
      const float tone = picture.tone.At(i, j);
      if (std::isnan(tone) || NearMark(at, marks_mm)) continue;
      ++cell.on_scan;
      if (tone < kDark) ++cell.dark;
      const float next = picture.At(at + ahead);
      if (std::isnan(next)) continue;
      ++cell.pairs;
      if (std::abs(next - tone) > kStrokeEdge) ++cell.edges;
    }
  }
  return cells;
}

// Share of the cells that a condition holds for.
template <typename Condition>
double Share(const std::vector<Cell>& cells, Condition condition) {
  const auto n = std::count_if(cells.begin(), cells.end(), condition);
  return static_cast<double>(n) / static_cast<double>(cells.size());
}

SignSeen LooksWritten(const std::vector<Cell>& cells) {
  constexpr double kMinEdges = 0.02, kFewEdges = 0.005, kMostlyDark = 0.5;
  const auto written = [](const Cell& c) {
    return c.Dark() > kMostlyDark && c.Edges() > kMinEdges;
  };
  const auto blank = [](const Cell& c) { return c.Dark() > kMostlyDark && c.Edges() < kFewEdges; };
  const double text = Share(cells, written), nothing = Share(cells, blank);
  const double count = text * static_cast<double>(cells.size());
  if (text > 0.12 && count > 1.5 && text + nothing > 0.7) return SignSeen::kYes;
  if (nothing > 0.85 && count < 1.5) return SignSeen::kNo;
  return SignSeen::kUnclear;
}

SignSeen LooksDark(const std::vector<Cell>& cells, double dark_yes, double dark_no) {
  double dark = 0;
  for (const Cell& cell : cells) dark += cell.Dark() / static_cast<double>(cells.size());
  if (dark > dark_yes) return SignSeen::kYes;
  return dark < dark_no ? SignSeen::kNo : SignSeen::kUnclear;
}

SignSeen Not(SignSeen seen) {
  if (seen == SignSeen::kUnclear) return seen;
  return seen == SignSeen::kYes ? SignSeen::kNo : SignSeen::kYes;
}

}  // namespace

SignSeen LookFor(BorderSign sign, const BorderPlace& place, const Raster& scan,
                 const Affine2d& pixel_from_photo, const FilmTone& tone,
                 const std::vector<Vector2d>& marks_mm) {
  constexpr double kMostCells = 12, kShortestCell = 1.5, kLongestCell = 4;
  const double length = (place.high_mm - place.low_mm).maxCoeff();
  const double cell_mm = std::clamp(length / kMostCells, kShortestCell, kLongestCell);
  const TonePicture picture =
      ReadTones(scan, pixel_from_photo, tone, place.low_mm, place.high_mm, kStepMm);
  std::vector<Cell> cells = CellsOf(place, picture, cell_mm, marks_mm);
  const double all = static_cast<double>(cells.size());
  std::erase_if(cells, [](const Cell& cell) { return !cell.Counts(); });
  if (cells.empty() || static_cast<double>(cells.size()) < kMinCells * all)
    return SignSeen::kUnclear;
  if (sign == BorderSign::kText) return LooksWritten(cells);
  if (sign == BorderSign::kDark) return LooksDark(cells, 0.9, 0.5);
  return Not(LooksDark(cells, 0.95, 0.4));
}

std::vector<BorderFeature> BorderFeatures(const CameraFile& camera) {
  std::vector<BorderFeature> features = camera.border;
  if (!camera.data_strip) return features;
  const Vector2d half = 0.5 * camera.camera.frame_mm, centre = camera.camera.frame_centre_mm;
  const bool upright =
      *camera.data_strip == FrameSide::kLeft || *camera.data_strip == FrameSide::kRight;
  const bool low =
      *camera.data_strip == FrameSide::kLeft || *camera.data_strip == FrameSide::kBottom;
  const int axis = upright ? 0 : 1;
  BorderFeature strip{BorderSign::kText, centre - half, centre + half};
  if (low) {
    strip.to_mm[axis] = strip.from_mm[axis] - kFromFrameMm;
    strip.from_mm[axis] -= kStripWidthMm;
  } else {
    strip.from_mm[axis] = strip.to_mm[axis] + kFromFrameMm;
    strip.to_mm[axis] += kStripWidthMm;
  }
  features.push_back(strip);
  return features;
}

std::vector<double> NatsOfFeature(BorderSign sign, const std::vector<SignSeen>& seen,
                                  const std::vector<size_t>& places) {
  const Odds odds = OddsOf(sign);
  // An answer is rated against the case that the feature is not at this place, as the product of
  // all "elsewhere" terms is the same in every scan orientation.
  const auto ratio = [&](SignSeen answer) {
    if (answer == SignSeen::kUnclear) return 0.0;
    return answer == SignSeen::kYes ? std::log(odds.yes_there / odds.yes_elsewhere)
                                    : std::log(odds.no_there / odds.no_elsewhere);
  };
  std::vector<double> nats;
  nats.reserve(places.size());
  for (const size_t place : places) nats.push_back(ratio(seen.at(place)));
  return nats;
}

}  // namespace orient::interior

#include "interior/marks/symbols.h"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <numeric>

#include "core/geometry/principal_axes.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kReachMm = 7.5;  // 6 mm to the symbol, its own size, and what is beside it
constexpr double kStepMm = 0.04;  // of the grid; a stroke of a symbol is 0.1 mm or wider

// A stroke is a third as bright as the mark's own, or brighter; blur makes thin ones fainter.
constexpr double kFaintest = 0.3, kNatsPerTone = 10.0;
constexpr double kBrightSurroundings = 0.35;  // exposed film, where nothing can be said
constexpr double kElongated = 1.6, kRound = 1.4;

// The place of an element of a row, with the directions along the row and across it.
struct RowFrame {
  const MarkSurroundings& around;
  Matrix2d turn;
  Vector2d first, step, across;

  double Tone(double element, double along_mm, double across_mm) const {
    const Vector2d at = first + element * step + along_mm * step.normalized() + across_mm * across;
    return around.picture.At(turn * at);
  }
};

double MeanTone(const RowFrame& row, double element, double along_mm, double across_mm,
                SymbolKind kind) {
  const double half = kind == SymbolKind::kLines ? 0.2 : 0.06;
  double sum = 0;
  for (const double u : {-1.0, -0.5, 0.0, 0.5, 1.0})
    for (const double t : {-0.03, 0.0, 0.03})
      sum += row.Tone(element, along_mm + t, across_mm + half * u);
  return sum / 15;
}

double Clip(double nats) { return std::clamp(nats, -kMostSymbolNats, kMostSymbolNats); }

// Nats for the presence of something at an element's place; 0 if its sides are bright.
double NatsOfElement(const RowFrame& row, double element, double along, double across,
                     SymbolKind kind) {
  const double before = MeanTone(row, element - 0.5, along, across, kind);
  const double after = MeanTone(row, element + 0.5, along, across, kind);
  const double here = MeanTone(row, element, along, across, kind);
  if (std::isnan(before + after + here)) return 0;
  if (std::max(std::abs(before), std::abs(after)) > kBrightSurroundings) return 0;
  return Clip(kNatsPerTone * (here - 0.5 * (before + after) - kFaintest));
}

// The weakest element decides for the row: one line more or less is another mark's symbol.
double NatsOfRow(const RowFrame& row, const MarkSymbol& symbol, double along, double across) {
  double nats = -NatsOfElement(row, symbol.count, along, across, symbol.kind);
  for (int i = 0; i < symbol.count; ++i)
    nats = std::min(nats, NatsOfElement(row, i, along, across, symbol.kind));
  return nats;
}

// How far an element stays brighter than half its tone, in steps of `direction` from its centre.
template <typename ToneAt>
double Extent(ToneAt tone_at, double most_mm) {
  const double half = 0.5 * tone_at(0.0);
  double extent = kStepMm;
  for (const double sign : {-1.0, 1.0})
    for (double d = kStepMm; d < most_mm && tone_at(sign * d) > half; d += kStepMm)
      extent += kStepMm;
  return extent;
}

bool LooksLike(SymbolKind kind, double long_side, double short_side) {
  const double ratio = long_side / short_side;
  return kind == SymbolKind::kLines ? ratio > kRound : ratio < kElongated;
}

bool ElementsLookLike(const RowFrame& row, const MarkSymbol& symbol, double along, double across) {
  double a = 0, b = 0;
  for (int i = 0; i < symbol.count; ++i) {
    a += Extent([&](double d) { return row.Tone(i, along + d, across); }, 0.5 * row.step.norm());
    b += Extent([&](double d) { return row.Tone(i, along, across + d); }, 1.2);
  }
  return LooksLike(symbol.kind, std::max(a, b), std::min(a, b));
}

// A connected bright patch beside the mark.
struct Patch {
  Vector2d centre = Vector2d::Zero();  // mm
  double area = 0;                     // mm^2
  double long_mm = 0, short_mm = 0;    // sides of the rectangle with the same moments
  Vector2d axis = Vector2d::UnitX();   // of the long side
  SymbolKind kind = SymbolKind::kLines;
  bool cut = false;    // touches the picture's edge
  bool alone = false;  // on dark film
};

class PatchFinder {
 public:
  explicit PatchFinder(const MarkSurroundings& around)
      : picture_(around.picture), tone_(around.picture.tone), radius_(around.mark_radius_mm + 0.1) {
    seen_.assign(tone_.values.size(), false);
  }

  std::vector<Patch> Find() {
    std::vector<Patch> patches;
    for (int j = 0; j < tone_.height; ++j)
      for (int i = 0; i < tone_.width; ++i)
        if (IsBright(i, j)) patches.push_back(Grow(i, j));
    return patches;
  }

 private:
  Vector2d Place(int i, int j) const {
    return picture_.low_mm + picture_.step_mm * Vector2d(i + 0.5, j + 0.5);
  }

  bool IsBright(int i, int j) const {
    constexpr float kThreshold = 0.45f;
    const size_t index = static_cast<size_t>(j) * static_cast<size_t>(tone_.width) + i;
    return !seen_[index] && tone_.At(i, j) > kThreshold && Place(i, j).norm() > radius_;
  }

  Patch Grow(int i0, int j0) {
    Patch patch;
    std::vector<Vector2d> places;
    std::vector<std::pair<int, int>> open = {{i0, j0}};
    Mark(i0, j0);
    while (!open.empty()) {
      const auto [i, j] = open.back();
      open.pop_back();
      places.push_back(Place(i, j));
      for (int b = j - 1; b <= j + 1; ++b)
        for (int a = i - 1; a <= i + 1; ++a) {
          if (a < 0 || b < 0 || a >= tone_.width || b >= tone_.height ||
              std::isnan(tone_.At(a, b))) {
            patch.cut = true;
          } else if (IsBright(a, b)) {
            Mark(a, b);
            open.emplace_back(a, b);
          }
        }
    }
    Describe(places, &patch);
    patch.alone = IsAlone(places);
    return patch;
  }

  // Whether most pixels close to the patch are dark, unlike around a light spot of the picture.
  bool IsAlone(const std::vector<Vector2d>& places) const {
    constexpr double kAroundMm = 0.16;
    constexpr float kDark = 0.25f;
    Vector2d low = places.front(), high = places.front();
    for (const Vector2d& place : places) {
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
    int dark = 0, bright = -static_cast<int>(places.size());
    for (double y = low.y() - kAroundMm; y < high.y() + kAroundMm; y += picture_.step_mm)
      for (double x = low.x() - kAroundMm; x < high.x() + kAroundMm; x += picture_.step_mm)
        ++(picture_.At({x, y}) < kDark ? dark : bright);
    return dark > bright;
  }

  void Mark(int i, int j) {
    seen_[static_cast<size_t>(j) * static_cast<size_t>(tone_.width) + i] = true;
  }

  void Describe(const std::vector<Vector2d>& places, Patch* patch) const {
    const double cell = picture_.step_mm * picture_.step_mm;
    patch->area = cell * static_cast<double>(places.size());
    for (const Vector2d& place : places) patch->centre += place;
    patch->centre /= static_cast<double>(places.size());
    Matrix2d moments = cell / 12 * Matrix2d::Identity();
    for (const Vector2d& place : places)
      moments += (place - patch->centre) * (place - patch->centre).transpose() /
                 static_cast<double>(places.size());
    const PrincipalAxes axes = AxesOf(moments);
    patch->short_mm = std::sqrt(12 * axes.values[0]);
    patch->long_mm = std::sqrt(12 * axes.values[1]);
    patch->axis = axes.vectors.col(1);
    patch->kind =
        patch->long_mm > kElongated * patch->short_mm ? SymbolKind::kLines : SymbolKind::kDots;
  }

  const TonePicture& picture_;
  const Image& tone_;
  double radius_;
  std::vector<bool> seen_;
};

bool MayBeElement(const Patch& patch) {
  constexpr double kFarthest = 6.5, kLongest = 2.5, kThinnest = 0.06, kWidest = 0.8;
  return !patch.cut && patch.alone && patch.centre.norm() < kFarthest && patch.long_mm < kLongest &&
         patch.short_mm > kThinnest && patch.short_mm < kWidest;
}

bool AreAlike(const Patch& a, const Patch& b) {
  constexpr double kMostRatio = 1.7, kMostTurn = 0.3;
  if (a.kind != b.kind) return false;
  if (std::max(a.area, b.area) > kMostRatio * std::min(a.area, b.area)) return false;
  return a.kind == SymbolKind::kDots ||
         std::abs(a.axis.x() * b.axis.y() - a.axis.y() * b.axis.x()) < kMostTurn;
}

// Neighbours in a row: near each other, bars side by side.
bool MayFollow(const Patch& a, const Patch& b) {
  constexpr double kLongestStep = 1.5, kSideBySide = 0.6;
  const Vector2d step = b.centre - a.centre;
  if (!AreAlike(a, b) || step.norm() > kLongestStep) return false;
  return a.kind == SymbolKind::kDots || std::abs(a.axis.dot(step.normalized())) < kSideBySide;
}

using Row = std::vector<size_t>;  // indices of patches, in order

std::optional<size_t> Next(const std::vector<Patch>& patches, size_t last, const Vector2d& step) {
  constexpr double kTolerance = 0.25;  // of a step
  for (size_t i = 0; i < patches.size(); ++i)
    if (i != last && AreAlike(patches[i], patches[last]) &&
        (patches[i].centre - patches[last].centre - step).norm() < kTolerance * step.norm())
      return i;
  return std::nullopt;
}

// The row that begins with patches a and b, whatever lies before a.
Row RowFrom(const std::vector<Patch>& patches, size_t a, size_t b) {
  Row row = {a, b};
  while (row.size() <= patches.size()) {
    const Vector2d step = patches[row.back()].centre - patches[row[row.size() - 2]].centre;
    const auto next = Next(patches, row.back(), step);
    if (!next) break;
    row.push_back(*next);
  }
  return row;
}

// All rows that are no part of a longer one; a patch that is in none is a row by itself.
std::vector<Row> RowsOf(const std::vector<Patch>& patches) {
  std::vector<Row> rows;
  std::vector<bool> used(patches.size(), false);
  for (size_t a = 0; a < patches.size(); ++a) {
    for (size_t b = 0; b < patches.size(); ++b) {
      if (a == b || !MayFollow(patches[a], patches[b])) continue;
      // Skips a pair that does not begin a row, and the same row backwards.
      const Vector2d step = patches[b].centre - patches[a].centre;
      if (Next(patches, a, -step)) continue;
      const Row row = RowFrom(patches, a, b);
      if (row.back() < row.front()) continue;
      // May skip elements in between: the row with smaller steps then has them all.
      rows.push_back(row);
    }
  }
  std::sort(rows.begin(), rows.end(),
            [](const Row& a, const Row& b) { return a.size() > b.size(); });
  std::vector<Row> apart;
  for (const Row& row : rows) {
    const auto in_use = std::count_if(row.begin(), row.end(), [&](size_t i) { return used[i]; });
    if (in_use > 0) continue;
    for (const size_t i : row) used[i] = true;
    apart.push_back(row);
  }
  for (size_t i = 0; i < patches.size(); ++i)
    if (!used[i]) apart.push_back({i});
  return apart;
}

}  // namespace

MarkSurroundings SurroundingsOf(const Raster& scan, const MarkShape& shape,
                                const Matrix2d& pixel_from_mm, const Vector2d& pixel,
                                const FilmTone& tone) {
  const Vector2d reach = Vector2d::Constant(kReachMm);
  return {ReadTones(scan, {pixel_from_mm, pixel}, tone, -reach, reach, kStepMm), MarkRadius(shape)};
}

double NatsOfSymbol(const MarkSurroundings& around, const MarkSymbol& symbol,
                    const Matrix2d& turn) {
  const Vector2d step = symbol.step_mm.value();
  const Vector2d along = step.normalized();
  const RowFrame row{around, turn, symbol.at_mm.value(), step, Vector2d(-along.y(), along.x())};
  // The camera file's positions of symbols were measured with a ruler.
  constexpr double kMostAcross = 0.2, kMostAlong = 0.2;  // mm, steps
  double best = -kMostSymbolNats, best_a = 0, best_c = 0;
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      const double a = 0.5 * i * kMostAlong * step.norm(), c = 0.5 * j * kMostAcross;
      const double nats = NatsOfRow(row, symbol, a, c);
      if (nats > best) {
        best = nats;
        best_a = a;
        best_c = c;
      }
    }
  }
  if (best > 0 && !ElementsLookLike(row, symbol, best_a, best_c)) return -best;
  return best;
}

std::optional<SymbolRow> FindSymbolRow(const MarkSurroundings& around) {
  std::vector<Patch> patches = PatchFinder(around).Find();
  std::erase_if(patches, [](const Patch& patch) { return !MayBeElement(patch); });
  const std::vector<Row> rows = RowsOf(patches);
  if (rows.empty()) return std::nullopt;
  const auto longest = std::max_element(
      rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.size() < b.size(); });
  // Dust beside a row is unlike its elements; anything like them makes the count doubtful.
  for (const Row& row : rows)
    if (&row != &*longest && (row.size() > 1 || longest->size() == 1 ||
                              AreAlike(patches[row.front()], patches[longest->front()])))
      return std::nullopt;
  const Patch& first = patches[longest->front()];
  return SymbolRow{first.kind, static_cast<int>(longest->size()), first.centre,
                   patches[longest->back()].centre};
}

}  // namespace orient::interior

#include "interior/locators/line_segments.h"

#include <algorithm>
#include <cmath>

#include "core/matching/float_sums.h"

namespace orient::interior {
namespace {

using Plane = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr float kMinCoefficient = 0.4f;
constexpr double kMinShareOfPoints = 0.45;  // of a line's length that must be seen
constexpr double kNearLinePx = 1.5;
constexpr int kSlopes = 11;
constexpr int kPointStep = 2;

// A place on a line: top of the profile across it.
struct LinePoint {
  double x = 0, y = 0;
  float weight = 0;
};

// Running means along the rows; NaN where a pixel is.
Image MeanAlongRows(const Image& image, int length) {
  Image mean(image.width, image.height, kNoData);
  const int before = length / 2;
  for (int row = 0; row < image.height; ++row) {
    double sum = 0;
    int gaps = 0;
    const auto add = [&](int col, int sign) {
      const float v = image.At(col, row);
      if (std::isfinite(v))
        sum += sign * static_cast<double>(v);
      else
        gaps += sign;
    };
    for (int col = 0; col < image.width; ++col) {
      add(col, 1);
      if (col >= length) add(col - length, -1);
      const int centre = col - length + 1 + before;
      if (col >= length - 1 && gaps == 0) mean.At(centre, row) = static_cast<float>(sum / length);
    }
  }
  return mean;
}

Image Squared(const Image& image) {
  Image squares = image;
  for (float& v : squares.values) v *= v;
  return squares;
}

// Where the coefficient is the highest across the line, refined by a parabola through the mean
// profile: t = -g1 / (2 g2).
std::vector<LinePoint> PointsOnLines(const Image& coefficients, const Image& profile, float sign) {
  std::vector<LinePoint> points;
  for (int row = 2; row < coefficients.height - 2; ++row) {
    for (int col = 0; col < coefficients.width; col += kPointStep) {
      const float c = sign * coefficients.At(col, row);
      if (!(c >= kMinCoefficient)) continue;
      bool highest = true;
      for (const int step : {-2, -1, 1, 2})
        highest = highest && !(sign * coefficients.At(col, row + step) > c);
      if (!highest) continue;
      const double before = static_cast<double>(sign * profile.At(col, row - 1));
      const double after = static_cast<double>(sign * profile.At(col, row + 1));
      const double middle = static_cast<double>(sign * profile.At(col, row));
      const double g1 = 0.5 * (after - before), g2 = 0.5 * (before + after) - middle;
      double t = g2 < 0 ? -g1 / (2 * g2) : 0;
      if (!std::isfinite(t)) continue;
      t = std::clamp(t, -1.0, 1.0);
      points.push_back({col + 0.5, row + 0.5 + t, c});
    }
  }
  return points;
}

double SlopeOf(int index, double max_slope) {
  return max_slope * (2.0 * index / (kSlopes - 1) - 1);
}

// y = offset + slope (x - middle) by least squares through the points near the start; false where
// they are too few or too close together. `points` are sorted by y and lie within the line's reach.
bool FitLine(const std::vector<LinePoint>& points, int min_points, LineSegment* line) {
  for (int pass = 0; pass < 3; ++pass) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0;
    const double most = kNearLinePx + std::abs(line->slope) * line->reach;
    const auto above = [&](const LinePoint& p) { return p.y < line->offset - most; };
    auto next = std::partition_point(points.begin(), points.end(), above);
    for (; next != points.end() && next->y <= line->offset + most; ++next) {
      const LinePoint& p = *next;
      if (std::abs(p.y - line->At(p.x)) > kNearLinePx) continue;
      const double u = p.x - line->middle;
      ++n;
      x += u;
      y += p.y;
      xx += u * u;
      xy += u * p.y;
    }
    line->points = static_cast<int>(n);
    const double spread = xx - x * x / std::max(n, 1.0);
    if (n < min_points || spread < n) return false;
    line->slope = (xy - x * y / n) / spread;
    line->offset = (y - line->slope * x) / n;
  }
  return true;
}

// Lines of one band of columns, most points first.
std::vector<LineSegment> LinesOfBand(const std::vector<LinePoint>& points, double middle,
                                     double reach, int height, const LineSearch& search,
                                     int min_points) {
  // Hough: votes over the slope and the height at the band's middle.
  std::vector<int> votes(static_cast<size_t>(kSlopes) * static_cast<size_t>(height), 0);
  for (const LinePoint& p : points)
    for (int s = 0; s < kSlopes; ++s) {
      const double at = p.y - SlopeOf(s, search.max_slope) * (p.x - middle);
      if (at >= 0 && at < height)
        ++votes[static_cast<size_t>(s) * static_cast<size_t>(height) + static_cast<size_t>(at)];
    }
  struct Cell {
    int votes, slope, row;
  };
  std::vector<Cell> cells;
  for (int row = 0; row < height; ++row) {
    Cell best{0, 0, row};
    for (int s = 0; s < kSlopes; ++s) {
      const size_t k = static_cast<size_t>(s) * static_cast<size_t>(height);
      int sum = votes[k + static_cast<size_t>(row)];  // a line may lie between two cells
      if (row + 1 < height) sum += votes[k + static_cast<size_t>(row) + 1];
      if (sum > best.votes) best = {sum, s, row};
    }
    if (best.votes >= min_points) cells.push_back(best);
  }
  std::sort(cells.begin(), cells.end(),
            [](const Cell& a, const Cell& b) { return a.votes > b.votes; });
  std::vector<LineSegment> lines;
  for (const Cell& cell : cells) {
    if (lines.size() >= static_cast<size_t>(search.max_per_band)) break;
    LineSegment line;
    line.middle = middle;
    line.reach = reach;
    line.offset = cell.row + 1.0;
    line.slope = SlopeOf(cell.slope, search.max_slope);
    if (!FitLine(points, min_points, &line)) continue;
    constexpr double kSame = 2;
    const bool known = std::any_of(lines.begin(), lines.end(), [&](const LineSegment& other) {
      return std::abs(other.offset - line.offset) < kSame;
    });
    if (!known && std::abs(line.slope) <= 1.2 * search.max_slope) lines.push_back(line);
  }
  return lines;
}

}  // namespace

Image CorrelateLine(const Image& image, int length, int width) {
  const Image mean = MeanAlongRows(image, length), square = MeanAlongRows(Squared(image), length);
  Image result(image.width, image.height, kNoData);
  const int half = width / 2;
  const int side = half + 2;  // nearest row of the lower side; the upper one mirrors it
  const int reach = side + width - 1;
  const int line_rows = 2 * half + 1, side_rows = 2 * width;
  const double n = line_rows + side_rows;
  const double spread_of_template = std::sqrt(line_rows * static_cast<double>(side_rows)) / n;
  const auto precise = [](const Image& of) -> Plane {
    return Eigen::Map<const FloatPlane>(of.values.data(), of.height, of.width)
        .matrix()
        .cast<double>();
  };
  const Plane means = precise(mean), square_means = precise(square);
  Eigen::RowVectorXd line(image.width), sides(image.width), squares(image.width);
  for (int row = reach; row < image.height - reach; ++row) {
    line.setZero();
    sides.setZero();
    squares.setZero();
    for (int r = -reach; r <= reach; ++r) {
      const int away = std::abs(r);
      if (away > half && away < side) continue;
      (away <= half ? line : sides) += means.row(row + r);
      squares += square_means.row(row + r);
    }
    for (int col = 0; col < image.width; ++col) {
      const double all = (line[col] + sides[col]) / n, variance = squares[col] / n - all * all;
      if (!(variance > 1e-6 * squares[col] / n)) continue;
      const double difference = line[col] / line_rows - sides[col] / side_rows;
      result.Row(row)[col] =
          static_cast<float>(difference * spread_of_template / std::sqrt(variance));
    }
  }
  return result;
}

std::vector<LineSegment> FindLineSegments(const Image& image, const LineSearch& search) {
  const double drawn = search.length_px - search.gap_px;
  const int length = std::clamp(static_cast<int>(drawn / 4), 3, 15);
  const int width = std::max(1, static_cast<int>(std::lround(search.width_px)));
  if (image.width <= length || image.height <= 4 * width + 8) return {};
  const Image coefficients = CorrelateLine(image, length, width);
  const Image profile = MeanAlongRows(image, length);
  const int min_points = std::max(4, static_cast<int>(kMinShareOfPoints * drawn / kPointStep));
  const double reach = 0.5 * search.length_px;
  std::vector<LineSegment> found;
  for (const float sign : {1.0f, -1.0f}) {
    const auto points = PointsOnLines(coefficients, profile, sign);
    std::vector<std::vector<LinePoint>> bands(static_cast<size_t>(std::ceil(image.width / reach)) +
                                              1);
    for (const LinePoint& p : points) {  // a band reaches half a line to both sides
      const auto k = static_cast<size_t>(p.x / reach);
      bands[k].push_back(p);
      bands[k + 1].push_back(p);
    }
    for (size_t k = 0; k < bands.size(); ++k) {
      std::sort(bands[k].begin(), bands[k].end(),
                [](const LinePoint& a, const LinePoint& b) { return a.y < b.y; });
      for (LineSegment& line : LinesOfBand(bands[k], static_cast<double>(k) * reach, reach,
                                           image.height, search, min_points)) {
        line.bright = sign > 0;
        found.push_back(line);
      }
    }
  }
  return found;
}

}  // namespace orient::interior

#include "interior/cross_position.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kScannerBlurPx = 0.7;  // typical, a pixel's own area included
// Of the profiles, besides the stroke's own width; and another one: what that changes is what the
// picture around the stroke does to the result.
constexpr double kSmoothingPx = 1.2, kOtherSmoothingPx = 1.6;
constexpr double kShareOfDifference = 0.5;  // of its square, in the variance
// Where the sides of a stroke are seen, from its edge; how much of their effect is corrected, since
// edges of the picture lie a little off as well; and how far that may be wrong.
constexpr double kSideFromPx = 0.8, kSideWidthPx = 1.5, kSideShare = 0.85, kSideUnsure = 0.5;
constexpr double kClearOfCrossing = 2.0;  // sigmas of the smoothing
constexpr double kOutlierSigmas = 3.0;
constexpr double kLeastSeen = 0.5;  // of a stroke's profiles
constexpr int kPasses = 12;
constexpr double kConverged = 1e-3;  // px
constexpr int kFarthestLag = 6;

// One stroke of the cross as it lies in the scan. `steep`: rows and columns are exchanged, so that
// every stroke is y = offset + slope * x, with x and y from the cross's predicted centre.
struct Stroke {
  bool steep = false;
  double offset = 0, slope = 0;
  double from_px = 0, to_px = 0;  // along x: where the arms begin and end, both sides of the centre
  double smoothing_px = 1;        // along y
  double half_width_px = 0.5;     // along y
  double side_response = 0;       // g1 where one side is brighter by 1 than the other
};

// The top of one profile, from the line.
struct Profile {
  double g1 = 0, g2 = 0;
  double side_effect = 0;  // on g1, of the two sides' different brightness
  double weight = 1;
  bool seen = false;
};

// An image, or its transpose.
class Plane {
 public:
  Plane(const Image& image, bool transposed) : image_(image), transposed_(transposed) {}
  double At(int x, int y) const {
    if (transposed_) std::swap(x, y);
    if (x < 0 || y < 0 || x >= image_.width || y >= image_.height) return std::nan("");
    return static_cast<double>(image_.At(x, y));
  }

 private:
  const Image& image_;
  bool transposed_;
};

double NormalBelow(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// The smoothed slope at the middle of an opaque stroke whose two sides differ by 1: what lies
// beside the stroke is not seen through it.
double SideResponse(const Stroke& stroke) {
  constexpr double kStep = 0.1;
  double product = 0, squares = 0;
  for (double u = -3.5; u <= 3.5; u += kStep) {
    const double y = u * stroke.smoothing_px, weight = std::exp(-0.5 * u * u) * u;
    const double side = 0.5 * (NormalBelow((y - stroke.half_width_px) / kScannerBlurPx) -
                               NormalBelow((-y - stroke.half_width_px) / kScannerBlurPx));
    product += weight * side;
    squares += weight * u;
  }
  return product / squares / stroke.smoothing_px;
}

Stroke StrokeOf(const CrossElement& cross, double angle_rad, const Matrix2d& pixel_from_mm,
                double blur_px) {
  const Vector2d along = pixel_from_mm * Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  const Vector2d normal = Vector2d(-along.y(), along.x()).normalized();
  const Vector2d across = pixel_from_mm * Vector2d(-std::sin(angle_rad), std::cos(angle_rad));
  const double width_px = cross.width_mm * std::abs(across.dot(normal));
  Stroke stroke;
  stroke.steep = std::abs(along.y()) > std::abs(along.x());
  const Vector2d d = stroke.steep ? Vector2d(along.y(), along.x()) : along;
  stroke.slope = d.y() / d.x();
  const double per_mm = std::abs(d.x()), cosine = per_mm / d.norm();
  const double sigma = std::sqrt(width_px * width_px / 12 + blur_px * blur_px);
  stroke.smoothing_px = sigma / cosine;
  stroke.half_width_px = 0.5 * width_px / cosine;
  stroke.side_response = SideResponse(stroke);
  // The other stroke, as wide as this one, hides the crossing.
  const double clear_px = (0.5 * width_px + kClearOfCrossing * sigma) * cosine;
  stroke.from_px = std::max(0.5 * cross.gap_mm * per_mm + sigma, clear_px);
  stroke.to_px = 0.5 * cross.length_mm * per_mm - sigma;
  return stroke;
}

// By how much the two sides of a stroke differ in column x, the lower one less the upper one. NaN
// where a side is not seen.
double SideDifference(const Plane& plane, int x, double y, const Stroke& stroke) {
  const double near = stroke.half_width_px + kSideFromPx, far = near + kSideWidthPx;
  double below = 0, above = 0, belows = 0, aboves = 0;
  const int last = static_cast<int>(std::floor(y + far));
  for (int row = static_cast<int>(std::floor(y - far)); row <= last; ++row) {
    const double u = row + 0.5 - y;
    const double part = std::clamp(std::abs(u) + 0.5 - near, 0.0, 1.0) *
                        std::clamp(far + 0.5 - std::abs(u), 0.0, 1.0);
    if (part <= 0) continue;
    (u < 0 ? above : below) += part * plane.At(x, row);
    (u < 0 ? aboves : belows) += part;
  }
  return below / belows - above / aboves;
}

// Derivatives of the smoothed profile down column x at height y (corner convention).
Profile ProfileAt(const Plane& plane, int x, double y, const Stroke& stroke) {
  Profile profile;
  const double sigma = stroke.smoothing_px;
  profile.side_effect = stroke.side_response * SideDifference(plane, x, y, stroke);
  if (!std::isfinite(profile.side_effect)) return profile;
  const int first = static_cast<int>(std::floor(y - 3.5 * sigma));
  const int last = static_cast<int>(std::floor(y + 3.5 * sigma));
  double sum = 0, sum_u2 = 0, sum_u4 = 0, v0 = 0, v1 = 0, v2 = 0;
  for (int row = first; row <= last; ++row) {
    const double value = plane.At(x, row);
    if (!std::isfinite(value)) return profile;
    const double u = (row + 0.5 - y) / sigma, weight = std::exp(-0.5 * u * u);
    sum += weight;
    sum_u2 += weight * u * u;
    sum_u4 += weight * u * u * u * u;
    v0 += weight * value;
    v1 += weight * u * value;
    v2 += weight * u * u * value;
  }
  // The parabola fitted with Gaussian weights, which are even to 1e-4: value = g0 + g1 u + g2 u^2.
  profile.g1 = v1 / sum_u2 / sigma - kSideShare * profile.side_effect;
  profile.g2 = (v2 * sum - v0 * sum_u2) / (sum_u4 * sum - sum_u2 * sum_u2) / (sigma * sigma);
  profile.seen = true;
  return profile;
}

// A stroke narrower than two pixels or so is undersampled: its top moves with its place in the
// pixel, as the sine of it, by the amplitude given here. That of a scanner that is blurred after
// the pixels were averaged only, which is the most there is; optics that blur before leave less,
// how much less is not seen.
double AliasingOf(const Stroke& stroke) {
  constexpr int kMiddle = 20, kRows = 2 * kMiddle + 1, kSubcolumns = 8;
  constexpr double kLater = 0.6;  // px, blur after the averaging
  const double y = kMiddle + 0.25;
  Image profile(1, kRows, 0);
  for (int row = 0; row < kRows; ++row) {
    double covered = 0;
    for (int k = 0; k < kSubcolumns; ++k) {
      const double middle = y + stroke.slope * ((k + 0.5) / kSubcolumns - 0.5);
      const double from = std::max<double>(row, middle - stroke.half_width_px);
      const double to = std::min<double>(row + 1, middle + stroke.half_width_px);
      covered += std::max(0.0, to - from) / kSubcolumns;
    }
    for (int at = std::max(0, row - 3); at <= std::min(kRows - 1, row + 3); ++at)
      profile.At(0, at) += static_cast<float>(
          covered * std::exp(-0.5 * (at - row) * (at - row) / (kLater * kLater)));
  }
  const Profile top = ProfileAt(Plane(profile, false), 0, y, stroke);
  return top.seen && top.g2 < 0 ? -top.g1 / (2 * top.g2) : 0;
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// A stroke's line through the tops of its profiles.
class StrokeFit {
 public:
  StrokeFit(const Plane& plane, const Vector2d& centre, const Stroke& stroke)
      : plane_(plane), centre_(centre), line_(stroke) {
    for (int x = static_cast<int>(std::floor(centre.x() - stroke.to_px));
         x <= static_cast<int>(std::floor(centre.x() + stroke.to_px)); ++x)
      columns_.push_back(x);
  }

  bool Fit(double max_shift_px) {
    for (int pass = 0; pass < kPasses; ++pass) {
      TakeProfiles();
      if (!WithoutOutliers() || !Improve(max_shift_px)) return false;
      if (step_ < kConverged) return true;
    }
    return step_ < 0.05;
  }

  const Stroke& Line() const { return line_; }

  // Variance of the line's height at x (from the centre).
  double VarianceAt(double x) const {
    const Matrix2d inverse = normal_.inverse();
    Matrix2d spread = Matrix2d::Zero();
    for (int lag = 0; lag <= kFarthestLag; ++lag) spread += SpreadAtLag(lag);
    const Vector2d at(1, x);
    double variance = at.dot(inverse * spread * inverse * at);
    // The sides' effect is known to a part only, and the same part everywhere.
    Vector2d sides = Vector2d::Zero();
    for (size_t i = 0; i < profiles_.size(); ++i)
      if (use_[i]) sides += RowOf(i) * profiles_[i].weight * kSideUnsure * profiles_[i].side_effect;
    const double wrong = at.dot(inverse * sides);
    const double aliased = at.dot(inverse * Aliasing());
    variance += wrong * wrong + aliased * aliased;
    return variance * static_cast<double>(used_) / std::max(1.0, static_cast<double>(used_) - 2);
  }

 private:
  double FromCentre(size_t i) const { return columns_[i] + 0.5 - centre_.x(); }

  void TakeProfiles() {
    profiles_.assign(columns_.size(), {});
    for (size_t i = 0; i < columns_.size(); ++i) {
      const double x = FromCentre(i);
      if (std::abs(x) < line_.from_px || std::abs(x) > line_.to_px) continue;
      const double y = centre_.y() + line_.offset + line_.slope * x;
      profiles_[i] = ProfileAt(plane_, columns_[i], y, line_);
    }
  }

  // Grey value noise, robustly, decides how much less the profiles between unlike sides count.
  void Weigh(double noise) {
    for (Profile& profile : profiles_) {
      const double unsure = kSideUnsure * profile.side_effect / std::max(noise, 1e-9);
      profile.weight = 1 / std::sqrt(1 + unsure * unsure);
    }
  }

  Vector2d RowOf(size_t i) const {
    return 2 * profiles_[i].g2 * profiles_[i].weight * Vector2d(1, FromCentre(i));
  }

  // What a profile leaves at a line moved by `shift` and turned by `turn`, grey values per pixel.
  double Left(size_t i, const Vector2d& move) const {
    return profiles_[i].weight * profiles_[i].g1 + RowOf(i).dot(move);
  }

  bool Solve(const std::vector<bool>& used, Vector2d* move) {
    normal_.setZero();
    Vector2d right = Vector2d::Zero();
    used_ = 0;
    for (size_t i = 0; i < profiles_.size(); ++i) {
      if (!used[i]) continue;
      const Vector2d row = RowOf(i);
      normal_ += row * row.transpose();
      right -= row * profiles_[i].weight * profiles_[i].g1;
      ++used_;
    }
    const Eigen::LLT<Matrix2d> solver(normal_);
    if (solver.info() != Eigen::Success) return false;
    *move = solver.solve(right);
    return move->allFinite();
  }

  // Profiles with a stroke, without those that the others contradict.
  bool WithoutOutliers() {
    use_.assign(profiles_.size(), false);
    size_t seen = 0, possible = 0;
    for (size_t i = 0; i < profiles_.size(); ++i) {
      const double x = std::abs(FromCentre(i));
      if (x >= line_.from_px && x <= line_.to_px) ++possible;
      use_[i] = profiles_[i].seen && profiles_[i].g2 < 0;
      if (use_[i]) ++seen;
    }
    const auto least =
        static_cast<size_t>(std::max(6.0, kLeastSeen * static_cast<double>(possible)));
    for (int round = 0; round < 5; ++round) {
      if (seen < least || !Solve(use_, &move_)) return false;
      std::vector<double> sizes;
      for (size_t i = 0; i < profiles_.size(); ++i)
        if (use_[i]) sizes.push_back(std::abs(Left(i, move_)));
      const double noise = 1.4826 * Median(std::move(sizes));
      const double limit = kOutlierSigmas * noise;
      if (round == 0) Weigh(noise);
      size_t kept = 0;
      for (size_t i = 0; i < profiles_.size(); ++i) {
        use_[i] = profiles_[i].seen && profiles_[i].g2 < 0 && std::abs(Left(i, move_)) <= limit;
        if (use_[i]) ++kept;
      }
      if (kept == seen) break;
      seen = kept;
    }
    return seen >= least && Solve(use_, &move_);
  }

  bool Improve(double max_shift_px) {
    const double most = line_.smoothing_px;
    const double x = 0.5 * (line_.from_px + line_.to_px);
    step_ = std::max(std::abs(move_[0]), std::abs(move_[1] * x));
    if (step_ > most) move_ *= most / step_;
    line_.offset += move_[0];
    line_.slope += move_[1];
    return std::abs(line_.offset) <= max_shift_px && std::abs(line_.slope) < 1.5;
  }

  // What undersampling does to the line: it averages out where the stroke crosses rows of pixels.
  Vector2d Aliasing() const {
    const double amplitude = AliasingOf(line_);
    Vector2d sum = Vector2d::Zero();
    for (size_t i = 0; i < profiles_.size(); ++i) {
      if (!use_[i]) continue;
      const double y = centre_.y() + line_.offset + line_.slope * FromCentre(i);
      const Vector2d row = RowOf(i);
      sum += row * row[0] * amplitude * std::sin(2 * std::numbers::pi * y);
    }
    return sum;
  }

  Matrix2d SpreadAtLag(int lag) const {
    double products = 0, pairs = 0;
    Matrix2d rows = Matrix2d::Zero();
    for (size_t i = 0; i + static_cast<size_t>(lag) < profiles_.size(); ++i) {
      const size_t j = i + static_cast<size_t>(lag);
      if (!use_[i] || !use_[j]) continue;
      products += Left(i, move_) * Left(j, move_);
      ++pairs;
      const Vector2d a = RowOf(i), b = RowOf(j);
      rows += a * b.transpose() + b * a.transpose();
    }
    if (pairs < 1) return Matrix2d::Zero();
    const double taper = lag == 0 ? 0.5 : 1 - static_cast<double>(lag) / (kFarthestLag + 1);
    return taper * products / pairs * rows;
  }

  const Plane& plane_;
  Vector2d centre_;
  Stroke line_;
  std::vector<int> columns_;
  std::vector<Profile> profiles_;
  std::vector<bool> use_;
  Matrix2d normal_ = Matrix2d::Zero();
  Vector2d move_ = Vector2d::Zero();
  double step_ = 0;
  size_t used_ = 0;
};

// `dark`: the strokes are, and the window is turned into its negative.
ImageWindow ReadFlat(const Raster& scan, const Vector2d& centre, double reach_px,
                     double background_px, bool dark) {
  const int half = static_cast<int>(std::ceil(reach_px));
  const int col = static_cast<int>(std::floor(centre.x()));
  const int row = static_cast<int>(std::floor(centre.y()));
  ImageWindow seen = scan.ReadGrey({col - half, row - half, 2 * half + 1, 2 * half + 1});
  if (dark)
    for (float& value : seen.image.values) value = -value;
  seen.image = RemoveBackground(seen.image, background_px);
  return seen;
}

}  // namespace

namespace {

// The two strokes' crossing, from the mark's predicted centre at `middle`.
std::optional<MarkPosition> Crossing(const Image& image, const CrossElement& cross,
                                     const Matrix2d& pixel_from_mm, const Vector2d& middle,
                                     double max_shift_px, double blur_px) {
  const Vector2d centre = middle + pixel_from_mm * cross.at_mm;
  std::optional<StrokeFit> level, steep;
  const Plane plane(image, false), transposed(image, true);
  for (const double turn : {0.0, std::numbers::pi / 2}) {
    const Stroke stroke = StrokeOf(cross, cross.angle_rad + turn, pixel_from_mm, blur_px);
    auto& fit = stroke.steep ? steep : level;
    fit.emplace(stroke.steep ? transposed : plane,
                stroke.steep ? Vector2d(centre.y(), centre.x()) : centre, stroke);
    if (!fit->Fit(max_shift_px)) return std::nullopt;
  }
  if (!level || !steep) return std::nullopt;
  // y = a + b x and x = c + d y.
  const Stroke &across = level->Line(), &down = steep->Line();
  const Matrix2d lines = (Matrix2d() << -across.slope, 1, 1, -down.slope).finished();
  if (std::abs(lines.determinant()) < 0.1) return std::nullopt;
  const Matrix2d inverse = lines.inverse();
  const Vector2d shift = inverse * Vector2d(across.offset, down.offset);
  if (!(shift.norm() <= max_shift_px)) return std::nullopt;
  const Vector2d variances(level->VarianceAt(shift.x()), steep->VarianceAt(shift.y()));
  if (!(variances.minCoeff() > 0)) return std::nullopt;
  MarkPosition position;
  position.pixel = middle + shift;
  position.covariance = inverse * variances.asDiagonal() * inverse.transpose();
  return position;
}

}  // namespace

std::optional<MarkPosition> MeasureCross(const Raster& scan, const CrossElement& cross,
                                         const Matrix2d& pixel_from_mm, const Vector2d& start,
                                         Polarity polarity, double max_shift_px) {
  const double pixel_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  const double background_px = kBackgroundSigmaMm * pixel_per_mm;
  const double reach_px = 0.55 * cross.length_mm * pixel_per_mm + max_shift_px + background_px;
  const Vector2d cross_at = start + pixel_from_mm * cross.at_mm;
  const bool dark = (polarity == Polarity::kNegative) != (cross.brightness <= 0);
  const ImageWindow seen = ReadFlat(scan, cross_at, reach_px, background_px, dark);
  const auto measure = [&](const Vector2d& from, double blur_px) {
    return Crossing(seen.image, cross, pixel_from_mm, seen.ImageFromRaster(from), max_shift_px,
                    blur_px);
  };
  std::optional<MarkPosition> position = measure(start, kSmoothingPx);
  if (!position) return std::nullopt;
  const auto other = measure(start, kOtherSmoothingPx);
  if (!other) return std::nullopt;
  const Vector2d difference = other->pixel - position->pixel;
  position->covariance += kShareOfDifference * difference.cwiseAbs2().asDiagonal().toDenseMatrix();
  position->pixel = seen.RasterFromImage(position->pixel);
  return position;
}

}  // namespace orient

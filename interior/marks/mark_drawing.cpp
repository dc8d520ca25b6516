#include "interior/marks/mark_drawing.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>

#include "core/files/mark_painting.h"
#include "core/matching/correlation.h"
#include "core/raster/resample.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// The share of an element in a sample around a point whose signed distance from its outline,
// in sample sides, is `distance`: a straight outline, filtered with a triangle two sides wide.
double SmoothShare(double distance) {
  if (distance >= 1) return 0;
  if (distance <= -1) return 1;
  const double beyond = 1 - std::abs(distance);
  return distance > 0 ? 0.5 * beyond * beyond : 1 - 0.5 * beyond * beyond;
}

// A square of pixels with the mark's centre at `centre`.
struct PixelSquare {
  Matrix2d mm_from_pixel;
  Vector2d centre;
  int size = 0;

  Vector2d AtMm(const Vector2d& pixel) const { return mm_from_pixel * (pixel - centre); }
  // Largest distance of a point of a pixel from the pixel's middle.
  double HalfDiagonal() const {
    const Vector2d along = mm_from_pixel.col(0), down = mm_from_pixel.col(1);
    return 0.5 * std::max((along + down).norm(), (along - down).norm());
  }
};

// Divides a square into blocks, and these into smaller ones, until no outline passes through them:
// only near the outlines this comes down to single pixels, and only with the elements near there.
class Blocks {
 public:
  using Elements = std::span<const MarkElement* const>;

  // The outlines are looked at `grown_mm` outside the elements; one within `reach_mm` of a block
  // passes through it.
  Blocks(const MarkDrawing& drawing, const PixelSquare& square, double grown_mm, double reach_mm)
      : square_(square),
        half_diagonal_(square.HalfDiagonal()),
        grown_mm_(grown_mm),
        reach_mm_(reach_mm) {
    for (const MarkElement& element : drawing.elements) near_.push_back(&element);
  }

  // fill(col, row, side, covering) for a block that the element `covering` covers as a whole, or
  // none (null); it may reach beyond the square. pixel(col, row, covering, elements) for a pixel
  // through which these elements' outlines may pass. Elements come in the order of painting,
  // `covering` lies beneath them.
  template <typename Fill, typename Pixel>
  void Visit(const Fill& fill, const Pixel& pixel) {
    int side = 1;
    while (side < square_.size) side *= 2;
    Divide({0, 0, side, 0, nullptr}, fill, pixel);
  }

 private:
  struct Block {
    int col, row, side;
    size_t first;  // index of the first element near it; these end the list
    const MarkElement* covering;
  };

  template <typename Fill, typename Pixel>
  void Divide(Block block, const Fill& fill, const Pixel& pixel) {
    const int col = block.col, row = block.row, side = block.side;
    const size_t before = block.first;
    if (col >= square_.size || row >= square_.size) return;
    const Vector2d middle = square_.AtMm(Vector2d(col + 0.5 * side, row + 0.5 * side));
    const double radius = side * half_diagonal_ + reach_mm_;
    block.first = near_.size();
    for (size_t i = before; i < block.first; ++i) {
      const MarkElement* element = near_[i];
      const double distance = SignedDistance(*element, middle) - grown_mm_;
      if (distance > radius) continue;
      if (distance < -radius) {
        block.covering = element;
        near_.resize(block.first);
      } else {
        near_.push_back(element);
      }
    }
    if (near_.size() == block.first) {
      fill(col, row, side, block.covering);
    } else if (side == 1) {
      pixel(col, row, block.covering, Elements(near_).subspan(block.first));
    } else {
      block.side = side / 2;
      for (const int down : {0, block.side})
        for (const int right : {0, block.side}) {
          block.col = col + right;
          block.row = row + down;
          Divide(block, fill, pixel);
        }
    }
    near_.resize(block.first);
  }

  PixelSquare square_;
  double half_diagonal_, grown_mm_, reach_mm_;
  std::vector<const MarkElement*> near_;
};

// Places of the samples in a pixel.
std::vector<Vector2d> SamplePlaces(const RenderOptions& options) {
  const double n = options.supersampling;
  std::vector<Vector2d> places;
  for (int j = 0; j < options.supersampling; ++j)
    for (int i = 0; i < options.supersampling; ++i)
      places.emplace_back((i + 0.5) / n, (j + 0.5) / n);
  return places;
}

float Mean(const std::vector<float>& values) {
  const auto count = static_cast<Eigen::Index>(values.size());
  return Eigen::Map<const Eigen::ArrayXf>(values.data(), count).mean();
}

// NaN outside the picture.
Image PictureMeans(const MarkShape& shape, const PixelSquare& square,
                   const RenderOptions& options) {
  const MarkImage& source = *shape.drawing.image;
  const std::vector<Vector2d> places = SamplePlaces(options);
  std::vector<float> samples(places.size());
  Image image(square.size, square.size);
  for (int row = 0; row < square.size; ++row) {
    for (int col = 0; col < square.size; ++col) {
      for (size_t i = 0; i < places.size(); ++i) {
        const Vector2d mm = square.AtMm(Vector2d(col, row) + places[i]);
        samples[i] = SampleBilinear(
            *shape.picture, source.centre_px + Vector2d(mm.x(), -mm.y()) / source.pixel_size_mm);
      }
      image.At(col, row) = Mean(samples);
    }
  }
  return image;
}

// Paints the element over the values at the points, its outline as smooth as samples `side_mm`
// apart need.
void PaintSmoothly(const MarkElement& element, const std::vector<Vector2d>& points_mm,
                   double side_mm, std::vector<float>* values) {
  const double brightness = BrightnessOf(element);
  for (size_t i = 0; i < points_mm.size(); ++i) {
    const auto beneath = static_cast<double>((*values)[i]);
    const double share = SmoothShare(SignedDistance(element, points_mm[i]) / side_mm);
    (*values)[i] = static_cast<float>(beneath + share * (brightness - beneath));
  }
}

Image DrawingMeans(const MarkDrawing& drawing, const PixelSquare& square,
                   const RenderOptions& options) {
  std::vector<Vector2d> places_mm = SamplePlaces(options);
  for (Vector2d& place : places_mm) place = square.mm_from_pixel * place;
  const double side_mm =
      std::sqrt(std::abs(square.mm_from_pixel.determinant())) / options.supersampling;
  std::vector<Vector2d> points(places_mm.size());
  std::vector<float> samples(places_mm.size());
  Image image(square.size, square.size);
  const auto brightness = [](const MarkElement* element) {
    return element ? static_cast<float>(BrightnessOf(*element)) : 0.0f;
  };
  const auto fill = [&](int col, int row, int side, const MarkElement* covering) {
    const int stop = std::min(col + side, square.size);
    for (int r = row; r < std::min(row + side, square.size); ++r)
      std::fill(image.Row(r) + col, image.Row(r) + stop, brightness(covering));
  };
  const auto pixel = [&](int col, int row, const MarkElement* covering, Blocks::Elements elements) {
    const Vector2d corner = square.AtMm(Vector2d(col, row));
    for (size_t i = 0; i < points.size(); ++i) points[i] = corner + places_mm[i];
    std::fill(samples.begin(), samples.end(), brightness(covering));
    for (const MarkElement* element : elements) {
      if (options.smooth_outlines)
        PaintSmoothly(*element, points, side_mm, &samples);
      else
        Paint(*element, points, &samples);
    }
    image.At(col, row) = Mean(samples);
  };
  Blocks(drawing, square, 0, options.smooth_outlines ? side_mm : 0).Visit(fill, pixel);
  return image;
}

void CheckShape(const MarkShape& shape, const Matrix2d& pixel_from_mm) {
  if (std::abs(pixel_from_mm.determinant()) < 1e-12)
    throw std::invalid_argument("RenderMark: pixel_from_mm is singular");
  if (shape.drawing.image && !shape.picture)
    throw std::invalid_argument("RenderMark: the mark's picture was not handed in");
  if (!shape.picture && shape.drawing.elements.empty())
    throw std::invalid_argument("RenderMark: the drawing has no elements");
}

// Stroke width of each element, mm; those of a picture are unknown.
std::vector<double> StrokesOf(const MarkShape& shape) {
  if (shape.picture || shape.drawing.elements.empty()) return {0.1};
  std::vector<double> strokes;
  for (const MarkElement& e : shape.drawing.elements) strokes.push_back(Thickness(e));
  return strokes;
}

}  // namespace

double MarkRadius(const MarkShape& shape) {
  double radius = 0;
  for (const MarkElement& e : shape.drawing.elements) radius = std::max(radius, Reach(e));
  if (shape.picture)
    radius = 0.5 * shape.drawing.image->pixel_size_mm *
             std::min(shape.picture->width, shape.picture->height);
  return radius;
}

double ThinnestStroke(const MarkShape& shape) { return std::ranges::min(StrokesOf(shape)); }

double WidestStroke(const MarkShape& shape) { return std::ranges::max(StrokesOf(shape)); }

double StrokeDistance(const MarkDrawing& drawing, const Vector2d& point_mm) {
  double distance = std::numeric_limits<double>::infinity();
  for (const MarkElement& element : drawing.elements)
    distance = std::min(distance, StrokeDistance(element, point_mm));
  return distance;
}

MarkTemplate RenderMark(const MarkShape& shape, const Matrix2d& pixel_from_mm,
                        const RenderOptions& options) {
  CheckShape(shape, pixel_from_mm);
  const Matrix2d mm_from_pixel = pixel_from_mm.inverse();
  const double pixels_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  const double reach_mm = MarkRadius(shape) + (shape.picture ? 0.0 : options.margin_mm);
  const int half = static_cast<int>(std::ceil(reach_mm * pixels_per_mm * 1.03 + 0.5));
  const int pad =
      static_cast<int>(std::ceil(3 * std::max(options.blur_sigma_px, options.background_sigma_px)));
  const int size = 2 * (half + pad) + 1;
  const Vector2d centre = Vector2d::Constant(half + pad + 0.5) + options.offset_px;
  const PixelSquare square{mm_from_pixel, centre, size};
  Image full = shape.picture ? PictureMeans(shape, square, options)
                             : DrawingMeans(shape.drawing, square, options);
  if (options.blur_sigma_px > 0) full = GaussianBlur(full, options.blur_sigma_px);
  if (options.background_sigma_px > 0) full = RemoveBackground(full, options.background_sigma_px);

  MarkTemplate result;
  result.values = Image(2 * half + 1, 2 * half + 1, kNoData);
  result.centre = Vector2d::Constant(half + 0.5) + options.offset_px;
  const std::vector<bool> part =
      shape.picture || options.whole_square
          ? std::vector<bool>(result.values.values.size(), true)
          : NearStrokes(shape.drawing, mm_from_pixel, half, options.margin_mm);
  for (int row = 0; row < result.values.height; ++row)
    for (int col = 0; col < result.values.width; ++col)
      if (part[static_cast<size_t>(row * result.values.width + col)])
        result.values.At(col, row) = full.At(col + pad, row + pad);
  return result;
}

namespace {

bool IsOpen(const MarkElement& element) {
  const auto* polygon = std::get_if<PolygonElement>(&element);
  return polygon != nullptr && polygon->open;
}

// Leaves out pixels near continuations of outlines that are not drawn.
void LeaveOutBeyond(const std::vector<MarkElement>& elements, const PixelSquare& square,
                    double margin_mm, std::vector<bool>* near) {
  for (size_t i = 0; i < near->size(); ++i) {
    const size_t side = static_cast<size_t>(square.size), row = i / side, col = i % side;
    const Vector2d middle =
        square.AtMm(Vector2d(static_cast<double>(col) + 0.5, static_cast<double>(row) + 0.5));
    (*near)[i] = (*near)[i] && std::any_of(elements.begin(), elements.end(), [&](const auto& e) {
                   return DistanceFromPart(e, middle) <= margin_mm;
                 });
  }
}

}  // namespace

std::vector<bool> NearStrokes(const MarkDrawing& drawing, const Matrix2d& mm_from_pixel, int half,
                              double margin_mm) {
  const PixelSquare square{mm_from_pixel, Vector2d::Constant(half + 0.5), 2 * half + 1};
  std::vector<bool> near(static_cast<size_t>(square.size * square.size));
  const auto fill = [&](int col, int row, int side, const MarkElement* covering) {
    const int stop = std::min(col + side, square.size);
    for (int r = row; r < std::min(row + side, square.size); ++r) {
      const auto line = near.begin() + r * square.size;
      std::fill(line + col, line + stop, covering != nullptr);
    }
  };
  const auto pixel = [&](int col, int row, const MarkElement* covering, Blocks::Elements elements) {
    const Vector2d middle = square.AtMm(Vector2d(col + 0.5, row + 0.5));
    near[static_cast<size_t>(row * square.size + col)] =
        covering != nullptr || std::any_of(elements.begin(), elements.end(), [&](const auto* e) {
          return SignedDistance(*e, middle) <= margin_mm;
        });
  };
  Blocks(drawing, square, margin_mm, 0).Visit(fill, pixel);
  if (std::any_of(drawing.elements.begin(), drawing.elements.end(), IsOpen))
    LeaveOutBeyond(drawing.elements, square, margin_mm, &near);
  return near;
}

namespace {

// 24 px across the mark show every element; smooth outlines, also those that miss the samples.
// A margin beyond the radius keeps the same pixels valid.
MarkTemplate SmallPicture(const MarkShape& shape, double radius_mm, const Matrix2d& turn) {
  const Matrix2d upright = Eigen::DiagonalMatrix<double, 2>(1, -1) * (12.0 / radius_mm);
  RenderOptions options{0.7, 3 * radius_mm - MarkRadius(shape), 4};
  options.smooth_outlines = true;
  return RenderMark(shape, upright * turn.transpose(), options);
}

// The same, from the mark's upright picture; for quarter turns and mirroring the pixels only change
// places.
MarkTemplate TurnedPicture(const MarkShape& shape, const MarkTemplate& upright, double radius_mm,
                           const Matrix2d& turn) {
  const Eigen::Matrix2i quarters = turn.array().round().cast<int>();
  if (!(turn - quarters.cast<double>()).isZero(1e-9)) return SmallPicture(shape, radius_mm, turn);
  const int middle = upright.values.width / 2;
  MarkTemplate turned = upright;
  for (int row = 0; row < upright.values.height; ++row)
    for (int col = 0; col < upright.values.width; ++col) {
      // Rows go down and y up.
      const Eigen::Vector2i from = quarters * Eigen::Vector2i(col - middle, middle - row);
      turned.values.At(col, row) = upright.values.At(from.x() + middle, middle - from.y());
    }
  return turned;
}

bool AreAlike(const MarkTemplate& a, const MarkTemplate& b) {
  if (a.values.width != b.values.width) return false;  // pictures of different sizes
  constexpr double kSame = 0.9;
  return CorrelationCoefficient(a.values, b.values, 0.5) > kSame;
}

}  // namespace

bool LooksSame(const MarkShape& shape, const Matrix2d& turn) {
  return LooksSame(shape, shape, turn);
}

bool LooksSame(const MarkShape& shape, const MarkShape& turned, const Matrix2d& turn) {
  const double radius = std::max(MarkRadius(shape), MarkRadius(turned));
  return AreAlike(SmallPicture(shape, radius, Matrix2d::Identity()),
                  SmallPicture(turned, radius, turn));
}

bool IsSymmetric(const MarkShape& shape, const Matrix2d& turn) {
  if (shape.picture) return false;
  const double radius = MarkRadius(shape);
  const MarkTemplate picture = SmallPicture(shape, radius, Matrix2d::Identity());
  const Image &upright = picture.values,
              turned = TurnedPicture(shape, picture, radius, turn).values;
  constexpr float kRounding = 1e-3f;
  for (size_t i = 0; i < upright.values.size(); ++i) {
    const float a = upright.values[i], b = turned.values[i];
    if (std::isfinite(a) != std::isfinite(b)) return false;
    if (std::abs(a - b) > kRounding) return false;  // false where both are no data
  }
  return true;
}

bool MarkLikeness::Same(const std::string& mark, const std::string& turned, const Matrix2d& turn) {
  const Key key{mark, turned, {turn(0, 0), turn(0, 1), turn(1, 0), turn(1, 1)}};
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  const MarkShape &shape = shapes_.at(mark), &other = shapes_.at(turned);
  const double radius = std::max(MarkRadius(shape), MarkRadius(other));
  const auto upright = [&](const std::string& name) -> const MarkTemplate& {
    const auto known_picture = upright_.find({name, radius});
    if (known_picture != upright_.end()) return known_picture->second;
    return upright_
        .try_emplace({name, radius}, SmallPicture(shapes_.at(name), radius, Matrix2d::Identity()))
        .first->second;
  };
  const bool same = AreAlike(upright(mark), TurnedPicture(other, upright(turned), radius, turn));
  known_.emplace(key, same);
  return same;
}

}  // namespace orient::interior

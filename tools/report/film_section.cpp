#include "tools/report/film_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/median.h"
#include "interior/orientation/film_transform.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

// Film shrinks by some 1e-4; scans of other pixel sizes differ by more than this.
constexpr double kSamePixelSize = 0.01;

// Photos of one camera, scanned with one pixel size: only these have a mean.
struct Roll {
  std::string camera;                // as their results identify it
  std::vector<std::string> cameras;  // its name in the camera library, where it was found there
  std::string first, last;           // photos
  int marks = 0, marks_used = 0;
  std::vector<double> column_um, row_um, difference, shear, sigma0_um;
};

// "25.003 ± 0.004": mean and standard deviation.
std::string MeanAndSpread(const std::vector<double>& values, int decimals) {
  if (values.empty()) return kNoValue;
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  if (values.size() < 2) return Decimal(mean, decimals);
  return Decimal(mean, decimals) + " ± " + Decimal(std::sqrt(squares / (n - 1)), decimals);
}

std::string CameraOf(const InteriorResult& interior) {
  const auto camera = interior.made_from.find("camera");
  return camera == interior.made_from.end() ? "" : camera->second;
}

Roll& RollOf(const InteriorResult& interior, double column_um, std::vector<Roll>* rolls) {
  const std::string camera = CameraOf(interior);
  const auto same = [&](const Roll& roll) {
    return roll.camera == camera && roll.cameras == interior.cameras &&
           std::abs(roll.column_um.front() / column_um - 1) < kSamePixelSize;
  };
  const auto roll = std::find_if(rolls->begin(), rolls->end(), same);
  if (roll != rolls->end()) return *roll;
  Roll made;
  made.camera = camera;
  made.cameras = interior.cameras;
  made.first = interior.photo;
  rolls->push_back(std::move(made));
  return rolls->back();
}

void Include(const InteriorResult& interior, std::vector<Roll>* rolls) {
  const interior::FilmShape shape = interior::ShapeOf(*interior.photo_from_pixel);
  Roll& roll = RollOf(interior, shape.column_um, rolls);
  roll.last = interior.photo;
  roll.column_um.push_back(shape.column_um);
  roll.row_um.push_back(shape.row_um);
  roll.difference.push_back(1e6 * shape.scale_difference);
  roll.shear.push_back(1e6 * shape.shear_rad);
  if (interior.sigma0_um) roll.sigma0_um.push_back(*interior.sigma0_um);
  for (const MarkResult& mark : interior.marks) {
    ++roll.marks;
    roll.marks_used += mark.state == MarkState::kUsed;
  }
}

// "3 photos, 4711 to 4713, wild_rc10".
std::string Heading(const Roll& roll) {
  const auto photos = roll.column_um.size();
  std::string text = photos == 1
                         ? "1 photo, " + roll.first
                         : fmt::format("{} photos, {} to {}", photos, roll.first, roll.last);
  if (!roll.cameras.empty()) text += ", " + Joined(roll.cameras, " or ");
  return text;
}

Markup RollTable(const Roll& roll) {
  return Fill("film.html#roll", {{"roll", Heading(roll)},
                                 {"marks_used", roll.marks_used},
                                 {"marks", roll.marks},
                                 {"column", MeanAndSpread(roll.column_um, 3)},
                                 {"row", MeanAndSpread(roll.row_um, 3)},
                                 {"difference", MeanAndSpread(roll.difference, 0)},
                                 {"shear", MeanAndSpread(roll.shear, 0)},
                                 {"sigma0", MeanAndSpread(roll.sigma0_um, 1)}});
}

// Of a pixel of the scan in the photo.
std::optional<double> PixelMm(const PhotoRecord& photo, const Camera& camera) {
  if (camera.kind == CameraKind::kDigital && photo.exterior && photo.exterior->width > 0)
    return camera.frame_mm.x() / photo.exterior->width;
  if (!photo.interior || !photo.interior->photo_from_pixel) return std::nullopt;
  return std::sqrt(std::abs(photo.interior->photo_from_pixel->A.determinant()));
}

Markup ScaleRow(const char* what, const char* unit, std::vector<double> values, int digits) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double smallest = *least, largest = *most;
  return Fill("film.html#scale", {{"what", what},
                                  {"median", Grouped(Median(std::move(values)), digits)},
                                  {"smallest", Grouped(smallest, digits)},
                                  {"largest", Grouped(largest, digits)},
                                  {"unit", unit}});
}

Markup ScaleTable(const std::vector<SeenScale>& seen) {
  if (seen.empty()) return {};
  std::vector<double> height, scale, gsd;
  for (const SeenScale& one : seen) {
    height.push_back(one.height_m);
    scale.push_back(one.scale);
    gsd.push_back(one.gsd_m);
  }
  const int digits = DecimalsForSigma(0.1 * Median(gsd));
  Markup rows = ScaleRow("Image scale 1 :", "", scale, 0);
  rows += ScaleRow("Pixel on the ground", "m", gsd, digits);
  rows += ScaleRow("Height above ground", "m", height, 0);
  return Fill("film.html#scales", {{"rows", rows}});
}

}  // namespace

std::optional<SeenScale> ScaleOf(const PhotoRecord& photo, const Camera& camera) {
  const auto pixel_mm = PixelMm(photo, camera);
  if (!photo.exterior || !photo.exterior->pose || photo.exterior->footprint_m.empty() || !pixel_mm)
    return std::nullopt;
  double ground_m = 0;
  for (const Eigen::Vector3d& point : photo.exterior->footprint_m)
    ground_m += point.z() / static_cast<double>(photo.exterior->footprint_m.size());
  const auto& own = photo.exterior->principal_distance;
  const double c_mm = own ? own->value_mm : camera.principal_distance_mm;
  SeenScale seen;
  seen.height_m = photo.exterior->pose->position_m.z() - ground_m;
  seen.scale = 1000 * seen.height_m / c_mm;
  seen.gsd_m = 1e-3 * *pixel_mm * seen.scale;
  if (!(seen.height_m > 0) || !std::isfinite(seen.gsd_m)) return std::nullopt;
  return seen;
}

Markup CameraSection(const BlockRecord& block) {
  if (!block.camera) return {};
  const Camera& camera = *block.camera;
  std::vector<SeenScale> seen;
  for (const PhotoRecord& photo : block.photos)
    if (const auto scale = ScaleOf(photo, camera)) seen.push_back(*scale);
  return Fill("film.html#camera", {{"name", camera.name},
                                   {"kind", camera.kind == CameraKind::kFilm ? "film" : "digital"},
                                   {"principal_distance", Decimal(camera.principal_distance_mm, 3)},
                                   {"width", Decimal(camera.frame_mm.x(), 1)},
                                   {"height", Decimal(camera.frame_mm.y(), 1)},
                                   {"scales", ScaleTable(seen)}});
}

Markup FilmSection(const BlockRecord& block) {
  std::vector<Roll> rolls;
  for (const PhotoRecord& photo : block.photos)
    if (photo.interior && photo.interior->photo_from_pixel) Include(*photo.interior, &rolls);
  if (rolls.empty()) return {};
  Markup tables;
  for (const Roll& roll : rolls) tables += RollTable(roll);
  return Fill("film.html", {{"rolls", tables}});
}

}  // namespace orient

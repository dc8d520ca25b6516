#include "tools/report/film_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/median.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

// "25.003 ± 0.004": mean and standard deviation.
std::string MeanAndSpreadText(const MeanAndSpread& values, int decimals) {
  const std::string mean = Decimal(values.mean, decimals);
  return values.spread ? mean + " ± " + Decimal(*values.spread, decimals) : mean;
}

// "3 photos, 4711 to 4713, wild_rc10".
std::string Heading(const FilmRoll& roll) {
  std::string text = roll.photos == 1
                         ? "1 photo, " + roll.first
                         : fmt::format("{} photos, {} to {}", roll.photos, roll.first, roll.last);
  if (!roll.cameras.empty()) text += ", " + Joined(roll.cameras, " or ");
  return text;
}

Markup RollTable(const FilmRoll& roll) {
  return Fill("film.html#roll",
              {{"roll", Heading(roll)},
               {"marks_used", roll.marks_used},
               {"marks", roll.marks},
               {"column", MeanAndSpreadText(roll.column_um, 3)},
               {"row", MeanAndSpreadText(roll.row_um, 3)},
               {"difference", MeanAndSpreadText(roll.difference_ppm, 0)},
               {"shear", MeanAndSpreadText(roll.shear_urad, 0)},
               {"sigma0", roll.sigma0_um ? MeanAndSpreadText(*roll.sigma0_um, 1) : kNoValue}});
}

// Size of a scan pixel in the photo.
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

std::vector<FilmRoll> FilmRollsOf(const BlockRecord& block) {
  std::vector<const InteriorResult*> photos;
  for (const PhotoRecord& photo : block.photos)
    if (photo.interior) photos.push_back(&*photo.interior);
  return FilmRolls(photos);
}

Markup FilmSection(const BlockRecord& block) {
  const std::vector<FilmRoll> rolls = FilmRollsOf(block);
  if (rolls.empty()) return {};
  Markup tables;
  for (const FilmRoll& roll : rolls) tables += RollTable(roll);
  return Fill("film.html", {{"rolls", tables}});
}

}  // namespace orient

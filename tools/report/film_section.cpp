#include "tools/report/film_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

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

}  // namespace

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

#include "tools/report/figures/film_figures.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "interior/orientation/film_transform.h"

namespace orient {
namespace {

// Film shrinks by some 1e-4; scans of other pixel sizes differ by more than this.
constexpr double kSamePixelSize = 0.01;

struct Collected {
  std::string camera;  // as the photos' results identify it
  FilmRoll roll;
  std::vector<double> column_um, row_um, difference_ppm, shear_urad, sigma0_um;
};

std::string CameraOf(const InteriorResult& interior) {
  const auto camera = interior.made_from.find("camera");
  return camera == interior.made_from.end() ? "" : camera->second;
}

Collected& RollOf(const InteriorResult& interior, double column_um, std::vector<Collected>* rolls) {
  const std::string camera = CameraOf(interior);
  const auto same = [&](const Collected& other) {
    return other.camera == camera && other.roll.cameras == interior.cameras &&
           std::abs(other.column_um.front() / column_um - 1) < kSamePixelSize;
  };
  const auto found = std::find_if(rolls->begin(), rolls->end(), same);
  if (found != rolls->end()) return *found;
  Collected made;
  made.camera = camera;
  made.roll.cameras = interior.cameras;
  made.roll.first = interior.photo;
  rolls->push_back(std::move(made));
  return rolls->back();
}

void Include(const InteriorResult& interior, std::vector<Collected>* rolls) {
  const interior::FilmShape shape = interior::ShapeOf(*interior.photo_from_pixel);
  Collected& of = RollOf(interior, shape.column_um, rolls);
  of.roll.last = interior.photo;
  ++of.roll.photos;
  of.column_um.push_back(shape.column_um);
  of.row_um.push_back(shape.row_um);
  of.difference_ppm.push_back(1e6 * shape.scale_difference);
  of.shear_urad.push_back(1e6 * shape.shear_rad);
  if (interior.sigma0_um) of.sigma0_um.push_back(*interior.sigma0_um);
  for (const MarkResult& mark : interior.marks) {
    ++of.roll.marks;
    of.roll.marks_used += mark.state == MarkState::kUsed;
  }
}

}  // namespace

std::optional<MeanAndSpread> MeanAndSpreadOf(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const auto n = static_cast<double>(values.size());
  MeanAndSpread result{std::accumulate(values.begin(), values.end(), 0.0) / n};
  double squares = 0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  if (values.size() > 1) result.spread = std::sqrt(squares / (n - 1));
  return result;
}

std::vector<FilmRoll> FilmRolls(const std::vector<const InteriorResult*>& photos) {
  std::vector<Collected> collected;
  for (const InteriorResult* photo : photos)
    if (photo != nullptr && photo->photo_from_pixel) Include(*photo, &collected);
  std::vector<FilmRoll> rolls;
  for (Collected& of : collected) {
    of.roll.column_um = *MeanAndSpreadOf(of.column_um);
    of.roll.row_um = *MeanAndSpreadOf(of.row_um);
    of.roll.difference_ppm = *MeanAndSpreadOf(of.difference_ppm);
    of.roll.shear_urad = *MeanAndSpreadOf(of.shear_urad);
    of.roll.sigma0_um = MeanAndSpreadOf(of.sigma0_um);
    rolls.push_back(std::move(of.roll));
  }
  return rolls;
}

}  // namespace orient

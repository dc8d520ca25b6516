#include "core/measurements/gathered_measurements.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/geometry/ground_height.h"
#include "core/geometry/sigma.h"

namespace orient {
namespace {

void RequireName(const std::string& where, const std::string& what, const std::string& name) {
  if (name.empty()) throw InputError(fmt::format("{}: the {} has no name", where, what));
  const bool control =
      std::any_of(name.begin(), name.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; });
  if (control)
    throw InputError(
        fmt::format("{}: the {}'s name holds a line break or another control "
                    "character; give it a plain name",
                    where, what));
}

void RequireSigma(const std::string& where, double sigma) {
  if (const std::string why = SigmaProblem(sigma); !why.empty())
    throw InputError(fmt::format("{}: the standard deviation is {:g}; {}", where, sigma, why));
}

void RequireHeight(const std::string& where, double height_m) {
  if (!CanBeGround(height_m))
    throw InputError(
        fmt::format("{}: the height is {:g}, where no ground lies; heights are in "
                    "metres",
                    where, height_m));
}

[[noreturn]] void FailTwice(const std::string& where, const std::string& what,
                            const std::string& first) {
  throw InputError(
      fmt::format("{}: {} a second time, with other values than in {}; delete one of them", where,
                  what, first));
}

bool Same(const ImagePointMeasurement& a, const ImagePointMeasurement& b) {
  return a.pixel == b.pixel && a.photo_mm == b.photo_mm && a.sigma == b.sigma;
}

bool Same(const GroundPoint& a, const GroundPoint& b) {
  return a.ground_m == b.ground_m && a.sigma_m == b.sigma_m && a.role == b.role;
}

}  // namespace

void GatheredMeasurements::Add(const std::string& where, const ImagePointMeasurement& seen) {
  ++found_;
  RequireName(where, "photo", seen.photo);
  RequireName(where, "point", seen.point);
  RequireSigma(where, seen.sigma);
  std::vector<ImagePointMeasurement>& points = all_.image_points;
  if (!points.empty() && points.front().pixel.has_value() != seen.pixel.has_value())
    throw InputError(fmt::format(
        "{}: this image point is in {}, those before it are in {}; import them into two folders",
        where, seen.pixel ? "pixels" : "millimetres", seen.pixel ? "millimetres" : "pixels"));
  const auto [place, is_new] =
      image_points_.try_emplace(seen.photo + "\n" + seen.point, Place{points.size(), where});
  if (is_new)
    points.push_back(seen);
  else if (!Same(points[place->second.index], seen))
    FailTwice(where, fmt::format("point {} of photo {} is measured", seen.point, seen.photo),
              place->second.where);
}

void GatheredMeasurements::Add(const std::string& where, const GroundPoint& point) {
  ++found_;
  RequireName(where, "point", point.name);
  RequireHeight(where, point.ground_m.z());
  for (const double sigma : point.sigma_m) RequireSigma(where, sigma);
  const auto [place, is_new] = points_.try_emplace(point.name, Place{all_.points.size(), where});
  if (is_new)
    all_.points.push_back(point);
  else if (!Same(all_.points[place->second.index], point))
    FailTwice(where, fmt::format("point {} is given", point.name), place->second.where);
}

}  // namespace orient

#include "core/measurements/measurements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/base/number_text.h"

namespace orient {
namespace {

struct NamedKind {
  DecisionKind kind;
  const char* name;
};
constexpr std::array<NamedKind, 7> kKinds = {{{DecisionKind::kAccept, "accept"},
                                              {DecisionKind::kReject, "reject"},
                                              {DecisionKind::kOrientation, "orientation"},
                                              {DecisionKind::kPolarity, "polarity"},
                                              {DecisionKind::kCamera, "camera"},
                                              {DecisionKind::kPixelSize, "pixel_size"},
                                              {DecisionKind::kPosition, "position"}}};

template <typename Measured>
std::vector<Measured> OfPhoto(const std::vector<Measured>& all, const std::string& photo) {
  std::vector<Measured> own;
  std::copy_if(all.begin(), all.end(), std::back_inserter(own),
               [&](const Measured& one) { return one.photo == photo; });
  return own;
}

// "X Y SIGMA".
std::optional<DecidedPosition> PositionIn(const std::string& text) {
  std::istringstream words(text);
  std::string x, y, sigma, more;
  if (!(words >> x >> y >> sigma) || words >> more) return std::nullopt;
  const auto east = NumberIn(x), north = NumberIn(y), sigma_m = NumberIn(sigma);
  constexpr double kFarthest_m = 1e9, kLargestSigma_m = 1e6;
  if (!east || !north || !sigma_m || !(std::abs(*east) < kFarthest_m) ||
      !(std::abs(*north) < kFarthest_m) || !(*sigma_m > 0 && *sigma_m <= kLargestSigma_m))
    return std::nullopt;
  return DecidedPosition{{*east, *north}, *sigma_m};
}

std::string TextOfDecisions(const Measurements& measurements, const std::string& photo,
                            bool with_position) {
  std::string text;
  for (const Decision& decision : OfPhoto(measurements.decisions, photo))
    if (with_position || decision.kind != DecisionKind::kPosition)
      text += fmt::format("{} {};", Name(decision.kind), decision.value);
  return text;
}

}  // namespace

std::string_view Name(DecisionKind kind) { return kKinds.at(static_cast<std::size_t>(kind)).name; }

std::optional<DecisionKind> DecisionKindFromName(const std::string& name) {
  const auto found = std::find_if(kKinds.begin(), kKinds.end(),
                                  [&](const NamedKind& kind) { return name == kind.name; });
  if (found == kKinds.end()) return std::nullopt;
  return found->kind;
}

std::vector<MarkMeasurement> Measurements::MarksOf(const std::string& photo) const {
  return OfPhoto(marks, photo);
}

std::vector<ImagePointMeasurement> Measurements::ImagePointsOf(const std::string& photo) const {
  return OfPhoto(image_points, photo);
}

const GroundPoint* Measurements::Point(const std::string& name) const {
  const auto found = std::find_if(points.begin(), points.end(),
                                  [&](const GroundPoint& point) { return point.name == name; });
  return found == points.end() ? nullptr : &*found;
}

const Decision* Measurements::DecisionOn(const std::string& photo, DecisionKind kind) const {
  const auto found = std::find_if(decisions.begin(), decisions.end(), [&](const Decision& one) {
    return one.photo == photo && one.kind == kind;
  });
  return found == decisions.end() ? nullptr : &*found;
}

std::optional<ScanOrientation> Measurements::OrientationOf(const std::string& photo) const {
  const Decision* decision = DecisionOn(photo, DecisionKind::kOrientation);
  return decision ? ScanOrientationFromName(decision->value) : std::nullopt;
}

std::optional<Polarity> Measurements::PolarityOf(const std::string& photo) const {
  const Decision* decision = DecisionOn(photo, DecisionKind::kPolarity);
  if (decision == nullptr) return std::nullopt;
  return decision->value == "negative" ? Polarity::kNegative : Polarity::kPositive;
}

std::optional<double> Measurements::PixelSizeOf_um(const std::string& photo) const {
  const Decision* decision = DecisionOn(photo, DecisionKind::kPixelSize);
  return decision ? NumberIn(decision->value) : std::nullopt;
}

std::optional<DecidedPosition> Measurements::PositionOf(const std::string& photo) const {
  const Decision* decision = DecisionOn(photo, DecisionKind::kPosition);
  return decision ? PositionIn(decision->value) : std::nullopt;
}

std::string TextOfMarks(const Measurements& measurements, const std::string& photo) {
  std::string text = TextOfDecisions(measurements, photo, false);
  for (const MarkMeasurement& mark : measurements.MarksOf(photo))
    text += fmt::format("{} {:.9g} {:.9g} {:.4g} {:d};", mark.mark, mark.pixel.x(), mark.pixel.y(),
                        mark.sigma_px, mark.exact);
  return text;
}

std::string TextOfPoints(const Measurements& measurements, const std::string& photo) {
  std::string text = TextOfDecisions(measurements, photo, true);
  for (const ImagePointMeasurement& seen : measurements.ImagePointsOf(photo)) {
    const GroundPoint* point = measurements.Point(seen.point);
    if (point == nullptr) continue;
    const Eigen::Vector2d at = seen.pixel ? *seen.pixel : *seen.photo_mm;
    const Eigen::Vector3d &ground = point->ground_m, &sigma = point->sigma_m;
    text += fmt::format(
        "{} {:.8g} {:.8g} {:.4g} {:d} {:.12g} {:.12g} {:.9g} {:.4g} {:.4g} {:.4g} "
        "{:d};",
        seen.point, at.x(), at.y(), seen.sigma, seen.pixel.has_value(), ground.x(), ground.y(),
        ground.z(), sigma.x(), sigma.y(), sigma.z(), static_cast<int>(point->role));
  }
  return text;
}

std::string DecisionProblem(DecisionKind kind, const std::string& value) {
  switch (kind) {
    case DecisionKind::kAccept:
    case DecisionKind::kReject:
      return value.empty() ? "" : "is of no use here; leave it empty";
    case DecisionKind::kOrientation:
      if (ScanOrientationFromName(value)) return "";
      return "must be r0, r90, r180, r270, m0, m90, m180 or m270";
    case DecisionKind::kPolarity:
      return value == "positive" || value == "negative" ? "" : "must be positive or negative";
    case DecisionKind::kCamera:
      return value.empty() ? "must be a camera file or a name from the camera library" : "";
    case DecisionKind::kPosition:
      return PositionIn(value) ? "" : "must be x, y and one sigma in metres, with blanks between";
    case DecisionKind::kPixelSize:
      break;
  }
  const auto number = NumberIn(value);
  return number && *number >= 1 && *number <= 1000 ? "" : "must lie between 1 and 1000 micrometres";
}

std::string TextOf(const Decision& decision) {
  std::string text = decision.attribution.by.empty() ? "a person" : decision.attribution.by;
  if (!decision.attribution.when.empty()) text += ", " + decision.attribution.when;
  if (!decision.reason.empty()) text += ": " + decision.reason;
  return text;
}

}  // namespace orient

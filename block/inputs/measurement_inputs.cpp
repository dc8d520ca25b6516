#include "block/inputs/measurement_inputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "block/inputs/approximations.h"
#include "block/inputs/digest.h"
#include "core/base/error.h"
#include "core/base/median.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

Finding DecisionFinding(Reason reason, const Decision& decision, Status at_best) {
  return {.reason = reason, .at_best = at_best, .where = TextOf(decision)};
}

// True if the photo is rejected.
template <typename Result>
bool Judge(const Measurements& measurements, Result* result) {
  std::erase_if(result->findings, [](const Finding& finding) {  // of an earlier stage
    return finding.reason == Reason::kAcceptedByPerson ||
           finding.reason == Reason::kRejectedByPerson;
  });
  const Decision* accepted = measurements.DecisionOn(result->photo, DecisionKind::kAccept);
  if (accepted && result->status != Status::kFailed) {
    for (Finding& finding : result->findings) finding.at_best = Status::kOk;
    result->findings.insert(result->findings.begin(),
                            DecisionFinding(Reason::kAcceptedByPerson, *accepted, Status::kOk));
    result->status = Status::kOk;
  }
  const Decision* rejected = measurements.DecisionOn(result->photo, DecisionKind::kReject);
  if (!rejected) return false;
  result->findings.insert(result->findings.begin(),
                          DecisionFinding(Reason::kRejectedByPerson, *rejected, Status::kFailed));
  result->status = Status::kFailed;
  return true;
}

// Expected heights of photos taken on the same flight as these.
struct FlyingHeights {
  std::optional<double> median_m;
  double sigma_m = 0;
};

FlyingHeights HeightsOf(const std::vector<OrientationRow>& rows) {
  constexpr double kLeastSigma_m = 50;  // typical differences within a flight
  std::vector<double> heights, departures;
  for (const OrientationRow& row : rows)
    if (std::isfinite(row.pose.position_m.z())) heights.push_back(row.pose.position_m.z());
  if (heights.empty()) return {std::nullopt, kLeastSigma_m};
  const double median = Median(heights);
  for (const double height : heights) departures.push_back(std::abs(height - median));
  return {median, std::max(kLeastSigma_m, kSigmaOfMedianDeviation * Median(departures))};
}

}  // namespace

std::vector<std::string> MarkIds(const CameraFile& camera) {
  std::vector<std::string> ids;
  for (const Fiducial& fiducial : camera.fiducials) ids.push_back(fiducial.id);
  return ids;
}

void RequireKnownMarks(const Measurements& measurements, const std::string& photo,
                       const CameraFile& camera) {
  const std::vector<std::string> ids = MarkIds(camera);
  for (const MarkMeasurement& mark : measurements.MarksOf(photo)) {
    if (std::find(ids.begin(), ids.end(), mark.mark) != ids.end()) continue;
    throw InputError(fmt::format(
        "{}/{}: photo {} has a mark \"{}\", but its camera{} {}; correct the id, or delete "
        "the line",
        measurements.folder, kMarksFile, photo, mark.mark,
        camera.camera.name.empty() ? "" : " (" + camera.camera.name + ")",
        ids.empty() ? "has no marks" : fmt::format("has the marks {}", fmt::join(ids, ", "))));
  }
}

namespace {

// Letters and digits in lower case, to match other spellings of a name: "New-1.2" -> "new12".
std::string LettersAndDigits(const std::string& name) {
  std::string text;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

std::vector<std::string> PhotoNames(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  for (const std::string& path : paths) names.push_back(PhotoName(path));
  return names;
}

std::optional<Finding> UnknownPhotos(const Measurements& measurements,
                                     const std::vector<std::string>& photos) {
  constexpr std::size_t kNamed = 5;
  std::set<std::string> unknown;
  for (const auto& one : measurements.marks) unknown.insert(one.photo);
  for (const auto& one : measurements.image_points) unknown.insert(one.photo);
  for (const auto& one : measurements.decisions) unknown.insert(one.photo);
  for (const std::string& photo : photos) unknown.erase(photo);
  if (unknown.empty()) return std::nullopt;
  std::map<std::string, std::string> alike;
  for (const std::string& photo : photos) alike[LettersAndDigits(photo)] = photo;
  std::vector<std::string> names;
  for (const std::string& photo : unknown) {
    if (names.size() == kNamed) {
      names.push_back(fmt::format("{} more", unknown.size() - kNamed));
      break;
    }
    const auto meant = alike.find(LettersAndDigits(fs::path(photo).filename().string()));
    names.push_back(meant == alike.end() ? photo
                                         : fmt::format("{} (is it {}?)", photo, meant->second));
  }
  return Finding{.reason = Reason::kMeasuredPhotosUnknown,
                 .value = static_cast<double>(unknown.size()),
                 .where = fmt::format("{}", fmt::join(names, ", "))};
}

interior::InteriorOptions WithMarksOf(const Measurements& measurements, const std::string& photo,
                                      interior::InteriorOptions options) {
  for (const MarkMeasurement& mark : measurements.MarksOf(photo))
    options.clicks.push_back({mark.mark, mark.pixel, mark.sigma_px, mark.exact});
  if (const auto orientation = measurements.OrientationOf(photo)) options.orientation = orientation;
  if (const auto polarity = measurements.PolarityOf(photo)) options.polarity = polarity;
  if (const auto pixel_um = measurements.PixelSizeOf_um(photo)) options.pixel_size_um = pixel_um;
  return options;
}

void ApplyDecidedPositions(
    const Measurements& measurements, const std::vector<std::string>& photos,
    const AssumedAccuracy& accuracy,
    const std::function<std::optional<ExpectedHeight>(const Eigen::Vector2d&)>& height_at,
    std::vector<OrientationRow>* rows) {
  const FlyingHeights heights = HeightsOf(*rows);
  for (const std::string& photo : photos) {
    const auto position = measurements.PositionOf(photo);
    if (!position) continue;
    auto row = std::find_if(rows->begin(), rows->end(),
                            [&](const OrientationRow& one) { return one.photo == photo; });
    const bool known = row != rows->end();
    double height_sigma_m = heights.sigma_m;
    if (!known) {
      const auto height = height_at ? height_at(position->ground_m) : std::nullopt;
      if (!height && !heights.median_m)
        throw InputError(fmt::format(
            "{}/{}: the position of photo {} needs a height, and no flying height is known; "
            "give a table of approximations with the height of one photo, or in a block file "
            "flying_height_m or scale under [flight]",
            measurements.folder, kDecisionsFile, photo));
      rows->push_back({.photo = photo, .pose = {}, .sigma = {}, .attitude_known = false});
      row = rows->end() - 1;
      row->pose.position_m.z() = height ? height->z_m : *heights.median_m;
      if (height) height_sigma_m = height->sigma_m;
    }
    Vector6d sigma =
        SigmaOfApproximation(*row, accuracy.position_m, accuracy.attitude_rad, accuracy.kappa_rad);
    row->pose.position_m.head<2>() = position->ground_m;
    sigma.head<2>().setConstant(position->sigma_m);
    if (!known) sigma[2] = std::max(position->sigma_m, height_sigma_m);
    row->sigma = sigma;
  }
}

std::vector<exterior::MeasuredPoint> PointsOf(const Measurements& measurements,
                                              const std::string& photo,
                                              const exterior::FilmPosition& position) {
  std::vector<exterior::MeasuredPoint> points;
  const double pixel_mm = std::sqrt(std::abs(position.photo_from_pixel.A.determinant()));
  for (const ImagePointMeasurement& seen : measurements.ImagePointsOf(photo)) {
    const GroundPoint* point = measurements.Point(seen.point);
    if (point == nullptr) continue;
    exterior::MeasuredPoint to;
    to.name = point->name;
    to.ground_m = point->ground_m;
    to.sigma_m = point->sigma_m;
    to.pixel = seen.pixel ? *seen.pixel
                          : PixelFromPhoto(position.photo_from_pixel,
                                           position.film_correction.get(), *seen.photo_mm);
    to.sigma_px = seen.pixel ? seen.sigma : seen.sigma / pixel_mm;
    to.control = point->role == PointRole::kControl;
    to.in_photo_system = !seen.pixel;
    points.push_back(std::move(to));
  }
  return points;
}

void AddMeasurements(const std::string& text, Inputs* inputs) {
  if (!text.empty()) (*inputs)["measurements"] = Digest(text);
}

void ApplyVerdict(const Measurements& measurements, InteriorResult* result) {
  if (!Judge(measurements, result)) return;
  result->photo_from_pixel.reset();
  result->reseau.reset();
  result->possible_orientations.clear();
  result->orientation.reset();
}

void ApplyVerdict(const Measurements& measurements, ExteriorResult* result) {
  if (Judge(measurements, result)) WithdrawPose(result);
}

}  // namespace orient::block

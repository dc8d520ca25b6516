#include "tools/convert/check_exports.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/exchange/colmap.h"
#include "core/exchange/opensfm.h"
#include "tools/convert/export_record.h"
#include "tools/convert/metashape_ground.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr double kNever = std::numeric_limits<double>::infinity();

ReadingFit Fit(const ProgramFiles& files, const std::vector<VerificationRow>& rows,
               const Reading& reading) {
  ReadingFit fit{reading, 0, 0};
  const bool pixels = files.Choices().pixels;
  for (const VerificationRow& row : rows) {
    const auto seen = files.Project(row.image, row.file_m, row.principal_distance_mm, reading);
    double distance = kNever;
    if (seen)
      distance =
          pixels ? (*seen - row.pixel).norm() : (*seen - row.reduced_mm).norm() / row.pixel_mm;
    if (!std::isfinite(distance)) return {reading, kNever, kNever};
    fit.rms_px += distance * distance;
    fit.largest_px = std::max(fit.largest_px, distance);
  }
  fit.rms_px = std::sqrt(fit.rms_px / static_cast<double>(rows.size()));
  return fit;
}

// A ground point of the files and the pixel (Orient's) at which an image saw it.
struct OwnPoint {
  std::string image;
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

// By image; images without measurements have an empty list.
using OwnPoints = std::map<std::string, std::vector<OwnPoint>>;

template <typename Observation>
OwnPoints PointsOf(const ExchangeBlock& block, const std::string& directory,
                   const std::vector<Observation>& observations) {
  RequireSound(block, directory);
  OwnPoints points;
  for (const ExchangePhoto& photo : block.photos) points[photo.image];
  for (const Observation& seen : observations)
    points[seen.image].push_back({seen.image, seen.ground, seen.pixel});
  return points;
}

// Empty for formats whose files hold none that we read.
OwnPoints ReadOwnPoints(ExchangeFormat format, const std::string& directory) {
  if (format == ExchangeFormat::kColmap)
    return PointsOf(ExchangeFromColmap(ReadColmap(directory)), directory,
                    ReadColmapObservations(directory));
  if (format == ExchangeFormat::kOpensfm)
    return PointsOf(ExchangeFromOpensfm(ReadOpensfm(directory)), directory,
                    ReadOpensfmObservations(directory));
  return {};
}

double MedianDistance(const ProgramFiles& files, const std::vector<OwnPoint>& points,
                      const Reading& reading) {
  std::vector<double> distances;
  for (const OwnPoint& point : points) {
    const auto seen = files.Project(point.image, point.ground, 1, reading);
    const double distance = seen ? (*seen - point.pixel).norm() : kNever;
    distances.push_back(std::isfinite(distance) ? distance : kNever);
  }
  const auto middle = distances.begin() + std::ssize(distances) / 2;
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

// The median of the images' medians, so that none weighs more for its many points.
ReadingFit FitMeasured(const ProgramFiles& files, const OwnPoints& points, const Reading& reading) {
  std::vector<double> medians;
  for (const auto& [image, seen] : points)
    if (!seen.empty()) medians.push_back(MedianDistance(files, seen, reading));
  std::sort(medians.begin(), medians.end());
  return {reading, 0, medians.back(), medians[medians.size() / 2]};
}

// From each image, points spread evenly over all of its points, as many as are sufficient.
OwnPoints Thinned(OwnPoints points) {
  constexpr std::size_t kMost = 200;
  for (auto& [image, seen] : points) {
    const std::size_t step = seen.size() / kMost + 1;
    std::vector<OwnPoint> thinned;
    for (std::size_t i = 0; i < seen.size(); i += step) thinned.push_back(seen[i]);
    seen = std::move(thinned);
  }
  return points;
}

// All combinations of what a format's files could mean.
std::vector<Reading> Candidates(const ReadingChoices& choices) {
  std::vector<Reading> readings;
  for (int bits = 0; bits < 64; ++bits)
    for (const int half : {0, -1, 1}) {
      const auto bit = [&](int i) { return (bits >> i & 1) != 0; };
      const Reading r{bit(0), bit(1), bit(2), bit(3), bit(4), bit(5), half};
      const bool angles = r.phi_omega_kappa || r.other_unit;
      const bool pixels = r.mirrored_principal || half != 0;
      if ((angles && !choices.angles) || (pixels && !choices.pixels)) continue;
      readings.push_back(r);
    }
  return readings;
}

// The reading with the fewest departures among those that fit about as well as the best.
std::optional<ReadingFit> BestOther(const ProgramFiles& files,
                                    const std::vector<VerificationRow>& rows) {
  std::vector<ReadingFit> fits;
  double best = kNever;
  for (const Reading& reading : Candidates(files.Choices())) {
    if (reading.Count() == 0) continue;
    const ReadingFit fit = Fit(files, rows, reading);
    if (std::isfinite(fit.rms_px)) fits.push_back(fit);
    best = std::min(best, fit.rms_px);
  }
  std::erase_if(fits, [&](const ReadingFit& fit) { return fit.rms_px > 1.2 * best + 0.01; });
  if (fits.empty()) return std::nullopt;
  return *std::min_element(fits.begin(), fits.end(), [](const auto& a, const auto& b) {
    return a.reading.Count() < b.reading.Count();
  });
}

ExportCheck CheckMeasured(const ProgramFiles& files, ExportCheck check) {
  const OwnPoints points = Thinned(ReadOwnPoints(check.format, check.directory));
  for (const auto& [image, seen] : points) {
    check.points += seen.size();
    if (seen.empty()) check.unchecked.push_back(image);
  }
  if (check.points == 0)
    throw InputError(
        check.directory + " holds neither verification.csv nor image measurements of " +
        "points: nothing to check its poses with; give verification points by --points");
  check.measured = true;
  check.declared = FitMeasured(files, points, {});
  ReadingFit best = check.declared;
  for (const Reading& reading : Candidates(files.Choices())) {
    const ReadingFit fit = FitMeasured(files, points, reading);
    if (fit.median_px < best.median_px) best = fit;
  }
  const bool better = 3 * best.median_px < check.declared.median_px;
  if (better && best.median_px <= kMeasuredFits_px) check.fits = best;
  for (const auto& [image, seen] : points)
    if (!seen.empty() && !(MedianDistance(files, seen, {}) <= kMeasuredFits_px))
      check.off.push_back(image);
  check.ok = !better && check.off.empty();
  return check;
}

std::string Images(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  const std::size_t shown = std::min(names.size(), kMost);
  return fmt::format("{} ({}{})", names.size(),
                     fmt::join(names.begin(), names.begin() + static_cast<long>(shown), ", "),
                     shown < names.size() ? ", ..." : "");
}

std::string VerdictOfMeasured(const ExportCheck& check) {
  std::string text =
      fmt::format("{:<10} {:4} of its own measurements  ", Name(check.format), check.points);
  if (std::isfinite(check.declared.median_px))
    text += fmt::format("median {:.2g} px: ", check.declared.median_px);
  text += check.ok ? "fits" : "DOES NOT FIT";
  if (check.fits)
    text += fmt::format("; it fits to {:.2g} px if {}", check.fits->median_px,
                        Describe(check.fits->reading));
  else if (!check.off.empty())
    text += fmt::format("; the pose, camera and points of {} images are not of one adjustment",
                        Images(check.off));
  if (!check.unchecked.empty())
    text += fmt::format("; not checked, as they have no measurements: {} images",
                        Images(check.unchecked));
  return text;
}

}  // namespace

ExportCheck CheckExport(const std::string& directory, std::optional<ExchangeFormat> format,
                        const std::string& points) {
  const std::string record = ReadExportRecord(directory).format;
  if (!format) format = ExchangeFormatFromName(record);
  if (!format)
    throw InputError(directory + " does not name its format (no export.json); name it with --from");
  const std::string path = points.empty() ? VerificationPath(directory) : points;
  if (*format == ExchangeFormat::kMetashape) NotesOnMetashape(ReadMetashape(directory), directory);
  const auto files = OpenProgramFiles(*format, directory);
  ExportCheck check;
  check.format = *format;
  check.directory = directory;
  if (points.empty() && !fs::exists(path)) return CheckMeasured(*files, std::move(check));
  const std::vector<VerificationRow> rows = ReadVerification(path);
  check.points = rows.size();
  check.declared = Fit(*files, rows, {});
  check.ok = check.declared.largest_px <= kFits_px;
  if (check.ok) return check;
  const auto other = BestOther(*files, rows);
  // A ground system's curvature may leave some tenths of a pixel, which no other reading improves.
  const bool better = other && 3 * other->rms_px < check.declared.rms_px;
  check.ok = !better && check.declared.largest_px <= kAlmost_px;
  if (better && other->largest_px <= kAlmost_px) check.fits = other;
  return check;
}

std::vector<std::string> ExportFolders(const std::string& directory) {
  const auto holds = [](const fs::path& folder) {
    return fs::exists(VerificationPath(folder.string())) || fs::exists(folder / "export.json");
  };
  if (!fs::is_directory(directory)) throw InputError(directory + " is not a folder");
  if (holds(directory)) return {directory};
  std::vector<std::string> folders;
  for (const auto& entry : fs::directory_iterator(directory))
    if (entry.is_directory() && holds(entry.path())) folders.push_back(entry.path().string());
  std::sort(folders.begin(), folders.end());
  if (folders.empty())
    throw InputError(directory + " holds no export: no verification.csv there or directly below; " +
                     "name another program's format with --from");
  return folders;
}

std::string Verdict(const ExportCheck& check) {
  if (check.measured) return VerdictOfMeasured(check);
  std::string text = fmt::format("{:<10} {:4} points  ", Name(check.format), check.points);
  if (std::isfinite(check.declared.rms_px))
    text += fmt::format("rms {:.2g} px, largest {:.2g} px: ", check.declared.rms_px,
                        check.declared.largest_px);
  if (check.ok)
    return text + (check.declared.largest_px <= kFits_px
                       ? "fits"
                       : "fits to some tenths of a pixel (curvature of the ground system, a lens's "
                         "table)");
  text += "DOES NOT FIT";
  if (check.fits)
    return fmt::format("{}; it fits to {:.2g} px if {}", text, check.fits->largest_px,
                       Describe(check.fits->reading));
  return text + "; no known convention fits: a pose, the camera or the points differ";
}

}  // namespace orient

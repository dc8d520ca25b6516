#include "tools/convert/opensfm_ground.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <cstdio>
#include <filesystem>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "core/terrain/geocentric.h"
#include "tools/convert/ground_frame.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Larger than what onboard GPS and a reconstruction fitted to it leave, smaller than any meridian
// convergence or offset that would do harm.
constexpr double kFarAway_m = 100, kTurned_deg = 0.5, kScale = 0.1;
// Estimates this many standard deviations apart are told apart.
constexpr double kApart = 4;
constexpr std::size_t kFewest = 3;  // shots with GPS

// x_file = A x_topocentric + b.
struct Projected {
  Eigen::Matrix3d a = Eigen::Matrix3d::Identity();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
};

Projected ProjectionAt(const Crs& crs, const Eigen::Vector3d& lla, const Eigen::Vector2d& offset) {
  const GroundFrame frame =
      GroundFrame::Topocentric(crs, 0, {RadFromDeg(lla.x()), RadFromDeg(lla.y()), lla.z()});
  const auto projected = [&](const Eigen::Vector3d& local) {
    const auto point = frame.BlockFromFile(local);
    if (!point)
      throw InputError(fmt::format("reference_lla {:.6f} {:.6f} cannot be expressed in {}", lla.x(),
                                   lla.y(), crs.Name()));
    return *point;
  };
  Projected p;
  const Eigen::Vector3d origin = projected(Eigen::Vector3d::Zero());
  for (int i = 0; i < 3; ++i) p.a.col(i) = projected(Eigen::Vector3d::Unit(i)) - origin;
  p.b = origin - Eigen::Vector3d(offset.x(), offset.y(), 0);
  return p;
}

Eigen::Vector3d CentreOf(const OpensfmShot& shot) {
  const CameraFromGround camera = CameraFromGroundOf(shot);
  return -camera.rotation.transpose() * camera.translation;
}

// The rotation that OpenSfM stores for a matrix that is nearly a rotation: its quaternion's, which
// differs from the nearest rotation.
Eigen::Matrix3d Stored(const Eigen::Matrix3d& matrix) {
  return Eigen::Quaterniond(matrix).normalized().toRotationMatrix();
}

// The rotation R with Stored(R A^-1) = `stored`. A is a rotation but for some 1e-3.
Eigen::Matrix3d BeforeProjection(const Eigen::Matrix3d& stored, const Eigen::Matrix3d& a) {
  const Eigen::Matrix3d inverse = a.inverse();
  Eigen::Matrix3d rotation = Stored(stored * a);
  constexpr int kMostSteps = 20;
  for (int i = 0; i < kMostSteps; ++i)
    rotation = Stored(stored * Stored(rotation * inverse).transpose() * rotation);
  return rotation;
}

// t' = -R A^-1 (A c + b), whichever of its versions wrote it.
OpensfmReconstruction Topocentrically(OpensfmReconstruction reconstruction, const Projected& p) {
  for (OpensfmShot& shot : reconstruction.shots) {
    const CameraFromGround projected = CameraFromGroundOf(shot);
    const Eigen::Matrix3d rotation = BeforeProjection(projected.rotation, p.a);
    SetCameraFromGround({rotation, projected.translation + rotation * p.a.inverse() * p.b}, &shot);
  }
  return reconstruction;
}

// How the projection centres lie against the shots' GPS: a similarity in plan.
struct FitToGps {
  std::size_t shots = 0;
  double turn_deg = 0, sigma_deg = 0;
  double scale = 1;
  double shift_m = 0;
  double radius_m = 0;  // of the block

  bool Sound(bool with_shift) const {
    return std::abs(scale - 1) < kScale && std::abs(turn_deg) < kTurned_deg + 5 * sigma_deg &&
           (!with_shift || shift_m < kFarAway_m);
  }
};

std::optional<FitToGps> Fit(const OpensfmReconstruction& reconstruction) {
  std::vector<std::complex<double>> gps, centres;
  for (const OpensfmShot& shot : reconstruction.shots) {
    if (!shot.gps_position) continue;
    const Eigen::Vector3d centre = CentreOf(shot);
    gps.emplace_back(shot.gps_position->x(), shot.gps_position->y());
    centres.emplace_back(centre.x(), centre.y());
  }
  if (gps.size() < kFewest) return std::nullopt;
  const auto n = static_cast<double>(gps.size());
  std::complex<double> gps_mean = 0, centres_mean = 0;
  for (std::size_t i = 0; i < gps.size(); ++i)
    gps_mean += gps[i] / n, centres_mean += centres[i] / n;
  std::complex<double> product = 0;
  double spread = 0;
  for (std::size_t i = 0; i < gps.size(); ++i) {
    product += std::conj(gps[i] - gps_mean) * (centres[i] - centres_mean);
    spread += std::norm(gps[i] - gps_mean);
  }
  if (!(spread > 0)) return std::nullopt;
  const std::complex<double> turn = product / spread;
  double sum = 0;
  for (std::size_t i = 0; i < gps.size(); ++i)
    sum += std::norm(centres[i] - centres_mean - turn * (gps[i] - gps_mean));
  FitToGps fit;
  fit.shots = gps.size();
  fit.turn_deg = DegFromRad(std::arg(turn));
  fit.scale = std::abs(turn);
  fit.sigma_deg = DegFromRad(std::sqrt(sum / (2 * n - 4) / spread));
  fit.shift_m = std::abs(centres_mean - gps_mean);
  fit.radius_m = std::sqrt(spread / n);
  return fit;
}

// OpenDroneMap's projected CRS and offset: "WGS84 UTM 35N", then "492000 4690000".
struct Coords {
  std::string path;
  std::optional<Crs> crs;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
};

std::optional<Coords> CoordsBeside(const std::string& input) {
  const fs::path folder = fs::absolute(input).lexically_normal();
  for (const fs::path& path :
       {folder / "coords.txt", folder / "../odm_georeferencing/coords.txt"}) {
    if (!fs::exists(path)) continue;
    std::istringstream text(ReadFile(path.string()));
    Coords coords;
    coords.path = path.lexically_normal().string();
    std::string first;
    std::getline(text, first);
    int zone = 0;
    char half = 0;
    if (std::sscanf(first.c_str(), "WGS84 UTM %d%c", &zone, &half) == 2 && zone >= 1 &&
        zone <= 60 && (half == 'N' || half == 'S'))
      coords.crs =
          Crs::Parse(fmt::format("EPSG:{}", (half == 'N' ? 32600 : 32700) + zone), coords.path);
    if (!(text >> coords.offset.x() >> coords.offset.y()))
      throw InputError(coords.path + ": the second line must be the offset, two numbers");
    return coords;
  }
  return std::nullopt;
}

// OpenDroneMap keeps the file that it replaced.
bool TopocentricBeside(const std::string& input) {
  return fs::exists(fs::path(input) / "reconstruction.topocentric.json");
}

std::string Turned(const FitToGps& fit) {
  return fmt::format("turned by {:.2f} +- {:.2f} degrees", fit.turn_deg, fit.sigma_deg);
}

enum class Ground { kTopocentric, kProjected };

class Decision {
 public:
  Decision(OpensfmReconstruction reconstruction, const OpensfmGroundOptions& options,
           std::vector<std::string>* messages)
      : read_(std::move(reconstruction)), options_(options), messages_(messages) {
    coords_ = CoordsBeside(options.input);
    crs_ = coords_ && coords_->crs ? coords_->crs : options.crs;
    offset_ = options.offset;
    if (!offset_ && coords_) offset_ = coords_->offset;
    if (crs_ && read_.reference_lla) {
      projection_ =
          ProjectionAt(*crs_, *read_.reference_lla, offset_.value_or(Eigen::Vector2d::Zero()));
      back_ = Topocentrically(read_, *projection_);
      projected_ = Fit(*back_);
    }
    topocentric_ = Fit(read_);
  }

  OpensfmReconstruction Make() {
    if (Which() == Ground::kTopocentric) return std::move(read_);
    if (!projection_)
      throw InputError(options_.input +
                       " holds projected coordinates; name the block's projected "
                       "CRS with --crs");
    // Without an offset, the coordinates may be complete: then they agree with the GPS.
    if (!offset_ && !(projected_ && projected_->Sound(true)))
      throw InputError(fmt::format(
          "{}: the poses are in a projected system minus an offset, as OpenDroneMap writes them, "
          "and the offset is not known; give it with --offset X Y (the second line of "
          "odm_georeferencing/coords.txt)",
          options_.input));
    return std::move(*back_);
  }

 private:
  Ground Which() {
    if (options_.offset) return StatedGround();
    if (!topocentric_) return WithoutGps();
    const bool as_is = topocentric_->Sound(false);
    const bool undone = projected_ && projected_->Sound(false);
    if (as_is && undone) return OfBoth();
    // Without a CRS it is unknown how well projected ones would fit.
    if (as_is && (projected_ || topocentric_->Sound(true))) return Take(Ground::kTopocentric);
    return undone ? TakeProjected() : Refuse();
  }

  // A reconstruction whose stated offset leads elsewhere belongs to another block.
  Ground TakeProjected() {
    if (offset_ && !projected_->Sound(true)) Refuse();
    return Take(Ground::kProjected);
  }

  Ground StatedGround() {
    if (!projected_ || !topocentric_) return Ground::kProjected;
    const double difference = std::abs(projected_->turn_deg) - std::abs(topocentric_->turn_deg);
    const bool fits_less = topocentric_->Sound(true) && difference > kApart * projected_->sigma_deg;
    if (fits_less)
      throw InputError(
          fmt::format("{}: --offset says that the poses are projected, but then they "
                      "are {} against the shots' gps_position, and as topocentric {}; "
                      "leave --offset out",
                      options_.input, Turned(*projected_), Turned(*topocentric_)));
    if (!projected_->Sound(true)) Refuse();
    return Take(Ground::kProjected);
  }

  Ground WithoutGps() {
    if (TopocentricBeside(options_.input)) return Beside();
    messages_->push_back(
        "the poses are taken for topocentric, as OpenSfM defines them: no GPS positions of three "
        "shots tell whether they are (OpenDroneMap's are projected: --offset)");
    return Ground::kTopocentric;
  }

  Ground Beside() {
    messages_->push_back("the poses are taken for projected, as OpenDroneMap leaves them: " +
                         options_.input + " also holds reconstruction.topocentric.json");
    return Ground::kProjected;
  }

  // The rotation decides if it can: GPS that is shifted as a whole favours neither system.
  Ground OfBoth() {
    const double difference = std::abs(topocentric_->turn_deg) - std::abs(projected_->turn_deg);
    if (std::abs(difference) > kApart * topocentric_->sigma_deg)
      return difference < 0 ? Take(Ground::kTopocentric) : TakeProjected();
    const bool near = topocentric_->Sound(true);
    if (!near && !projected_->Sound(true)) Refuse();
    if (!near) return Take(Ground::kProjected);
    if (!projected_->Sound(offset_.has_value())) return Take(Ground::kTopocentric);
    return OfEither();
  }

  Ground OfEither() {
    if (TopocentricBeside(options_.input)) return Beside();
    const double between = RadFromDeg(topocentric_->turn_deg - projected_->turn_deg);
    messages_->push_back(fmt::format(
        "the poses are taken for topocentric, as OpenSfM defines them; by the shots' GPS positions "
        "they might as well be projected, as OpenDroneMap's are (--offset), which differs by "
        "{:.2f} "
        "m at the block's edge",
        std::abs(between) * topocentric_->radius_m * std::sqrt(2.0)));
    return Ground::kTopocentric;
  }

  Ground Take(Ground ground) {
    const FitToGps& taken = ground == Ground::kTopocentric ? *topocentric_ : *projected_;
    std::string text = fmt::format(
        "the poses are {}: against the GPS positions of {} shots they are then {}",
        ground == Ground::kTopocentric ? "topocentric" : "in a projected system minus an offset",
        taken.shots, Turned(taken));
    text += fmt::format(" and {:.1f} m away on average", taken.shift_m);
    const auto& other = ground == Ground::kTopocentric ? projected_ : topocentric_;
    if (other)
      text +=
          fmt::format("; taken for {} they would be {}",
                      ground == Ground::kTopocentric ? "projected" : "topocentric", Turned(*other));
    messages_->push_back(text);
    return ground;
  }

  [[noreturn]] Ground Refuse() const {
    std::string text = options_.input + ": the poses fit the shots' gps_position neither as " +
                       "topocentric" + GpsFitText(topocentric_);
    text += " nor as projected minus an offset";
    text += projected_ ? GpsFitText(projected_) : " (needs --crs)";
    throw InputError(text +
                     "; give the CRS of the reconstruction with --crs, or the offset of its "
                     "coordinates with --offset");
  }

  static std::string GpsFitText(const std::optional<FitToGps>& fit) {
    if (!fit) return "";
    return fmt::format(" ({}, scaled by {:.3f}, {:.0f} m away)", Turned(*fit), fit->scale,
                       fit->shift_m);
  }

  OpensfmReconstruction read_;
  const OpensfmGroundOptions& options_;
  std::vector<std::string>* messages_;
  std::optional<Coords> coords_;
  std::optional<Crs> crs_;
  std::optional<Eigen::Vector2d> offset_;
  std::optional<Projected> projection_;
  std::optional<OpensfmReconstruction> back_;
  std::optional<FitToGps> topocentric_, projected_;
};

}  // namespace

OpensfmReconstruction TopocentricOpensfm(OpensfmReconstruction reconstruction,
                                         const OpensfmGroundOptions& options,
                                         std::vector<std::string>* messages) {
  return Decision(std::move(reconstruction), options, messages).Make();
}

}  // namespace orient

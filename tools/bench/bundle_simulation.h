// A photo flight simulated as observations only: image positions of ties and control in the photos
// of a block, with known truth and errors of known size. For tests and benchmarks of the
// adjustment.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "block/bundle/adjustment.h"
#include "core/geometry/collinearity.h"

namespace orient {

struct BundleSimulationOptions {
  int strips = 3, photos_in_strip = 5;
  double forward_overlap = 0.6, side_overlap = 0.3;
  int ties_per_photo = 100;    // new ones; most photos show some three times as many
  int control_per_photo = 12;  // under the photos that have control
  std::vector<int> control_photos = {0, 4, 10, 14};
  bool control_seen_by_all = false;  // otherwise only by the photo above it
  double noise_px = 0.3, stated_px = 0.3;
  double control_ground_m = 0.075, control_height_m = 0.125;  // one sigma, GSD is 0.25 m
  double height_sigma_m = 0;  // of height errors shared by control patches, see GroundControl
  // Common errors of control patches of one source, as fractions of each patch's own error.
  double control_shared_everywhere = 0, control_shared_smoothly = 0;
  double source_sigma_m = 0;  // of their source as a whole, see GroundControl
  double position_sigma_m = 3, attitude_sigma_rad = 0.01;  // of the approximations
  bool prior = true;                                       // the approximations as prior
  double gnss_sigma_m = 0;                                 // 0: no GNSS
  Eigen::Vector3d gnss_shift_m = Eigen::Vector3d::Zero();
  double gross_ties = 0, gross_control = 0;  // shares of image observations
  double interior_sigma_mm = 0;              // of the film transform's shift; scale accordingly
  double relief_m = 60;
  unsigned seed = 1;
};

struct BundleSimulation {
  block::BlockToAdjust block;
  Camera true_camera;  // block.cameras has the nominal one
  std::vector<Pose> true_poses;
  std::vector<Eigen::Vector3d> true_ground;
  std::vector<bool> gross;  // of each observation
  double gsd_m = 0.25;
};

// 23 cm film at 25 um from 1530 m above ground, strips flown west to east and back.
class BundleSimulator {
 public:
  explicit BundleSimulator(const BundleSimulationOptions& options)
      : options_(options), random_(options.seed) {
    Camera camera;
    camera.kind = CameraKind::kFilm;
    camera.principal_distance_mm = 153;
    camera.frame_mm = {230, 230};
    simulation_.block.cameras = {camera};
    simulation_.true_camera = camera;
  }
  // Sets the true camera; the block's camera stays nominal.
  BundleSimulator& TrueCamera(const Camera& camera) {
    simulation_.true_camera = camera;
    return *this;
  }

  BundleSimulation Make() {
    MakePhotos();
    const double area =
        (options_.strips * StripStep() + Side()) * (options_.photos_in_strip * Base() + Side());
    const double per_photo = Base() * StripStep();
    const int ties = static_cast<int>(options_.ties_per_photo * area / per_photo);
    for (int i = 0; i < ties; ++i) AddTie();
    for (const int photo : options_.control_photos)
      for (int i = 0; i < options_.control_per_photo; ++i)
        AddControl(static_cast<std::size_t>(photo));
    return std::move(simulation_);
  }

 private:
  static constexpr double kHeight = 1530, kScale = 1e4;
  double Side() const { return 0.230 * kScale; }
  double Base() const { return Side() * (1 - options_.forward_overlap); }
  double StripStep() const { return Side() * (1 - options_.side_overlap); }
  double Normal(double sigma) { return sigma * normal_(random_); }
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double GroundHeight(double x, double y) const {
    return 200 + options_.relief_m * std::sin(x / 700) * std::cos(y / 900);
  }
  static constexpr double kEast = 500000, kNorth = 5000000;

  void MakePhotos() {
    for (int strip = 0; strip < options_.strips; ++strip)
      for (int k = 0; k < options_.photos_in_strip; ++k) {
        Pose pose;
        pose.position_m = {kEast + k * Base() + Normal(20),
                           kNorth + strip * StripStep() + Normal(20), 200 + kHeight + Normal(15)};
        pose.opk_rad = {Normal(0.02), Normal(0.02),
                        (strip % 2 == 0 ? 0.0 : 3.14159) + Normal(0.02)};
        AddPhoto(pose, strip, k);
      }
  }

  void AddPhoto(const Pose& pose, int strip, int number) {
    block::BlockPhoto photo;
    photo.name = "s" + std::to_string(strip) + "_" + std::to_string(number);
    photo.strip = "s" + std::to_string(strip);
    photo.photo_from_pixel.A << 0.025, 0, 0, -0.025;
    photo.photo_from_pixel.t << -115, 115;
    Vector6d sigma;
    sigma << Eigen::Vector3d::Constant(options_.position_sigma_m),
        Eigen::Vector3d::Constant(options_.attitude_sigma_rad);
    Vector6d off;
    for (int i = 0; i < 6; ++i) off[i] = Normal(sigma[i]);
    photo.approximate = Pose::FromVector(pose.AsVector() + off);
    if (options_.prior) photo.prior = PosePrior{photo.approximate, sigma.cwiseAbs2().asDiagonal()};
    if (options_.gnss_sigma_m > 0)
      photo.gnss = GnssPosition{
          pose.position_m + options_.gnss_shift_m +
              Eigen::Vector3d(Normal(options_.gnss_sigma_m), Normal(options_.gnss_sigma_m),
                              Normal(options_.gnss_sigma_m)),
          Eigen::Matrix3d::Identity() * std::pow(options_.gnss_sigma_m, 2),
          2.0 * number / std::max(options_.photos_in_strip - 1, 1) - 1};
    true_film_.push_back(photo.photo_from_pixel);
    if (options_.interior_sigma_mm > 0) {
      Vector6d film;
      const double slope = options_.interior_sigma_mm / 4600;
      film << slope, slope, slope, slope, 3 * options_.interior_sigma_mm,
          3 * options_.interior_sigma_mm;
      photo.interior = film.cwiseAbs2().asDiagonal();
      true_film_.back().A +=
          (Eigen::Matrix2d() << Normal(slope), Normal(slope), Normal(slope), Normal(slope))
              .finished();
      true_film_.back().t += Eigen::Vector2d(Normal(film[4]), Normal(film[5]));
    }
    simulation_.block.photos.push_back(photo);
    simulation_.true_poses.push_back(pose);
  }

  // Adds the observation of the point in `photo`; false if the photo does not show it.
  bool Observe(std::size_t photo, std::size_t point, double gross_share) {
    const Pose& pose = simulation_.true_poses[photo];
    const Eigen::Vector3d& ground = simulation_.true_ground[point];
    if ((ground - pose.position_m).head<2>().lpNorm<Eigen::Infinity>() > Side()) return false;
    const auto seen = PhotoFromGround(simulation_.true_camera, pose, ground);
    if (!seen || !simulation_.true_camera.InFrame(*seen, -3)) return false;
    block::ImageObservation o;
    o.photo = photo;
    o.point = point;
    o.pixel = true_film_[photo].Inverse() * *seen +
              Eigen::Vector2d(Normal(options_.noise_px), Normal(options_.noise_px));
    o.covariance_px2 *= options_.stated_px * options_.stated_px;
    const bool gross = Uniform(0, 1) < gross_share;
    if (gross) {
      const double angle = Uniform(0, 6.2832), length = Uniform(6, 60);
      o.pixel += length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    simulation_.block.observations.push_back(o);
    simulation_.gross.push_back(gross);
    return true;
  }

  std::size_t NewPoint(const Eigen::Vector2d& place) {
    simulation_.true_ground.emplace_back(place.x(), place.y(),
                                         GroundHeight(place.x() - kEast, place.y() - kNorth));
    block::BlockPoint point;
    point.id = static_cast<std::int64_t>(simulation_.true_ground.size());
    simulation_.block.points.push_back(point);
    return simulation_.true_ground.size() - 1;
  }

  void AddTie() {
    const std::size_t point = NewPoint(
        {kEast + Uniform(-Side() / 2, (options_.photos_in_strip - 1) * Base() + Side() / 2),
         kNorth + Uniform(-Side() / 2, (options_.strips - 1) * StripStep() + Side() / 2)});
    for (const std::size_t photo : Near(simulation_.true_ground[point]))
      if (Uniform(0, 1) < 0.9) Observe(photo, point, options_.gross_ties);
  }

  // Photos that may show the point, in order, so that not all of a large block are tried.
  std::vector<std::size_t> Near(const Eigen::Vector3d& ground) const {
    std::vector<std::size_t> near;
    const double k = (ground.x() - kEast) / Base(), s = (ground.y() - kNorth) / StripStep();
    for (int strip = static_cast<int>(s) - 2; strip <= static_cast<int>(s) + 2; ++strip)
      for (int i = static_cast<int>(k) - 3; i <= static_cast<int>(k) + 3; ++i)
        if (strip >= 0 && strip < options_.strips && i >= 0 && i < options_.photos_in_strip)
          near.push_back(static_cast<std::size_t>(strip * options_.photos_in_strip + i));
    return near;
  }

  void AddControl(std::size_t photo) {
    const Eigen::Vector2d centre = simulation_.true_poses[photo].position_m.head<2>();
    const double reach = 0.42 * Side();
    const std::size_t point =
        NewPoint(centre + Eigen::Vector2d(Uniform(-reach, reach), Uniform(-reach, reach)));
    block::GroundControl control;
    control.source = "old";
    const Eigen::Vector3d sigma(options_.control_ground_m, options_.control_ground_m,
                                options_.control_height_m);
    control.covariance_m2 = sigma.cwiseAbs2().asDiagonal();
    control.ground_m = simulation_.true_ground[point] +
                       Eigen::Vector3d(Normal(sigma.x()), Normal(sigma.y()), Normal(sigma.z()));
    if (options_.height_sigma_m > 0) AddHeightError(&control);
    AddSharedError(&control);
    if (options_.source_sigma_m > 0) DisplaceSource(&control);
    simulation_.block.points[point].control = control;
    if (!options_.control_seen_by_all) {
      Observe(photo, point, options_.gross_control);
      return;
    }
    for (const std::size_t other : Near(simulation_.true_ground[point]))
      Observe(other, point, options_.gross_control);
  }

  // Half of the variance is common to the source, half to points within some 500 m: a smooth random
  // field (a sum of waves), independent of the model of the adjustment. Points move along the line
  // of sight of their source.
  void AddHeightError(block::GroundControl* control) {
    if (waves_.empty()) {
      common_height_ = normal_(random_);
      for (int i = 0; i < 30; ++i)
        waves_.push_back({Normal(1.0 / 500), Normal(1.0 / 500), Uniform(0, 6.2832)});
    }
    double field = 0;
    for (const Eigen::Vector3d& wave : waves_)
      field +=
          std::sqrt(2.0 / 30) * std::cos(wave.x() * (control->ground_m.x() - kEast) +
                                         wave.y() * (control->ground_m.y() - kNorth) + wave.z());
    control->height_effect = {0.2, -0.1, 1};
    control->height_sigma_m = options_.height_sigma_m;
    control->ground_m += control->height_effect * options_.height_sigma_m * std::sqrt(0.5) *
                         (common_height_ + field);
  }

  // A shift, and its linear change towards the border of the block.
  void DisplaceSource(block::GroundControl* control) {
    if (source_error_.isZero())
      for (double& element : source_error_.reshaped()) element = Normal(options_.source_sigma_m);
    const Eigen::Vector2d half((options_.photos_in_strip - 1) * Base() / 2,
                               (options_.strips - 1) * StripStep() / 2);
    const Eigen::Vector2d place =
        control->ground_m.head<2>() - Eigen::Vector2d(kEast, kNorth) - half;
    control->ground_m.head<2>() += source_error_ * (place / half.maxCoeff()).homogeneous();
    control->source_sigma_m = options_.source_sigma_m;
  }

  // A constant, and a sum of waves over the ground with the correlation exp(-(d / 500 m)^2).
  void AddSharedError(block::GroundControl* control) {
    if (options_.control_shared_everywhere <= 0 && options_.control_shared_smoothly <= 0) return;
    if (shared_waves_.empty()) {
      for (double& everywhere : shared_everywhere_) everywhere = normal_(random_);
      for (int i = 0; i < 60; ++i)
        shared_waves_.push_back(
            {Normal(std::sqrt(2.0) / 500), Normal(std::sqrt(2.0) / 500), Uniform(0, 6.2832)});
    }
    const double sigma =
        std::hypot(options_.control_ground_m, options_.noise_px * simulation_.gsd_m);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      double field = 0;
      for (std::size_t i = axis; i < 60; i += 2) {
        const Eigen::Vector3d& wave = shared_waves_[i];
        field +=
            std::sqrt(2.0 / 30) * std::cos(wave.x() * (control->ground_m.x() - kEast) +
                                           wave.y() * (control->ground_m.y() - kNorth) + wave.z());
      }
      control->ground_m[static_cast<int>(axis)] +=
          sigma * (options_.control_shared_everywhere * shared_everywhere_.at(axis) +
                   options_.control_shared_smoothly * field);
    }
  }

  BundleSimulationOptions options_;
  std::vector<Eigen::Vector3d> waves_, shared_waves_;
  std::array<double, 2> shared_everywhere_ = {};
  double common_height_ = 0;
  Eigen::Matrix<double, 2, 3> source_error_ = Eigen::Matrix<double, 2, 3>::Zero();
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::vector<Affine2d> true_film_;
  BundleSimulation simulation_;
};

inline BundleSimulation SimulateBundle(const BundleSimulationOptions& options = {}) {
  return BundleSimulator(options).Make();
}

}  // namespace orient

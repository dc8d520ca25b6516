#include "tools/report/figures/adjustment_figures.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/chi_square.h"
#include "core/base/median.h"

namespace orient {
namespace {

void Count(const std::vector<PointResult>& points, bool ties, SightingsByPhoto* photos) {
  for (const PointResult& point : points)
    for (const SightingResult& sighting : point.seen) {
      PhotoSightings& photo = (*photos)[sighting.photo];
      const bool used = sighting.state == "used";
      ++(ties ? photo.ties : photo.control);
      if (!used) continue;
      ++(ties ? photo.ties_used : photo.control_used);
      if (sighting.residual_px) photo.squares_px2 += sighting.residual_px->squaredNorm();
      photo.redundancy += sighting.redundancy.value_or(0);
      photo.largest_w = std::max(photo.largest_w, sighting.w.value_or(0));
    }
}

}  // namespace

std::optional<double> PhotoSightings::RmsPx() const {
  if (Used() == 0) return std::nullopt;
  return std::sqrt(squares_px2 / Used());
}

std::optional<double> PhotoSightings::MeanRedundancy() const {
  if (Used() == 0) return std::nullopt;
  return 0.5 * redundancy / Used();
}

SightingsByPhoto SightingsOf(const AdjustmentResult& adjusted) {
  SightingsByPhoto photos;
  Count(adjusted.ties, true, &photos);
  Count(adjusted.control, false, &photos);
  return photos;
}

WorstPhotos WorstOf(const SightingsByPhoto& photos) {
  WorstPhotos worst;
  double w = -1, rms_px = -1;
  for (const auto& [name, photo] : photos) {
    if (photo.Used() == 0) continue;
    if (photo.largest_w > w) worst.by_w = name;
    if (*photo.RmsPx() > rms_px) worst.by_rms = name;
    w = std::max(w, photo.largest_w);
    rms_px = std::max(rms_px, *photo.RmsPx());
  }
  return worst;
}

int TiesInThreePhotosOrMore(const AdjustmentResult& adjusted) {
  return static_cast<int>(std::count_if(adjusted.ties.begin(), adjusted.ties.end(),
                                        [](const PointResult& tie) { return tie.rays >= 3; }));
}

std::optional<double> SigmaOverStated(const ComponentResult& component) {
  if (!component.factor) return std::nullopt;
  return std::sqrt(*component.factor);
}

std::optional<double> ImageSigmaPx(const ComponentResult& component) {
  return component.sigma0_px.value_or(0) > 0 ? component.sigma0_px : std::nullopt;
}

void GroundResiduals::Add(const Eigen::Vector3d& residual_m) {
  squares_ += residual_m.cwiseAbs2();
  ++count_;
}

Eigen::Vector3d GroundResiduals::Rms_m() const { return (squares_ / count_).cwiseSqrt(); }

double GroundResiduals::Ce90_m() const { return kCircularError90 * Rms_m().head<2>().mean(); }

double GroundResiduals::Le90_m() const { return kLinearError90 * Rms_m().z(); }

GroundResiduals ResidualsOfChecks(const AdjustmentResult& adjusted) {
  GroundResiduals residuals;
  for (const CheckResult& check : adjusted.checks)
    if (check.ground_residual_m) residuals.Add(*check.ground_residual_m);
  return residuals;
}

GroundResiduals ResidualsOfControl(const AdjustmentResult& adjusted) {
  GroundResiduals residuals;
  for (const PointResult& point : adjusted.control)
    if (point.control && point.control->state == "used" && point.control->residual_m)
      residuals.Add(*point.control->residual_m);
  return residuals;
}

GroundResiduals ResidualsOfGnss(const AdjustmentResult& adjusted) {
  GroundResiduals residuals;
  for (const PoseObservationResult& position : adjusted.gnss)
    if (position.state == "used" && position.residual_m) residuals.Add(*position.residual_m);
  return residuals;
}

CheckSightings SightingsOfChecks(const AdjustmentResult& adjusted) {
  std::vector<double> lengths;
  for (const CheckResult& check : adjusted.checks)
    for (const Eigen::Vector2d& residual : check.image_residuals_px)
      lengths.push_back(residual.norm());
  CheckSightings sightings;
  sightings.count = static_cast<int>(lengths.size());
  if (!lengths.empty()) sightings.median_px = Median(std::move(lengths));
  return sightings;
}

}  // namespace orient

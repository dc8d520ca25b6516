// What a block adjustment amounts to, in figures: of one photo, of check and control points, of
// GNSS. The report's page and report.json show the same ones.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>

#include "core/files/adjustment_result.h"

namespace orient {

// Sightings of ties and control patches in one photo: how many there are and what they are worth.
struct PhotoSightings {
  int ties = 0, ties_used = 0, control = 0, control_used = 0;
  double squares_px2 = 0;  // of used ones' residuals
  double redundancy = 0;   // of used ones, of both coordinates
  double largest_w = 0;    // residual over its standard deviation

  int Used() const { return ties_used + control_used; }
  // Of both coordinates, and per coordinate (0 to 1); empty where nothing is used.
  std::optional<double> RmsPx() const;
  std::optional<double> MeanRedundancy() const;
};

using SightingsByPhoto = std::map<std::string, PhotoSightings>;

SightingsByPhoto SightingsOf(const AdjustmentResult& adjusted);

// The photos with the largest w and the largest RMS; empty names where nothing is used.
struct WorstPhotos {
  std::string by_w, by_rms;
};
WorstPhotos WorstOf(const SightingsByPhoto& photos);

int TiesInThreePhotosOrMore(const AdjustmentResult& adjusted);

// sigma / stated sigma of a group of observations; empty where it was not determined.
std::optional<double> SigmaOverStated(const ComponentResult& component);

// Of an observation in the photo, px; empty for groups of other observations.
std::optional<double> ImageSigmaPx(const ComponentResult& component);

// Residuals on the ground, m, X Y Z. CE90 and LE90 as of normal errors (NSSDA: 2.1460 times the
// mean RMS of X and Y, 1.6449 times that of Z).
class GroundResiduals {
 public:
  void Add(const Eigen::Vector3d& residual_m);
  int Count() const { return count_; }
  Eigen::Vector3d Rms_m() const;  // only where there are any, as all that follow
  double Ce90_m() const;
  double Le90_m() const;

 private:
  Eigen::Vector3d squares_ = Eigen::Vector3d::Zero();
  int count_ = 0;
};

// Check patches seen in two photos or more; control patches that are used; GNSS positions that are
// used.
GroundResiduals ResidualsOfChecks(const AdjustmentResult& adjusted);
GroundResiduals ResidualsOfControl(const AdjustmentResult& adjusted);
GroundResiduals ResidualsOfGnss(const AdjustmentResult& adjusted);

// Observations of check patches: how many, and the median length of their residuals, px.
struct CheckSightings {
  int count = 0;
  std::optional<double> median_px;
};
CheckSightings SightingsOfChecks(const AdjustmentResult& adjusted);

}  // namespace orient

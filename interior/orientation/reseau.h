// A réseau: a dense grid of crosses with calibrated positions. They show how the film
// has deformed since the exposure, beyond the affine part, and give a smooth local correction.
//
// Least-squares collocation (Moritz 1972; universal kriging): what the affine leaves at the crosses
// is an affine trend, a smooth signal with a Matern covariance (smoothness 5/2) common to both
// coordinates, and noise. Signal, correlation length and noise come from the photo's own crosses by
// restricted maximum likelihood, so a film that is flat gets no correction and noisy crosses are
// smoothed. Leave-one-out residuals and their sigmas come out in closed form: for the residual
// projector P of the trend, residual_i = (P y)_i / P_ii and sigma_i^2 = 1 / P_ii.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/film_correction.h"
#include "interior/constellation/layout.h"
#include "interior/orientation/film_transform.h"

namespace orient::interior {

struct ReseauFit {
  FilmCorrection correction;  // over the crosses' rectangle
  double signal_um = 0;       // one sigma of a coordinate
  double correlation_mm = 0;  // over which the signal changes
  double noise_um = 0;        // of a cross's coordinate
  // Per mark: where the others put it, and how surely (a coordinate), photo system.
  std::vector<Eigen::Vector2d> left_out_um;
  std::vector<double> left_out_sigma_um;
  std::vector<bool> used;      // contradicted crosses are left out of the correction
  double left_out_rms_um = 0;  // of the used ones' vectors
};

// Empty below kLeastReseauMarks marks or where they do not spread over an area. `photo_from_pixel`
// is the affine that the correction is to be added to. A cross is contradicted where its
// leave-one-out chi-square (two degrees of freedom) exceeds 20; up to 40 % may be. Empty also where
// the crosses' noise comes out above 40 um: then nothing is explained.
std::optional<ReseauFit> FitReseau(const std::vector<MeasuredMark>& marks,
                                   const Affine2d& photo_from_pixel);

}  // namespace orient::interior

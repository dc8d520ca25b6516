// What estimators of one pose take from observations that share errors: fewer of them, and how the
// height errors under any two go together. Internal to exterior.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "exterior/steps/observation.h"

namespace orient::exterior {

// Neighbours of one source together, so that there are at most 250 groups; by their numbers. More
// would share their errors and take time with the cube of their number.
std::vector<std::vector<std::size_t>> Grouped(const std::vector<PatchObservation>& all);

// How the part of height errors not common to all decorrelates with distance: over `length_m`, as
// survey and datum errors do, or over a fifth of it, as errors of a DEM too coarse for its terrain.
enum class HeightFading { kLong, kShort };

// Correlation of the height errors under any two observations, each twice for col and row.
Eigen::MatrixXd HeightCorrelation(const std::vector<PatchObservation>& observations,
                                  HeightFading fading, double length_m);

// Covariance of the film's deformation at any two observations, the same in col and row.
Eigen::MatrixXd FilmCovariance(const std::vector<PatchObservation>& observations,
                               const CommonErrors& common);

}  // namespace orient::exterior

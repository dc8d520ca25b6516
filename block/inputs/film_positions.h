// How a film may lie on its scan, and how well that is known: from interior to exterior
// orientation.
#pragma once

#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "exterior/orient_photo.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {

// Sigma of a good film's deformation between its marks, scanned as well, mm.
inline constexpr double kFilmSigma_mm = 0.003;

// Covariance of an affine transform from few marks, whose residuals have few degrees of freedom:
// combined with prior knowledge, the sigma of a coordinate in units of the fit's sigma0.
Matrix6d PooledCovariance(const TransformFit& fit, double prior_sigma);

// Sigma of the film's smooth deformation between its marks: a good film's, and what the marks'
// residuals show beyond what their own errors explain, as those of films on desktop scanners and of
// prints do. `unit_mm`: of the fit's sigma0.
double FilmSigma_mm(const TransformFit& fit, double prior_sigma, double unit_mm);

// One position, or those that interior orientation left open; the likeliest first. The result must
// have a transform.
std::vector<exterior::FilmPosition> FilmPositions(const InteriorResult& result,
                                                  const CameraFile& camera,
                                                  const interior::MarkShapes& marks);

}  // namespace orient::block

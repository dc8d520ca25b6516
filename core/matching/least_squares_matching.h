// Least-squares matching: where, to a small fraction of a pixel, a template lies in an image.
//
// Gruen (1985), Foerstner (1982): image(T(p)) = r0 + r1 * template(p) + noise, with T a shift, a
// similarity or an affinity around the template's reference point, linearised and iterated. Grey
// values between pixels come from an interpolating bicubic spline, gradients of the observation
// equations from the template: neither whole nor half pixels attract a match.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/geometry/transform2d.h"
#include "core/raster/image.h"

namespace orient {

enum class LsmGeometry { kShift, kSimilarity, kAffine };

// One sigma along an edge, where the match is undetermined: practically no information.
inline constexpr double kOpenAlongEdge_px = 50;

// The covariance of a match knows the grey values' noise only. Relief between the heights' nodes
// and change of the scene add what no single match can see: one sigma of a coordinate, scan pixels.
inline constexpr double kMatchModelSigma_px = 0.1;

struct LsmOptions {
  LsmGeometry geometry = LsmGeometry::kAffine;
  bool radiometric = true;  // estimate offset and gain
  int max_iterations = 30;
  double max_shift_px = 5;       // of the reference point from its start; beyond: no match
  double max_deformation = 0.3;  // Frobenius norm of A - start.A; beyond: no match
  // kShift only: a template with texture in one direction only (an edge) matches, too, across it;
  // so does any template that cannot be matched in both directions, across its weaker one.
  bool edges = false;
};

struct LsmResult {
  // image_from_template, both in pixels of their own image (corner convention).
  Affine2d image_from_template;
  Eigen::Vector2d position;  // of the reference point, image pixels
  // Of that position, px^2: sigma0^2 times the inverse normal matrix, enlarged for what the noise
  // adds to the gradients. True for white noise of independent images.
  Eigen::Matrix2d covariance;
  // Of such a match, the direction that is left open (length 1): along it the position is the
  // start's, and the covariance says that nothing is known.
  std::optional<Eigen::Vector2d> along;
  double offset = 0, gain = 1;  // image = offset + gain * template
  double correlation = 0;       // at the solution
  double sigma0 = 0;            // of a grey value, units of the image
  int iterations = 0;
};

// `reference` is the point of interest in the template (usually its centre); `start` is the first
// image_from_template. NaN pixels of either side take no part. Empty when it diverges, leaves the
// image, is flat or singular (an edge fixes one direction only; see `edges`), does not converge, or
// correlates no better than chance. Judge by `correlation` whether it is the same object. Throws
// std::invalid_argument where the start is singular or not finite.
std::optional<LsmResult> MatchLeastSquares(const Image& templ, const Image& image,
                                           const Eigen::Vector2d& reference, const Affine2d& start,
                                           const LsmOptions& options = {});

}  // namespace orient

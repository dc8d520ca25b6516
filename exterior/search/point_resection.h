// A photo's pose from ground points that a person measured in it: wrong ones are found and named,
// and never part of the pose.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/files/finding.h"
#include "exterior/search/measured_point.h"
#include "exterior/steps/photo_to_orient.h"

namespace orient::exterior {

struct PointResection {
  std::optional<PointPose> found;  // empty: the only finding says why
  Findings findings;               // wrong points by name
  bool with_prior = false;         // the prior is in the pose
};

// At least four points, five to find a wrong one; with `prior` three and four. The prior is used
// only if the points alone do not determine which of them are wrong. Sets of points are
// tested as a whole and point by point (chi-square, each rejects one correct set in 10 000): among
// many, one wrong point hardly shows in the whole. If several pass with equally many left out, the
// best is taken if it is beyond doubt, otherwise none.
PointResection ResectByPoints(const Camera& camera, const std::vector<FilmPosition>& positions,
                              const std::optional<PosePrior>& prior,
                              const std::vector<MeasuredPoint>& points);

// How many points make a photo ok without patches.
inline constexpr int kLeastPointsAlone = 6;

// For a pose from points alone, without patches: ok with enough points that check one another
// (`hidden_px`: HiddenDisplacement), at most a quarter of all named as `wrong`, and a pose precise
// to `target_px` all over the frame (`worst_sigma_px`); otherwise weak.
Finding JudgePointsAlone(int points, int wrong, double worst_sigma_px, double hidden_px,
                         double target_px);

// Which points do not fit a pose found by other means; absent: all of them fit.
std::optional<Finding> JudgePointsUnder(const PhotoView& view, const Matrix6d& covariance,
                                        const std::vector<MeasuredPoint>& points);

}  // namespace orient::exterior

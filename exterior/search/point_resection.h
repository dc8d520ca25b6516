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
  std::optional<PointPose> found;  // empty: why, is the only finding
  Findings findings;               // wrong points by name
  bool with_prior = false;         // the prior is in the pose
};

// Without `prior` four points at least; five, to find a wrong one. With it three, and four. It is
// asked only where the points alone do not tell which of them are wrong. Sets of points are
// tested as a whole and point by point (chi-square, one right set in ten thousand by either): among
// many, one wrong point hardly shows in the whole. Of several that pass without so many points, the
// best is taken if it is beyond doubt, and none otherwise.
PointResection ResectByPoints(const Camera& camera, const std::vector<FilmPosition>& positions,
                              const std::optional<PosePrior>& prior,
                              const std::vector<MeasuredPoint>& points);

// How many points make a photo ok without patches.
inline constexpr int kLeastPointsAlone = 6;

// By points alone, where no patch tells more: ok with enough of them that check one another
// (`hidden_px`: HiddenDisplacement), at most a quarter of all named as `wrong`, and a pose precise
// to `target_px` all over the frame (`worst_sigma_px`); otherwise weak.
Finding JudgePointsAlone(int points, int wrong, double worst_sigma_px, double hidden_px,
                         double target_px);

// Which points lie elsewhere under a pose found by other means; absent: none does.
std::optional<Finding> JudgePointsUnder(const PhotoView& view, const Matrix6d& covariance,
                                        const std::vector<MeasuredPoint>& points);

}  // namespace orient::exterior

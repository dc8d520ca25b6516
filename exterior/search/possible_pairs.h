// Which of a photo's keypoints may show which of the chips', by what is known before any descriptor
// is compared: sizes give the scale, directions give kappa, and with it the stated accuracy gives
// where a chip's keypoint may lie. Private to exterior.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/terrain/photo_view.h"
#include "exterior/search/keypoint_pairs.h"

namespace orient::exterior {

class PossiblePairs {
 public:
  // `gsd_m`: of a scan pixel as approximated; `scale_reach`: the factor by which it may be wrong.
  // Refers to both. Throws std::invalid_argument unless the photo's come in ascending size.
  PossiblePairs(const Keypoints& photo, const ChipKeypoints& chips, double gsd_m,
                double scale_reach);

  // Admits only pairs whose directions imply a kappa within `kappa_reach_rad` of the view's, and
  // which lie, under that kappa, within `reach_mm` of where the view's position, omega and phi show
  // them. After several calls, passing one suffices. `reach_mm`: of a point, photo coordinates.
  void LetPassNear(const PhotoView& view, const FilmPosition& position, double kappa_reach_rad,
                   const std::function<double(const Eigen::Vector2d&)>& reach_mm);

  // Indices, ascending, of the photo's keypoints that may show this keypoint of a chip.
  std::vector<std::size_t> Of(std::size_t chip_keypoint) const;

 private:
  // A pair's kappa is the difference of two angles. With each side turned back by its own one,
  // about the principal point, what belongs together lies at one place whatever kappa is.
  struct Places {
    Eigen::ArrayX2f of_photo, of_chips;              // mm
    Eigen::ArrayX2f turns_of_photo, turns_of_chips;  // as unit vectors, from the view's kappa
    float least_cosine = -1;                         // between them
    std::vector<float> reach_mm;                     // negative: not seen
  };

  // For each of some of the photo's keypoints, by how much it stays within the limits for this one
  // of a chip, negative where it exceeds them.
  Eigen::ArrayXf MarginsIn(const Places& places, Eigen::Index chip, Eigen::Index first,
                           Eigen::Index count) const;

  const Keypoints& photo_;
  const ChipKeypoints& chips_;
  double gsd_m_, scale_reach_;
  std::vector<Places> places_;
};

}  // namespace orient::exterior

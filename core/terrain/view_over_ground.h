// A photo and the ground under it: heights there, and poses that show the same ground.
#pragma once

#include <optional>
#include <vector>

#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient {

// Heights of the ground all over the frame, 13 by 13 rays: none where the surface has a hole.
// Metres.
std::vector<double> HeightsInFrame(const GroundSurface& surface, const Camera& camera,
                                   const Pose& pose);

// Share of 40 by 40 places all over the frame whose rays meet the surface; rays at the
// horizon or above are not counted. The remaining rays miss the surface or meet a hole in it.
double ShareWithHeights(const GroundSurface& surface, const Camera& camera, const Pose& pose);

// Height of the ground where the photo's axis meets it, else below the photo, else the median of
// the frame's heights; the surface's mean only where the frame has none. Metres.
double GroundHeightUnder(const GroundSurface& surface, const Camera& camera, const Pose& pose);

// A point of the photo and level ground that it shows.
struct SeenPlace {
  Eigen::Vector2d photo_mm;
  Eigen::Vector3d ground_m;
};

// Level ground at `height_m` as the frame shows it, six by six places; without those where the ray
// does not point down.
std::vector<SeenPlace> PlacesInFrame(const Camera& camera, const Pose& pose, double height_m);

// The same in the frame's corners, the middles of its sides and its middle; without those at the
// horizon or above.
std::vector<SeenPlace> OutermostInFrame(const Camera& camera, const Pose& pose, double height_m);

// The pose with which another camera and film position (`with`, whose pose is where the search
// begins) show level ground at `height_m` where `view` does, by least squares over the frame. Empty
// where either does not see that ground.
std::optional<Pose> PoseShowingTheSame(const PhotoView& view, const PhotoView& with,
                                       double height_m);

}  // namespace orient

// The marks of a camera as one constellation: where each may lie on the scan, and which of the
// eight scan orientations the constellation alone can tell apart.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/files/camera_file.h"
#include "core/geometry/transform2d.h"
#include "core/raster/raster.h"
#include "interior/constellation/film_frame.h"
#include "interior/marks/mark_drawing.h"

namespace orient::interior {

// Fewer crosses than this are fiducial marks, and no réseau.
inline constexpr int kLeastReseauMarks = 16;

// Centre and size of the rectangle around all marks, mm, photo system.
struct MarkRectangle {
  Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_mm = Eigen::Vector2d::Zero();
};
MarkRectangle RectangleOfMarks(const std::vector<Fiducial>& fiducials);

// Where a mark would lie were the film lying in `orientation`, relative to the rectangle's centre,
// in mm along the scan's columns and rows.
Eigen::Vector2d PlaceOnScan(const Eigen::Vector2d& photo_mm, const MarkRectangle& rectangle,
                            ScanOrientation orientation);

// How the photo coordinates of a place on the scan change when the film is taken to lie in `other`
// and not in `base`: about the rectangle's centre, other = PhotoTurn * base.
Eigen::Matrix2d PhotoTurn(ScanOrientation base, ScanOrientation other);

// relabel[i] is the index of the mark that lies where mark i would lie, were the film lying in
// `other` and not in `base`. Empty when the layout or a mark's drawing shows the difference, even
// through a scanner whose two scales differ by 2.5 %. Pictures of marks show none: what differs in
// them may be the photo that they were cut from.
std::optional<std::vector<int>> Relabel(const std::vector<Fiducial>& fiducials,
                                        const MarkShapes& shapes, ScanOrientation base,
                                        ScanOrientation other);

// The same for a scan orientation that is known to look alike: the nearest places, drawings unseen.
std::vector<int> RelabelAlike(const std::vector<Fiducial>& fiducials, ScanOrientation base,
                              ScanOrientation other);

// The same for a scan orientation in which layout or drawings differ; -1 for a mark that would have
// no place there.
std::vector<int> RelabelInCommon(const std::vector<Fiducial>& fiducials, ScanOrientation base,
                                 ScanOrientation other);

// Scan orientations that look the same in a search, the unmirrored first; the first one stands for
// its class. Pictures of marks count by their looks here: they are searched for as they would lie.
using OrientationClass = std::vector<ScanOrientation>;
std::vector<OrientationClass> OrientationClasses(const std::vector<Fiducial>& fiducials,
                                                 const MarkShapes& shapes);

// All scan orientations that the marks cannot tell from this one, which comes first.
OrientationClass IndistinguishableOrientations(const std::vector<Fiducial>& fiducials,
                                               const MarkShapes& shapes,
                                               ScanOrientation orientation);

// How far the layout departs from looking the same in all orientations of a class, relative to the
// first one (maximum over its members): RMS coordinate residual after an affine fit, and the
// difference of scales, or the shear, of that affine.
struct LayoutDeparture {
  double point_mm = 0;
  double affinity = 0;
};
LayoutDeparture DepartureOf(const std::vector<Fiducial>& fiducials,
                            const OrientationClass& orientations);

inline constexpr double kSmallestWindowMm = 15.0;

// Jiang's search range: the rectangle of all marks, moved along the scan's border, bounds where
// each mark can be. With pixel size p, the scan's extent A and the rectangle's extent a:
// place / p + A/2 +- (|A - a/p|/2 + slack), at least 15 mm wide. `slack_mm` takes up what the pixel
// size, turns of the film and its deformation may add.
// `region` is where the film lies: the scan, or a part of a larger bed.
PixelWindow SearchWindow(const Eigen::Vector2d& place_mm, const Eigen::Vector2d& rectangle_mm,
                         const Eigen::Vector2i& scan_px, const ScanRegion& region,
                         double pixel_size_mm, double slack_mm);
PixelWindow SearchWindow(const Eigen::Vector2d& place_mm, const Eigen::Vector2d& rectangle_mm,
                         const Eigen::Vector2i& scan_px, double pixel_size_mm, double slack_mm);

}  // namespace orient::interior

// How ground points measured by a person are used in a photo's orientation: as a start for its
// search, as its pose if patches give none, and to check the pose found.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "block/inputs/scan_interior.h"
#include "block/pictures/scan_overview.h"
#include "block/stages/exterior_setting.h"
#include "core/files/results.h"
#include "exterior/search/point_resection.h"
#include "exterior/steps/photo_to_orient.h"

namespace orient::block {

// What starts a photo's search: its approximation, or its measured ground points.
struct PointStart {
  std::optional<PosePrior> prior = {};
  std::optional<PosePrior> approximation = {};         // as given, whatever the points say
  std::optional<exterior::PointPose> by_points = {};   // unless what was found contradicts it
  bool by_points_began = false;                        // the search for patches started from them
  std::vector<exterior::FilmPosition> positions = {};  // all that the marks leave open
  std::vector<exterior::MeasuredPoint> points = {};    // control and check points measured in it
  Findings findings = {};                              // of the points
  bool stated = false;                                 // the prior's accuracy
  bool approximation_is_stated = false;
};

// The position of the film in which a photo was oriented; the first where none is that one.
const exterior::FilmPosition& PositionAs(const std::vector<exterior::FilmPosition>& positions,
                                         const std::optional<ScanOrientation>& orientation);

// With a pose by points, of the positions of the film only that one is left; all of them where the
// points were measured in the photo system, which does not tell the position.
PointStart StartOf(const ExteriorSetting& setting, const std::string& name,
                   const std::optional<PosePrior>& approximation, bool stated,
                   ScanInterior* interior);

// Starts from the approximation, which must be there, and uses none of the points.
void DropPoints(PointStart* start, ScanInterior* interior);

// The photo's pose by its measured points, where patches gave none: `start` has one. `result`: what
// was tried. Weak, too, where the approximation's stated accuracy or the DEM contradict it.
void OrientByPoints(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                    const PointStart& start, ExteriorResult* result);

// Adds findings on how the photo's measured points fit its pose.
void CompareWithPoints(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                       const PointStart& start, ExteriorResult* result);

// Whether most of the photo's control points do not fit the pose that was found.
bool PointsContradict(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                      const PointStart& start, const ExteriorResult& found);

// Where they were clicked: those that start the search are used, the others rejected.
std::vector<OverviewItem> ClickedPoints(const PointStart& start);

}  // namespace orient::block

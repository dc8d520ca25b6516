// One simulated photo from its plan to its scan.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "tools/simulate/block_layout.h"
#include "tools/simulate/cameras.h"
#include "tools/simulate/film_drawing.h"
#include "tools/simulate/ground_raster.h"
#include "tools/simulate/scan_geometry.h"
#include "tools/simulate/scanner.h"
#include "tools/simulate/terrain.h"

namespace orient::simulation {

// How one photo's film was scanned.
struct PhotoPlan {
  PlannedPhoto photo;
  ScanGeometry scan;
  Polarity polarity = Polarity::kPositive;
  std::vector<MarkCondition> marks;  // one a fiducial
  std::uint32_t seed = 1;
};

// Draws the scan's accidents (turn, shift, shrinkage, marks) from the seed. Old photos and digital
// ones lie as a digital frame does, old film straight and positive.
PhotoPlan PlanPhoto(const SimulationOptions& options, const SimulatedCamera& camera,
                    const PlannedPhoto& photo, bool old, int number);

// The film to be drawn for a plan, and the scanner settings for it.
FilmFrame FilmOf(const SimulatedCamera& camera, const PhotoPlan& plan);
ScannerOptions ScannerOf(const SimulationOptions& options, const PhotoPlan& plan);

// The scan's grey values, 0 to 255 or 0 to 65535.
std::vector<std::uint16_t> MakePhoto(const SimulationOptions& options,
                                     const SimulatedCamera& camera, const PhotoPlan& plan,
                                     const GroundRaster& ground, const Terrain& terrain);

// The truth in the form of an interior orientation's result.
InteriorResult TrueInterior(const SimulatedCamera& camera, const PhotoPlan& plan);

}  // namespace orient::simulation

// One interpretation of a scan: which candidate is which mark, in which scan orientation, at what
// pixel size and with what polarity; and what is known of the constellation beforehand.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "interior/constellation/assignment.h"
#include "interior/constellation/interior_options.h"
#include "interior/constellation/layout.h"

namespace orient::interior {

struct PixelSizeGuess {
  double pixel_mm = 0;
  double sigma = 0;  // relative
};

// What a scanner may do to the constellation. A photogrammetric one leaves 1.5e-4 of affinity and
// film a few hundredths of a millimetre; a desktop scanner or a print has scales that differ by up
// to 2.5 % and bends by a tenth. `free_mm`: how far the marks' rectangle can be from the scan's
// middle; `coarse_pixel_mm`: pixel size at which the candidates were found.
ConstellationPrior PriorOf(Scanner scanner, const PixelSizeGuess& pixel_size,
                           const Eigen::Vector2d& free_mm, double coarse_pixel_mm);

// Difference of the two scales, and shear, one sigma.
double PriorAffinity(Scanner scanner);

// A scan orientation that the marks' layout excludes, and by how many nats.
struct RivalOrientation {
  ScanOrientation orientation = ScanOrientation::kR0;
  double nats = 0;
};

// One reading of the scan. `marks` are in the order of the camera's fiducials.
struct FilmReading {
  PixelSizeGuess pixel_size;
  // Centre of the film on the scan: origin of the assignment's positions.
  Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
  OrientationClass orientations;
  // These, and those that only pictures of marks distinguish from them (layout.h,
  // IndistinguishableOrientations).
  OrientationClass alike;
  Polarity polarity = Polarity::kPositive;
  // As the class's scan orientations are not distinguished yet, with what their calibrated layouts
  // differ by.
  ConstellationPrior prior;
  Eigen::Vector2d free_mm = Eigen::Vector2d::Zero();  // of PriorOf
  double coarse_pixel_mm = 0;                         // of PriorOf
  double bend_mm = 0;                                 // added to a mark's scatter (reseau)
  Scanner scanner = Scanner::kDesktop;                // the one whose prior explains the marks best
  AssignmentMethod assignment = AssignmentMethod::kExact;
  std::vector<AssignmentMark> marks;
  std::vector<std::vector<MarkCandidate>> candidates;
  // Each mark's search window; zero width: not searched for. Empty: windows were not used.
  std::vector<PixelWindow> windows;
  Assignment best;
  Assignment second;   // AssignmentAnswer's
  bool proven = true;  // the search was complete; otherwise the margin is 0
  double margin = 0;   // nats to the second-best reading of any kind, "no marks at all" included
  // Nats to the same reading under the other scanner's prior where that one uses other marks: four
  // marks of a desktop scan, or a photogrammetric scan with one of them misplaced.
  double scanner_margin = std::numeric_limits<double>::infinity();
  // Nats to the most probable set of marks in the polarity that the user excluded; negative where
  // that one is more probable, infinite where there is none.
  double polarity_margin = std::numeric_limits<double>::infinity();
  // Reseau only: all that the anchors allow.
  std::vector<RivalOrientation> rival_orientations;
};

inline Polarity Opposite(Polarity polarity) {
  return polarity == Polarity::kPositive ? Polarity::kNegative : Polarity::kPositive;
}

// Nats to the nearest of the rival orientations; infinite where there are none.
double OrientationMargin(const FilmReading& reading);

// The prior of the reading's pixel size, range and bend, widened by the departure.
ConstellationPrior PriorIn(const FilmReading& reading, Scanner scanner,
                           const LayoutDeparture& departure);

// Sets best, proven and margin from the marks, their candidates and the prior. The margin of a set
// that softassign chose is that to the most probable other one: none where it missed this one.
void Assign(FilmReading* reading);

}  // namespace orient::interior

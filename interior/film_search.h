// Where on the scan is the constellation of marks, in which way does it lie, at what pixel size and
// with what polarity: the most probable of all readings, and by how much.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "interior/assignment.h"
#include "interior/interior.h"
#include "interior/layout.h"
#include "interior/locator.h"

namespace orient {

struct PixelSizeGuess {
  double pixel_mm = 0;
  double sigma = 0;  // relative
};

// From the user, else the resolution tag where it lets the marks fit on the scan, else a ladder of
// sizes at which the marks' rectangle fills 70 to 99 % of the scan.
std::vector<PixelSizeGuess> GuessPixelSize(const Eigen::Vector2i& scan_px,
                                           std::optional<double> dpi_tag,
                                           const MarkRectangle& rectangle,
                                           std::optional<double> pixel_size_um);

// What a scanner may do to the constellation. A photogrammetric one leaves 1.5e-4 of affinity and
// film a few hundredths of a millimetre; a desktop scanner or a print has scales that differ by up
// to 2.5 % and bends by a tenth. `free_mm`: how far the marks' rectangle can be from the scan's
// middle; `coarse_pixel_mm`: pixel size at which the candidates were found.
ConstellationPrior PriorOf(Scanner scanner, const PixelSizeGuess& pixel_size,
                           const Eigen::Vector2d& free_mm, double coarse_pixel_mm);

// Difference of the two scales, and shear, one sigma.
double PriorAffinity(Scanner scanner);

// One reading of the scan. `marks` are in the order of the camera's fiducials.
struct FilmReading {
  PixelSizeGuess pixel_size;
  // Centre of the film on the scan: origin of the assignment's positions.
  Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
  OrientationClass orientations;
  Polarity polarity = Polarity::kPositive;
  // As the class's ways of lying are not told apart yet, with what their calibrated layouts differ
  // by.
  ConstellationPrior prior;
  Eigen::Vector2d free_mm = Eigen::Vector2d::Zero();  // of PriorOf
  double coarse_pixel_mm = 0;                         // of PriorOf
  double bend_mm = 0;                                 // added to a mark's scatter (reseau)
  Scanner scanner = Scanner::kDesktop;                // the one whose prior explains the marks best
  std::vector<AssignmentMark> marks;
  std::vector<std::vector<MarkCandidate>> candidates;
  Assignment best;
  Assignment second;   // AssignmentAnswer's
  bool proven = true;  // the search was through; otherwise the margin is 0
  double margin = 0;   // nats to the second-best reading of any kind, "no marks at all" included
  // Nats to the same reading under the other scanner's prior where that one uses other marks: four
  // marks of a desktop scan, or a photogrammetric scan with one of them misplaced.
  double scanner_margin = std::numeric_limits<double>::infinity();
  // Nats to the nearest way of lying that the marks' layout excludes (reseau only).
  double orientation_margin = std::numeric_limits<double>::infinity();
};

// The prior of the reading's pixel size, range and bend, widened by the departure.
ConstellationPrior PriorIn(const FilmReading& reading, Scanner scanner,
                           const LayoutDeparture& departure);

// Sets best, proven and margin from the marks, their candidates and the prior.
void Assign(FilmReading* reading);

// How far from where a film in the scan's middle would have it a mark is looked for.
enum class SearchRange {
  kNearby,  // in 15 mm, as Kersten & Haering
  kWhole,   // wherever it can lie on the scan (Jiang)
};

// With `first` kNearby, and a stated pixel size, the reading of the nearby windows is taken where
// it is beyond all rivals: every mark found well inside its window, with 30 nats or more. Otherwise
// the whole range is read. Not for marks that a shift of the film carries into others (a reseau),
// nor where readings of several cameras are compared: rivals that are there count everywhere then.
//
// The best reading; with nothing found its assignment is all -1. Where the film lies on a bed much
// larger than it, or the whole scan shows no marks, the film is looked for first (FindFilmOnBed).
FilmReading ReadFilm(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                     const InteriorOptions& options, SearchRange first = SearchRange::kWhole);

// The same over the whole range, followed by what else the scan may say, the most probable first:
// readings of other settings, and every reading with its second assignment, as far as they say
// something else than those before them.
std::vector<FilmReading> ReadFilmAllWays(const Raster& scan, const CameraFile& camera,
                                         const MarkShapes& shapes, const InteriorOptions& options);

}  // namespace orient

// Where on the scan is the constellation of marks, in which way does it lie, at what pixel size and
// with what polarity: the most probable of all readings, and by how much.
#pragma once

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

// One reading of the scan. `marks` are in the order of the camera's fiducials.
struct FilmReading {
  PixelSizeGuess pixel_size;
  OrientationClass orientations;
  Polarity polarity = Polarity::kPositive;
  ConstellationPrior prior;
  Scanner scanner = Scanner::kDesktop;  // the one whose prior explains the marks best
  std::vector<AssignmentMark> marks;
  std::vector<std::vector<MarkCandidate>> candidates;
  Assignment best;
  bool proven = true;  // the search was through; otherwise the margin is 0
  double margin = 0;   // nats to the second-best reading of any kind, "no marks at all" included
};

// The best reading; with nothing found its assignment is all -1.
FilmReading ReadFilm(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                     const InteriorOptions& options);

}  // namespace orient

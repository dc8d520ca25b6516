// The constellation of marks on the scan, its scan orientation, pixel size and polarity: the most
// probable interpretation, and by how much.
#pragma once

#include <optional>
#include <vector>

#include "core/raster/raster.h"
#include "interior/constellation/film_reading.h"

namespace orient::interior {

// Whether all marks lie on a scan of such pixels (a side may be cut off a little), and not on a
// small part of it: otherwise a resolution tag is to be distrusted.
bool MarksFitScan(const Eigen::Vector2i& scan_px, const MarkRectangle& rectangle, double pixel_mm);

// From the user, else the resolution tag where it lets the marks fit on the scan, else a ladder of
// sizes at which the marks' rectangle fills 70 to 99 % of the scan.
std::vector<PixelSizeGuess> GuessPixelSize(const Eigen::Vector2i& scan_px,
                                           std::optional<double> dpi_tag,
                                           const MarkRectangle& rectangle,
                                           std::optional<double> pixel_size_um);

// Search range for a mark, around its place on a film centred on the scan.
enum class SearchRange {
  kNearby,  // in windows 15 mm wide, as Kersten & Haering
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

// The same over the whole range, followed by the alternative readings, the most probable first:
// readings of other settings, and every reading with its second assignment, as far as they differ
// from those before them.
std::vector<FilmReading> ReadFilmAllWays(const Raster& scan, const CameraFile& camera,
                                         const MarkShapes& shapes, const InteriorOptions& options);

}  // namespace orient::interior

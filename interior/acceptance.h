// From the most probable reading to measured marks, and the verdict on them: ok, weak or failed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "interior/cross_position.h"
#include "interior/film_search.h"
#include "interior/film_transform.h"
#include "interior/subpixel.h"

namespace orient {

struct FilmMark {
  MarkState state = MarkState::kMissing;
  std::optional<MarkPosition> position;  // absent for a missing mark
  // A bare cross whose strokes are seen along their whole length (cross_position.h).
  bool clear = false;
};
using FilmMarks = std::vector<FilmMark>;  // in the order of the camera's fiducials

class MeasuredPlaces;

// Measures the assigned marks by least-squares matching with the drawing at the size and turn that
// the reading found; bare crosses in the picture by their lines instead, unless another locator is
// `wanted` (cross_position.h); rejects wrong marks. What is among the scan's `known` places is not
// measured again, all others join them.
FilmMarks MeasureMarks(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                       const FilmReading& reading, std::optional<LocatorKind> wanted,
                       MeasuredPlaces* known);

// A cross's place by its lines, with the matched one's correlation. Where the two contradict each
// other beyond their sigmas (chi-square with two degrees of freedom), one of them is wrong and
// nothing tells which, however little correlates: the difference becomes part of the sigma.
MarkPosition PositionByLines(const MarkPosition& matched, const MeasuredCross& crossing);

// Of all measured marks those become rejected that do not look like the mark, that the others
// contradict (leave-one-out chi-square above 11.8) and that are not surely marks (gain below 3
// nats). A reseau's cross whose strokes are clear looks like the mark, however little the picture
// beside them correlates with the drawing: its neighbours tell its place to some micrometres
// (reseau.h). Where fewer than a reseau's marks are left of them, correlation counts for all.
FilmMarks WithoutWrongMarks(const FilmReading& reading, const FilmMarks& measured);

std::vector<MeasuredMark> UsedMarks(const CameraFile& camera, const FilmMarks& marks);

// Marks that a verdict of ok needs: max(4, 60 %).
int NeededMarks(int all);

// What a set of marks needs at least to be more than chance, nats: 9 for four marks (photos without
// marks reach 6), and 1.9 for every further mark of the camera, found or not.
double MinSetNats(int all);

// Weak, and why: the marks may be those of a smaller or larger camera than the one named (squares
// of four and rings of eight come in many sizes).
void SayPixelSizeIsUnsure(InteriorResult* result);
// That, where the marks are the only word about the pixel size.
void JudgePixelSize(const FilmReading& reading, InteriorResult* result);

// What geometry alone allows: failed below three marks, MinSetNats(all) or 3 nats of margin; weak
// below NeededMarks(all). Three of four marks leave nothing to test them by: however large the
// margin, chance has a part in them.
Status JudgeSet(int all, int used, double set_nats, double margin);

struct Verdict {
  Status status = Status::kFailed;
  std::vector<std::string> messages;
};

// Accepted are max(4, 60 %) marks with a margin above 3 nats, clear of chance as a set, on a film
// of plausible scale and shear. Rejected marks count neither as marks nor as evidence. Three of at
// least four marks are at best weak.
Verdict Judge(const FilmReading& reading, const FilmMarks& marks,
              const std::optional<FilmTransform>& film);

}  // namespace orient

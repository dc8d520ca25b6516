// Whether one scan's interior orientation is ok, weak or failed, and why: every reason of the stage
// is decided here.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "interior/constellation/film_reading.h"
#include "interior/orientation/film_marks.h"
#include "interior/orientation/film_transform.h"

namespace orient::interior {

// Log odds of the used marks alone, in nats: rejected marks contribute no evidence.
double NatsOfUsed(const FilmReading& reading, const FilmMarks& marks);

// Accepted are max(4, 60 %) marks with a margin above 3 nats, clear of chance as a set, on a film
// of plausible scale and shear. Rejected marks count neither as marks nor as evidence. Three of at
// least four marks are at best weak. `unused`: ids of the marks that are not used.
Findings Judge(const FilmReading& reading, const FilmMarks& marks,
               const std::optional<FilmTransform>& film, const std::vector<std::string>& unused);

// Weak if one of these used marks may be wrong instead of a rejected one (SuspectMarks).
std::optional<Finding> JudgeRejected(const std::vector<std::string>& perhaps_wrong);

// Weak: the marks may be those of a smaller or larger camera than the one named (squares of four
// and rings of eight come in many sizes).
Finding PixelSizeIsUnsure(const InteriorResult& result);
// PixelSizeIsUnsure, if the pixel size is known from nothing but the marks.
std::optional<Finding> JudgePixelSize(const FilmReading& reading, const InteriorResult& result);

// On a réseau's correction: enough crosses but no correction means they contradict one another.
std::optional<Finding> JudgeReseau(const InteriorResult& result);

// A digital image that is not as large as its camera's.
std::optional<Finding> JudgeImageSize(const Eigen::Vector2i& image_px,
                                      const Eigen::Vector2i& camera_px);

// Thresholding may shift all strokes of a mark together by up to a pixel, which nothing reveals.
Finding BlackAndWhite();

// The marks' calibrated positions against the scan orientation that the user gave: `nats` by which
// `best` fits better. Empty where that is not sure.
std::optional<Finding> JudgeGivenByLayout(ScanOrientation given, ScanOrientation best, double nats);
// Symbols and border against it: `possible` are those that they leave.
std::optional<Finding> JudgeGivenBySigns(ScanOrientation given,
                                         const std::vector<ScanOrientation>& possible);

// Of a scan orientation that was to be determined. `dissenting` names those signs that are against
// the decision; empty: none.
Findings JudgeFound(bool contradictory, const std::string& dissenting,
                    const std::vector<ScanOrientation>& possible);

// What of the camera file's border lies outside the scan, where that could have told the scan
// orientation. `features`: empty for none.
std::optional<Finding> JudgeOffScan(const std::string& features,
                                    const std::vector<ScanOrientation>& possible);

// Compares a person's clicks with what the scan shows: `result` has the marks under the camera's
// names. Marks that rest on an exact click alone do not count towards ok.
Findings JudgeClicks(const std::vector<MarkClick>& clicks, const InteriorResult& result);

// Of clicks that fit the scan in several ways, a part of them each.
Finding AllClicksContradicted(const std::vector<MarkClick>& clicks);

// Adds findings; the status becomes the worst that they allow.
void Add(const Findings& findings, InteriorResult* result);
void Add(const std::optional<Finding>& finding, InteriorResult* result);

}  // namespace orient::interior

// What people and other programs measured, as points and observations of a bundle adjustment.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "block/bundle/bundle.h"
#include "core/measurements/measurements.h"

namespace orient::block {

// A surveyed point of the adjustment.
struct SurveyedPoint {
  std::string name;
  std::size_t point = 0;  // index into BlockToAdjust::points
};

// Points without ground coordinates that two of the block's photos or more show: ties.
void AddMeasuredTies(const Measurements& measured, BlockToAdjust* block);

// Whether two of these photos or more show such a point.
bool JoinsPhotos(const Measurements& measured, const std::set<std::string>& photos);

// Surveyed points that a photo of the block shows; check points are held out. What was measured in
// the photo system is carried to the scan by the photo's transform.
std::vector<SurveyedPoint> AddSurveyedPoints(const Measurements& measured, BlockToAdjust* block);

}  // namespace orient::block

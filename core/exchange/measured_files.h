// Image and ground points that other programs measured, as files of measurements.
//
// Metashape: markers XML (File > Export > Export Markers), pixels as ours; a marker that is not
// enabled as control is a check point. MicMac: MesureAppuiFlottant1Im (one image, or a set of them;
// a pixel's centre has integer coordinates: ours = theirs + 0.5) and DicoAppuisFlottant. PAT-B and
// BINGO: image coordinates in micrometres and in mm, photo by photo, each ended by -99, relative to
// the principal point and without distortion (frame_adjustments.h); control as lines "point X Y Z"
// ended by -99, and as CONT lines.
#pragma once

#include <optional>
#include <string>

#include "core/measurements/measurements.h"

namespace orient {

enum class MeasuredFormat { kMetashape, kMicmac, kPatb, kBingo };
std::optional<MeasuredFormat> MeasuredFormatFromName(const std::string& name);  // "metashape" ...

// One sigma of what a file states none for.
struct MeasuredSigma {
  double image = 1;  // pixels; mm for PAT-B and BINGO
  double ground_m = 0.05;
};

// Adds what one file holds. Throws InputError naming file, line and value.
void AddMeasuredFile(const std::string& path, MeasuredFormat format, const MeasuredSigma& sigma,
                     Measurements* measurements);

}  // namespace orient

// Image and ground points that other programs measured, as files of measurements.
//
// Metashape: markers XML (metashape_measures.h), pixels as ours. MicMac: MesureAppuiFlottant1Im
// (one image, or a set of them; a pixel's centre has integer coordinates: ours = theirs + 0.5) and
// DicoAppuisFlottant. PAT-B and BINGO (frame_measures.h): image coordinates in micrometres and in
// mm, relative to the principal point and without distortion; control in metres. CSV
// (measured_tables.h): pixels as ours or mm of the photo system, metres.
#pragma once

#include <optional>
#include <string>

#include "core/measurements/gathered_measurements.h"

namespace orient {

enum class MeasuredFormat { kMetashape, kMicmac, kPatb, kBingo, kCsv };
std::optional<MeasuredFormat> MeasuredFormatFromName(const std::string& name);  // "metashape" ...

// Adds what one file holds, with notes on what was left out or assumed. Throws InputError naming
// file, line and value; for a file that holds no point, too. std::invalid_argument: no
// `sigma.image` for another format than CSV.
void AddMeasuredFile(const std::string& path, MeasuredFormat format, const MeasuredSigma& sigma,
                     GatheredMeasurements* all);

}  // namespace orient

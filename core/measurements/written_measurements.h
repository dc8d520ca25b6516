// Files of measurements, written together.
#pragma once

#include <string>
#include <vector>

#include "core/measurements/measurements.h"

namespace orient {

// The names of the files that WriteMeasurements writes: of what there is.
std::vector<std::string> FilesOf(const Measurements& measurements);

// Writes all of them, or none: where one cannot be written, the folder is as it was. Files of what
// there is none of stay. Throws InputError where one cannot be written, EnvironmentError where
// there is no space or the device fails, std::invalid_argument for image points in pixels and in
// mm.
void WriteMeasurements(const std::string& folder, const Measurements& measurements);

}  // namespace orient

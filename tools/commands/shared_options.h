// Options that several subcommands have, declared once so that they read and behave the same.
#pragma once

#include <iosfwd>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/base/output_directory.h"
#include "core/files/results.h"
#include "core/geometry/transform2d.h"
#include "core/measurements/measurements.h"
#include "core/terrain/earth_effects.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace orient {

// PHOTO... and --files-from: scans, globs or lists; expand them in Run() with
// PhotosOf(patterns).
CLI::Option* AddPhotosOption(CLI::App& app, std::vector<std::string>* patterns);

// The photos that are named so. Throws UsageError where none is.
std::vector<std::string> PhotosOf(const std::vector<std::string>& patterns);

// --jobs N: photos worked on at the same time; 0 (the default) is one per processor.
CLI::Option* AddJobsOption(CLI::App& app, int* jobs);

// --learn, and --no-feedback, which is the default: a run that teaches the patch database changes
// what the next one starts from, so the same command would not give the same numbers twice.
void AddLearnOption(CLI::App& app, bool* learn);

// --camera-library DIR.
CLI::Option* AddCameraLibraryOption(CLI::App& app, std::string* folder);

// --earth auto|flat|curved.
CLI::Option* AddEarthOption(CLI::App& app, EarthMode* mode);

// --measurements DIR: what people measured and decided; nothing where the option is not given.
void AddMeasurementsOption(CLI::App& app, Measurements* measurements);

// --out DIR, required, and --overwrite.
struct OutputOptions {
  std::string directory;
  bool overwrite = false;
};
void AddOutputOptions(CLI::App& app, OutputOptions* output);
void AddOverwriteOption(CLI::App& app, bool* overwrite);

// --plan: print what would be done and stop. PrintPlan has a line per photo (paths): whether the
// stage would be done, or its result kept (photos' names).
void AddPlanOption(CLI::App& app, bool* plan);
void PrintPlan(const std::string& stage, const std::vector<std::string>& photos,
               const std::set<std::string>& kept, std::ostream& out);

// --pixel-size-um, --polarity and --orientation of a scan; empty means auto.
struct ScanOptions {
  std::optional<double> pixel_size_um;
  std::optional<Polarity> polarity;
  std::optional<ScanOrientation> orientation;
};
void AddScanOptions(CLI::App& app, ScanOptions* scan);

// Throws UsageError naming the first of `results` that exists, unless `overwrite`. `alternative`
// is a further remedy where a command has one ("--resume").
void RefuseToOverwrite(const std::vector<std::string>& results, bool overwrite,
                       const std::string& alternative = "");

// Adds files to a list of them.
void Append(const std::vector<std::string>& files, std::vector<std::string>* list);

// Throws UsageError naming the first of `inputs`, files or folders, that is one of `results`, which
// the run writes or removes, or lies in it: neither --overwrite nor --resume is meant for it.
void RefuseToReplaceInputs(const std::vector<std::string>& results,
                           const std::vector<std::string>& inputs);

// The four files of such a folder (core/measurements), there or not; none where it is empty.
std::vector<std::string> MeasurementFiles(const std::string& folder);

// Throws UsageError where block.gpkg in the folder is a patch database: the block's own GeoPackage
// would replace it.
void RefuseToReplacePatches(const std::string& directory);

}  // namespace orient

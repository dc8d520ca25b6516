// An oriented block as other programs' files, each format in a folder of its own, with verification
// points.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/finding.h"
#include "tools/convert/check_exports.h"
#include "tools/convert/convert_source.h"

namespace orient {

struct ExportOptions {
  std::vector<ExchangeFormat> formats;
  std::string out;     // <out>/<format>/...
  double geoid_m = 0;  // the geoid's height above the ellipsoid, for geocentric formats
  std::optional<Eigen::Vector3d> origin;  // of shifted formats; a round place near the block
};

struct WrittenExport {
  ExchangeFormat format;
  std::string directory;
  // What remains over the images because the block's CRS is not Cartesian, px; 0 for formats in the
  // block's own coordinates.
  double rms_px = 0, largest_px = 0;
  ExportCheck check = {};   // of what was written, by the program's own formulas
  std::size_t renamed = 0;  // photos with blanks in their names, which the program does not accept
};

// Where a format's files go: what would be overwritten.
std::string ExportDirectory(const ExportOptions& options, ExchangeFormat format);

// Writes <out>/<format>/ with the format's files, verification.csv and export.json for each format,
// and checks them. Throws InputError: a format that needs a CRS or a ground height that the block
// lacks; files that do not project as they should. What concerns one format is thrown when all
// the others are written, and names them.
std::vector<WrittenExport> WriteExports(const ConvertSource& source, const ExportOptions& options);

// What a user of an export must know about it, in plain words; may be empty.
std::vector<std::string> NotesOn(const WrittenExport& written, const ConvertSource& source);

struct ExportsOfFolder {
  std::vector<WrittenExport> written;
  Findings findings;  // of the source, and notes
};

// WriteExports of the folder that `orient block` or `orient exterior` wrote, into
// <folder>/exports/<format> (replaced where they are there). `camera` is the photos' camera file,
// `formats` are names as --to takes them. Throws UsageError for a name that is none, InputError as
// above.
ExportsOfFolder WriteExportsOf(const std::string& folder, const std::string& camera,
                               const std::vector<std::string>& formats);

// Removes what that has written below <folder>/exports, but no file that another program or a
// person has put there.
void RemoveExportsOf(const std::string& folder);

}  // namespace orient

// Options that choose patches, the same in every verb that has them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "patchdb/store/selection.h"

namespace CLI {
class App;
}

namespace orient {

// Numbers that no patch has: mistakes, or nothing to do where patches are deleted, for a run that
// was interrupted may have deleted them.
enum class AbsentIds { kRefuse, kIgnore };

class FilterOptions {
 public:
  explicit FilterOptions(std::string default_state) : state_(std::move(default_state)) {}
  void DeclarePlace(CLI::App& app);  // --box, --polygon
  void DeclareState(CLI::App& app);
  void DeclareRules(CLI::App& app);    // --id, --source, --max-quality, ...
  void DeclareRetired(CLI::App& app);  // --retired-before
  // Throws InputError: a polygon file that cannot be read, a number that no patch has; UsageError:
  // an empty box.
  patchdb::PatchFilter Filter(const patchdb::PatchDatabase& database,
                              AbsentIds absent = AbsentIds::kRefuse) const;

 private:
  std::string state_;
  std::vector<double> box_;
  std::string polygon_;
  std::vector<std::int64_t> ids_;
  std::optional<std::string> source_, older_than_, retired_before_;
  std::optional<double> max_quality_, max_success_, min_failures_;
};

// Outer and inner rings of all polygons in any vector file GDAL reads, in `crs`. Throws InputError
// naming the file: not readable, no polygon, no CRS that leads to `crs`.
std::vector<std::vector<Eigen::Vector2d>> ReadPolygon(const std::string& path, const Crs& crs);

}  // namespace orient

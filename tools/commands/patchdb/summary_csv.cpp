#include "tools/commands/patchdb/summary_csv.h"

#include "core/base/csv_cell.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

std::string Cell(const std::optional<double>& value) { return value ? Fixed(value, 3) : ""; }

}  // namespace

void PrintSummaryHeader(std::ostream& out) {
  out << "id,source_id,x,y,z,sigma_x,sigma_y,sigma_z,gsd_m,chip_px,bits,roundness,distinctness,"
         "persistence,relief_px,lean_px,quality,views,state,success,success_sigma,date,source,"
         "retired_reason";
}

void PrintSummary(const patchdb::PatchSummary& patch, std::ostream& out) {
  out << patch.id << "," << patch.source_id;
  for (int i = 0; i < 3; ++i) out << "," << Fixed(patch.ground_m[i], 3);
  for (int i = 0; i < 3; ++i) out << "," << Fixed(patch.sigma_m[i], 3);
  out << "," << Fixed(patch.gsd_m, 4) << "," << patch.chip_px << "," << patch.bits;
  for (const auto& value : {patch.roundness, patch.distinctness, patch.persistence, patch.relief_px,
                            patch.lean_px, patch.quality})
    out << "," << Cell(value);
  const patchdb::SuccessBelief belief = patch.Belief();
  out << "," << patch.views << "," << Name(patch.life) << "," << Fixed(belief.Mean(), 3) << ","
      << Fixed(belief.Sigma(), 3) << "," << CsvCell(patch.source_date.value_or("")) << ","
      << CsvCell(patch.source_name) << "," << CsvCell(patch.retired_reason);
}

}  // namespace orient

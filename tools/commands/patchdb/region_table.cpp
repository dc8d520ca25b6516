#include "tools/commands/patchdb/region_table.h"

#include <ostream>

#include "tools/commands/summary_table.h"

namespace orient {

void PrintRegions(const patchdb::RegionIndex& index, std::ostream& out) {
  std::int64_t patches = 0;
  SummaryTable table({"number", "database", "patches", "west", "south", "east", "north"});
  for (const patchdb::Region& region : index.regions) {
    patches += region.patches;
    std::vector<std::string> row = {std::to_string(region.number), region.file,
                                    std::to_string(region.patches)};
    for (const double edge :
         {region.extent.min_x, region.extent.min_y, region.extent.max_x, region.extent.max_y})
      row.push_back(region.patches > 0 ? Fixed(edge, 1) : "-");
    table.AddRow(row);
  }
  out << "CRS       " << index.crs.Name() << "\nregions   " << index.regions.size()
      << "\npatches   " << patches << "\nsources   " << index.sources.size() << "\n\n";
  table.Print(out);
}

}  // namespace orient

#include "tools/report/overlap_map.h"

#include <fmt/format.h>

#include <array>
#include <string>

#include "tools/report/html_text.h"
#include "tools/report/svg_shapes.h"

namespace orient {
namespace {

using Outline = OverlapCounts::Outline;
constexpr int kCell = 4;  // side of a cell in the SVG

std::vector<Outline> Footprints(const BlockRecord& block, const BlockVerdict& verdict) {
  std::vector<Outline> outlines;
  for (size_t i = 0; i < block.photos.size(); ++i) {
    const auto& exterior = block.photos[i].exterior;
    if (!exterior || verdict.photos[i].status == Status::kFailed) continue;
    if (exterior->footprint_m.size() < 3) continue;
    Outline& outline = outlines.emplace_back();
    for (const Eigen::Vector3d& corner : exterior->footprint_m) outline.push_back(corner.head<2>());
  }
  return outlines;
}

// Runs of cells of one count, a path for each count.
std::string Shapes(const OverlapCounts& counts) {
  std::array<std::string, OverlapCounts::kMostCounted + 1> paths;
  for (int row = 0; row < counts.Height(); ++row)
    for (int col = 0; col < counts.Width();) {
      const int count = counts.At(col, row), first = col;
      while (col < counts.Width() && counts.At(col, row) == count) ++col;
      if (count > 0)
        paths[static_cast<size_t>(count)] +=
            fmt::format("M{} {}h{}v{}h-{}z", first * kCell, row * kCell, (col - first) * kCell,
                        kCell, (col - first) * kCell);
    }
  std::string svg;
  for (size_t count = 1; count < paths.size(); ++count)
    if (!paths[count].empty())
      svg += fmt::format("<path class=\"seen-{}\" d=\"{}\"/>\n", count, paths[count]);
  return svg;
}

Markup Keys(const OverlapCounts& counts) {
  Markup keys;
  for (int count = 1; count <= OverlapCounts::kMostCounted; ++count) {
    const double share = counts.Share(count);
    if (share == 0) continue;
    const bool more = count == OverlapCounts::kMostCounted;
    keys +=
        Fill("overlap.html#key", {{"count", count},
                                  {"photos", fmt::format("{}{} {}", count, more ? " or more" : "",
                                                         count == 1 ? "photo" : "photos")},
                                  {"share", Decimal(100 * share, 0)}});
  }
  return keys;
}

}  // namespace

std::optional<OverlapCounts> CountOverlap(const BlockRecord& block, const BlockVerdict& verdict) {
  const std::vector<Outline> outlines = Footprints(block, verdict);
  if (outlines.size() < 2) return std::nullopt;
  return OverlapCounts(outlines);
}

Markup OverlapMap(const BlockRecord& block, const BlockVerdict& verdict) {
  const std::optional<OverlapCounts> counts = CountOverlap(block, verdict);
  if (!counts) return {};
  const double cell_m = counts->Cell_m();
  return Fill("overlap.html", {{"width", counts->Width() * kCell},
                               {"height", counts->Height() * kCell},
                               {"shapes", Markup(Shapes(*counts))},
                               {"keys", Keys(*counts)},
                               {"cell", Decimal(cell_m, cell_m < 10 ? 1 : 0)}});
}

}  // namespace orient

#include "tools/commands/exterior_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/commands/summary_table.h"

namespace orient {
namespace {

std::string Matched(const ExteriorResult& result) {
  int matched = 0, searched = 0;
  for (const PatchResult& patch : result.patches) {
    matched += patch.state == PatchState::kMatched ? 1 : 0;
    searched += patch.state != PatchState::kNotVisible ? 1 : 0;
  }
  return searched == 0 ? "-" : fmt::format("{}/{}", matched, searched);
}

// The larger of the two horizontal, and the height's sigma.
std::optional<double> Sigma(const ExteriorResult& result, int first, int last, double factor) {
  if (!result.covariance) return std::nullopt;
  double largest = 0;
  for (int i = first; i <= last; ++i) largest = std::max(largest, (*result.covariance)(i, i));
  return std::sqrt(largest) * factor;
}

}  // namespace

void PrintExteriorSummary(const std::vector<ExteriorResult>& results, std::ostream& out) {
  SummaryTable table({"photo", "status", "patches", "sigma0 px", "sigma xy m", "sigma z m",
                      "sigma angle deg", "message"});
  for (const ExteriorResult& result : results)
    table.AddRow({result.photo, std::string(Name(result.status)), Matched(result),
                  Fixed(result.sigma0_px, 2), Fixed(Sigma(result, 0, 1, 1), 2),
                  Fixed(Sigma(result, 2, 2, 1), 2), Fixed(Sigma(result, 3, 5, DegFromRad(1)), 4),
                  MessageCell(result.findings)});
  table.Print(out);
}

bool AllOriented(const std::vector<ExteriorResult>& results) {
  return std::none_of(results.begin(), results.end(),
                      [](const ExteriorResult& r) { return r.status == Status::kFailed; });
}

}  // namespace orient

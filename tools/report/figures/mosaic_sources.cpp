#include "tools/report/figures/mosaic_sources.h"

#include <fmt/format.h>

#include <sstream>
#include <string_view>

namespace orient {
namespace {

constexpr std::string_view kOf = ": ";  // no orthophoto's text has it

}  // namespace

std::string TextOfSources(const MosaicSources& sources) {
  std::string text;
  for (const auto& [photo, made_from] : sources)
    text += fmt::format("{}{}{}{}", text.empty() ? "" : "\n", made_from, kOf, photo);
  return text;
}

MosaicSources SourcesOf(const std::string& text) {
  MosaicSources sources;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t at = line.find(kOf); at != std::string::npos)
      sources[line.substr(at + kOf.size())] = line.substr(0, at);
  return sources;
}

MosaicChanges ChangesOf(const MosaicSources& then, const MosaicSources& now) {
  MosaicChanges changes;
  if (then.empty()) return changes;
  for (const auto& [photo, made_from] : then) {
    const auto found = now.find(photo);
    if (found == now.end() || (!found->second.empty() && found->second != made_from))
      changes.others.push_back(photo);
  }
  for (const auto& [photo, made_from] : now)
    if (!then.contains(photo)) changes.lacking.push_back(photo);
  return changes;
}

}  // namespace orient

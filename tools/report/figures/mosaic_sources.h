// What a mosaic was made from: its orthophotos, and what each of them was made from.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace orient {

// Metadata of an orthophoto: a text that changes with anything that it shows. Of a mosaic: those of
// its orthophotos, as TextOfSources writes them.
inline constexpr const char* kMadeFrom = "ORIENT_MADE_FROM";

// The orthophotos' own texts, by photo.
using MosaicSources = std::map<std::string, std::string>;

// A line for each orthophoto, "text: photo", and back. Lines of another form are left out.
std::string TextOfSources(const MosaicSources& sources);
MosaicSources SourcesOf(const std::string& text);

// Names of photos. `others`: their orthophotos in the mosaic differ from those there now, or there
// are none now; `lacking`: they have orthophotos that the mosaic does not show.
struct MosaicChanges {
  std::vector<std::string> others = {}, lacking = {};
  bool Any() const { return !others.empty() || !lacking.empty(); }
};

// Nothing has changed for a mosaic that does not say what it was made from (`then` is empty), and
// nothing is said of orthophotos that do not say it (empty texts).
MosaicChanges ChangesOf(const MosaicSources& then, const MosaicSources& now);

}  // namespace orient

#include "block/plan.h"

#include <fmt/format.h>

#include <set>

#include "block/block_folder.h"
#include "block/inputs/block_files.h"
#include "block/stages/exterior_inputs.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"

namespace orient::block {
namespace {

std::set<std::string> KeptInteriors(const BlockInputs& inputs) {
  return inputs.IsFilm() ? InteriorsThatStay(inputs.Interior()) : std::set<std::string>();
}

// Photos whose exterior orientation would be kept. A photo oriented again may change the
// approximations of later ones.
std::set<std::string> KeptExteriors(const BlockInputs& inputs,
                                    const std::set<std::string>& interiors) {
  std::set<std::string> kept;
  if (!inputs.Options().resume) return kept;
  const ExteriorRunOptions options =
      inputs.Exterior(StageDirectory(inputs.OutputDirectory(), "exterior"));
  const ResultStore results = ExteriorStore(options.out);
  const std::vector<std::string>& photos = inputs.Block().photos;
  std::vector<ExteriorResult> so_far(photos.size());
  for (bool all = true; all;) {
    const std::vector<std::size_t> next = NextPhotos(inputs, so_far);
    if (next.empty()) break;
    for (const std::size_t i : next) {
      const std::string name = PhotoName(photos[i]);
      so_far[i].photo = name;
      const bool keep =
          (!inputs.IsFilm() || interiors.contains(name)) &&
          results.IsCurrent(name,
                            InputsOfPhoto(options, inputs.Approximations().Table(), photos[i]));
      all = all && keep;
      if (!keep) continue;
      try {
        so_far[i] = ReadExteriorResult(results.PathOf(name));
        kept.insert(name);
      } catch (const InputError&) {  // damaged: done again
        all = false;
      }
    }
  }
  return kept;
}

}  // namespace

std::string PlanLine(bool keep, const std::string& what) {
  return (keep ? "keep  " : "do    ") + what;
}

std::vector<std::string> PlanBlock(const BlockInputs& inputs) {
  std::vector<std::string> lines;
  const auto line = [&](bool keep, const std::string& what) {
    lines.push_back(PlanLine(keep, what));
  };
  const std::set<std::string> interiors = KeptInteriors(inputs);
  const std::set<std::string> exteriors = KeptExteriors(inputs, interiors);
  const BlockFile& block = inputs.Block();
  for (const UnusablePhoto& photo : block.unusable)
    lines.push_back("cannot  " + photo.name + ": " + photo.reason);
  for (const std::string& path : block.photos) {
    const std::string name = PhotoName(path);
    if (inputs.IsFilm()) line(interiors.contains(name), "interior  " + name);
    line(exteriors.contains(name), "exterior  " + name);
  }
  if (block.adjustment.ties && block.photos.size() > 1) {
    line(false, "ties      between all photos that overlap (kept where nothing changed)");
    line(false, "adjust    the block");
  }
  line(false, "write     " + block.output_directory + "/orientation.csv, block.gpkg, report.html");
  for (const std::string& format : block.formats)
    line(false, fmt::format("write     {}/{}/{}", block.output_directory, kExportsFolder, format));
  if (block.ortho) line(false, "ortho     " + block.output_directory + "/ortho");
  return lines;
}

}  // namespace orient::block

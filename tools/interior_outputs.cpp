#include "tools/interior_outputs.h"

#include <filesystem>
#include <stdexcept>

#include "core/files/atomic_write.h"
#include "core/files/interior_table.h"
#include "core/files/micmac_measures.h"
#include "interior/roll.h"
#include "tools/contact_sheet.h"

namespace orient {

void WriteInteriorOutputs(const std::string& directory, const CameraFile& camera,
                          std::vector<InteriorResult>* results) {
  for (const size_t i : CompareWithRoll(StatisticsOfRoll(*results), results))
    WriteInteriorResult(directory, (*results)[i]);
  const std::filesystem::path folder(directory);
  WriteFileAtomically((folder / "interior.csv").string(), InteriorTable(*results));
  WriteFileAtomically((folder / "marks.csv").string(), MarkTable(*results, camera.fiducials));
  if (!camera.fiducials.empty()) WriteContactSheet(directory, *results);
}

void WriteMicmacOutputs(const std::string& directory, const CameraFile& camera,
                        const std::vector<std::string>& photos,
                        const std::vector<InteriorResult>& results) {
  if (photos.size() != results.size())
    throw std::invalid_argument("WriteMicmacOutputs: one result a photo");
  WriteMicmacCamera(directory, camera.fiducials);
  for (size_t i = 0; i < photos.size(); ++i) WriteMicmacImage(directory, photos[i], results[i]);
}

}  // namespace orient

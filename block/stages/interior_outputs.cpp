#include "block/stages/interior_outputs.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "block/pictures/contact_sheet.h"
#include "block/roll/roll.h"
#include "core/base/atomic_write.h"
#include "core/exchange/micmac_measures.h"
#include "core/files/interior_table.h"

namespace orient::block {

void WriteInteriorOutputs(const std::string& directory, const CameraFile* camera,
                          const std::vector<InteriorResult>& earlier,
                          std::vector<InteriorResult>* results) {
  if (camera)
    for (const size_t i : CompareWithRoll(StatisticsOfRoll(*results), results))
      WriteInteriorResult(directory, (*results)[i]);
  std::vector<InteriorResult> all = earlier;
  all.insert(all.end(), results->begin(), results->end());
  const auto path = [&](const char* file) {
    return (std::filesystem::path(directory) / file).string();
  };
  const std::string marks = path(kMarkTable);
  WriteFileAtomically(path(kInteriorTable), InteriorTable(all));
  if (camera)
    WriteFileAtomically(marks, MarkTable(all, camera->fiducials));
  else
    std::filesystem::remove(marks);  // an earlier run's, of other photos
  const bool any_marks =
      std::any_of(all.begin(), all.end(), [](const InteriorResult& r) { return !r.marks.empty(); });
  if (any_marks) WriteContactSheet(directory, all);
}

void WriteMicmacOutputs(const std::string& directory, const CameraFile& camera,
                        const std::vector<std::string>& photos,
                        const std::vector<InteriorResult>& results) {
  if (photos.size() != results.size())
    throw std::invalid_argument("WriteMicmacOutputs: one result per photo");
  WriteMicmacCamera(directory, camera.fiducials);
  for (size_t i = 0; i < photos.size(); ++i) WriteMicmacImage(directory, photos[i], results[i]);
}

}  // namespace orient::block

#include "tools/block/pose_covariance.h"

#include <array>
#include <filesystem>

#include "core/files/atomic_write.h"
#include "core/files/interior_table.h"
#include "core/format_text.h"

namespace orient {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, 6> kElements = {"x", "y", "z", "omega", "phi", "kappa"};

}  // namespace

std::string PoseCovariancePath(const std::string& directory) {
  return (fs::path(directory) / "pose_covariance.csv").string();
}

bool WritePoseCovariance(const std::string& directory, bool wanted, const AdjustedBlock& adjusted) {
  const BlockResult& result = adjusted.result;
  const std::string path = PoseCovariancePath(directory);
  if (!wanted || !result.converged || result.covariance_photos.empty()) {
    std::error_code ignored;
    fs::remove(path, ignored);
    return !wanted;
  }
  std::string text = "filename,element";
  for (const std::size_t photo : result.covariance_photos)
    for (const char* element : kElements)
      text += "," + CsvCell(adjusted.block.photos[photo].name + "." + element);
  text += '\n';
  for (Eigen::Index row = 0; row < result.pose_covariance.rows(); ++row) {
    const std::size_t photo = result.covariance_photos[static_cast<std::size_t>(row / 6)];
    text += CsvCell(adjusted.block.photos[photo].name) + "," +
            kElements.at(static_cast<std::size_t>(row % 6));
    for (Eigen::Index col = 0; col < result.pose_covariance.cols(); ++col)
      text += FormatText(",%.9g", result.pose_covariance(row, col));
    text += '\n';
  }
  WriteFileAtomically(path, text);
  return true;
}

}  // namespace orient

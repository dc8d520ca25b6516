#include "block/verdict/pose_covariance.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "block/inputs/block_files.h"
#include "core/base/atomic_write.h"
#include "core/base/csv_cell.h"

namespace orient::block {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const char*, 6> kElements = {"x", "y", "z", "omega", "phi", "kappa"};

// Indices of adjusted photos whose results hold the adjusted pose. A photo not adjusted, or whose
// adjusted pose was not accepted, has another pose in its result, or none; of a block by image
// measurements there are no others.
std::vector<Eigen::Index> OfTheBlock(const AdjustedBlock& adjusted,
                                     const std::vector<ExteriorResult>& results) {
  std::vector<Eigen::Index> places;
  const std::vector<std::size_t>& photos = adjusted.result.covariance_photos;
  for (std::size_t k = 0; k < photos.size(); ++k) {
    const ExteriorResult& result = results[adjusted.photo_of[photos[k]]];
    if (result.pose && (result.alone || adjusted.by_measurements))
      places.push_back(static_cast<Eigen::Index>(k));
  }
  return places;
}

// The adjustment's covariance, with the verdict's additions to single photos' own blocks.
Eigen::MatrixXd CovarianceOf(const AdjustedBlock& adjusted,
                             const std::vector<ExteriorResult>& results) {
  Eigen::MatrixXd covariance = adjusted.result.pose_covariance;
  Eigen::Index place = 0;
  for (const std::size_t photo : adjusted.result.covariance_photos) {
    if (const auto& own = results[adjusted.photo_of[photo]].covariance)
      covariance.block<6, 6>(6 * place, 6 * place) = *own;
    ++place;
  }
  return covariance;
}

std::string Table(const AdjustedBlock& adjusted, const std::vector<ExteriorResult>& results,
                  const std::vector<Eigen::Index>& places) {
  const Eigen::MatrixXd covariance = CovarianceOf(adjusted, results);
  const auto name = [&](Eigen::Index place) {
    return adjusted.block.photos[adjusted.result.covariance_photos[static_cast<std::size_t>(place)]]
        .name;
  };
  std::string text = "filename,element";
  for (const Eigen::Index column : places)
    for (const char* element : kElements) text += "," + CsvCell(name(column) + "." + element);
  text += '\n';
  for (const Eigen::Index row : places)
    for (Eigen::Index i = 0; i < 6; ++i) {
      text += CsvCell(name(row)) + "," + kElements.at(static_cast<std::size_t>(i));
      for (const Eigen::Index column : places)
        for (Eigen::Index j = 0; j < 6; ++j)
          text += fmt::format(",{:.9g}", covariance(6 * row + i, 6 * column + j));
      text += '\n';
    }
  return text;
}

}  // namespace

std::string PoseCovariancePath(const std::string& directory) {
  return (fs::path(directory) / kPoseCovarianceFile).string();
}

bool WritePoseCovariance(const std::string& directory, bool wanted, const AdjustedBlock& adjusted,
                         const std::vector<ExteriorResult>& results) {
  const std::string path = PoseCovariancePath(directory);
  const auto places = wanted && adjusted.result.converged ? OfTheBlock(adjusted, results)
                                                          : std::vector<Eigen::Index>();
  if (places.empty()) {
    std::error_code ignored;
    fs::remove(path, ignored);
    return !wanted;
  }
  WriteFileAtomically(path, Table(adjusted, results, places));
  return true;
}

Finding NoPoseCovariance() {
  return {.reason = Reason::kNoPoseCovariance, .limit = kMostForFullCovariance};
}

}  // namespace orient::block

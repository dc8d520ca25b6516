#include "core/exchange/micmac_homologues.h"

#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "core/base/atomic_write.h"
#include "core/base/output_directory.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string PixelText(const Eigen::Vector2d& pixel) {
  return ExactNumber(pixel.x() - 0.5) + " " + ExactNumber(pixel.y() - 0.5) + " ";
}

std::string FolderOf(const std::string& directory, const ExchangePhoto& photo) {
  return (fs::path(directory) / "Homol" / ("Pastis" + fs::path(photo.image).filename().string()))
      .string();
}

// Tie points of an earlier block would be read together with this block's.
void RemoveOld(const std::string& folder) {
  std::vector<fs::path> old;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".txt") old.push_back(entry.path());
  for (const fs::path& file : old) fs::remove(file);
}

}  // namespace

void WriteMicmacHomologues(const std::string& directory, const ExchangeBlock& block) {
  std::map<std::pair<std::size_t, std::size_t>, std::string> pairs;
  for (const ExchangePoint& point : block.points)
    for (const ExchangeObservation& one : point.observations)
      for (const ExchangeObservation& other : point.observations)
        if (one.photo != other.photo)
          pairs[{one.photo, other.photo}] += PixelText(one.pixel) + PixelText(other.pixel) + "1\n";
  for (const ExchangePhoto& photo : block.photos) RemoveOld(FolderOf(directory, photo));
  for (const auto& [photos, text] : pairs) {
    const fs::path folder = FolderOf(directory, block.photos[photos.first]);
    MakeOutputDirectory(folder.string());
    WriteFileAtomically((folder / (block.photos[photos.second].image + ".txt")).string(), text);
  }
}

}  // namespace orient

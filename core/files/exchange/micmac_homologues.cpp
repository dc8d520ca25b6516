#include "core/files/exchange/micmac_homologues.h"

#include <filesystem>
#include <map>
#include <utility>

#include "core/files/atomic_write.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string PixelText(const Eigen::Vector2d& pixel) {
  return ExactNumber(pixel.x() - 0.5) + " " + ExactNumber(pixel.y() - 0.5) + " ";
}

}  // namespace

void WriteMicmacHomologues(const std::string& directory, const ExchangeBlock& block) {
  std::map<std::pair<std::size_t, std::size_t>, std::string> pairs;
  for (const ExchangePoint& point : block.points)
    for (const ExchangeObservation& one : point.observations)
      for (const ExchangeObservation& other : point.observations)
        if (one.photo != other.photo)
          pairs[{one.photo, other.photo}] += PixelText(one.pixel) + PixelText(other.pixel) + "1\n";
  for (const auto& [photos, text] : pairs) {
    const fs::path folder =
        fs::path(directory) / "Homol" / ("Pastis" + block.photos[photos.first].image);
    fs::create_directories(folder);
    WriteFileAtomically((folder / (block.photos[photos.second].image + ".txt")).string(), text);
  }
}

}  // namespace orient

// Scans as tiles for a viewer, straight from windows of their files: no pyramid is made beforehand.
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <semaphore>
#include <string>
#include <vector>

#include "core/raster/raster.h"

namespace orient {

// A tile shows 256 x 256 pixels of the scan reduced by 2^level; (0, 0) is the upper left one.
struct TilePlace {
  int level = 0, col = 0, row = 0;
};

struct ScanSize {
  int width = 0, height = 0;
  int levels = 0;  // at level levels - 1 the whole scan fits into one tile
};

inline constexpr int kTilePx = 256;
inline constexpr int kMostAtWork = 2;  // tiles made at a time

// Safe from several threads. Holds at most a few open files and 32 MB of tiles, the latest used.
class ScanTiles {
 public:
  // Name -> path. Nothing is opened yet.
  explicit ScanTiles(std::map<std::string, std::string> scans) : paths_(std::move(scans)) {}

  bool Has(const std::string& scan) const { return paths_.contains(scan); }
  std::optional<std::string> PathOf(const std::string& scan) const {
    const auto found = paths_.find(scan);
    return found == paths_.end() ? std::nullopt : std::optional(found->second);
  }
  // Empty for a name that is not known. Throws InputError where the file cannot be read.
  std::optional<ScanSize> Size(const std::string& scan);
  // 8-bit grey PNG, smaller than 256 x 256 at the scan's right and lower edge. More than 8 bits are
  // stretched between the 0.5 and 99.5 percentiles of 32 of the scan's rows. Empty where there is
  // no such scan or tile. Throws InputError where the file is damaged there.
  std::shared_ptr<const std::string> Tile(const std::string& scan, const TilePlace& place);

 private:
  struct Scan;
  struct Cached {
    std::string key;
    std::shared_ptr<const std::string> png;
  };

  std::shared_ptr<const Scan> Opened(const std::string& name);
  std::shared_ptr<const std::string> FromCache(const std::string& key);
  void Keep(const std::string& key, const std::shared_ptr<const std::string>& png);

  std::map<std::string, std::string> paths_;
  std::counting_semaphore<kMostAtWork> at_work_{kMostAtWork};  // bounds the memory
  std::mutex mutex_;
  std::list<std::pair<std::string, std::shared_ptr<const Scan>>> opened_;  // the latest used first
  std::list<Cached> tiles_;                                                // likewise
  std::map<std::string, std::list<Cached>::iterator> by_key_;
  std::size_t bytes_ = 0;  // of tiles_
};

}  // namespace orient

// The points of a block for its exports: patches and ties, where the images written show them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/exchange/exchange_block.h"
#include "core/files/adjustment_result.h"
#include "core/files/results.h"
#include "tools/convert/film_image.h"

namespace orient {

class ExportPoints {
 public:
  // The patches that the photo matched, as control points with their own numbers; those lent by
  // neighbours (numbers below 0) are none. `photo`: its place in the block.
  void AddPhoto(std::size_t photo, const ExteriorResult& result, FilmImage image);
  // Of the block adjustment, with the ground it computed: the sightings it used, in the photos that
  // were added. Numbered on from a power of ten beyond the patches' numbers.
  void AddTies(const AdjustmentResult& adjusted);
  // Patches first; every point is seen by a photo, every tie by two.
  std::vector<ExchangePoint> Take();

 private:
  std::map<std::int64_t, ExchangePoint> patches_;
  std::vector<ExchangePoint> ties_;
  std::map<std::string, std::pair<std::size_t, FilmImage>> photos_;
};

}  // namespace orient

#include "block/bundle/sub_blocks.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "block/bundle/adjustment.h"
#include "block/bundle/joined_sub_blocks.h"

namespace orient::block {
namespace {

// So many times photos that share points with those there are added to a core. With 60 % and 30 %
// overlap once is two photos along a strip and one strip across.
constexpr int kRings = 3;
constexpr std::size_t kLeastCoreShare = 8;
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// Which photos share points.
class Neighbourhood {
 public:
  explicit Neighbourhood(const BlockToAdjust& block)
      : photos_of_point_(block.points.size()), points_of_photo_(block.photos.size()) {
    for (const ImageObservation& o : block.observations) {
      photos_of_point_[o.point].push_back(o.photo);
      points_of_photo_[o.photo].push_back(o.point);
    }
  }

  // These and those that share a point with one of them, ascending.
  std::vector<std::size_t> WithNeighbours(const std::vector<std::size_t>& photos) const {
    std::vector<bool> is_in(points_of_photo_.size(), false);
    for (const std::size_t photo : photos) {
      is_in[photo] = true;
      for (const std::size_t point : points_of_photo_[photo])
        for (const std::size_t other : photos_of_point_[point]) is_in[other] = true;
    }
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < is_in.size(); ++i)
      if (is_in[i]) all.push_back(i);
    return all;
  }

 private:
  std::vector<std::vector<std::size_t>> photos_of_point_, points_of_photo_;
};

SubBlock Around(const Neighbourhood& neighbourhood, std::vector<std::size_t> core) {
  SubBlock sub;
  sub.beside = neighbourhood.WithNeighbours(core);
  sub.photos = sub.beside;
  for (int ring = 1; ring < kRings; ++ring) sub.photos = neighbourhood.WithNeighbours(sub.photos);
  std::erase_if(sub.beside,
                [&](std::size_t i) { return std::binary_search(core.begin(), core.end(), i); });
  sub.core = std::move(core);
  return sub;
}

// Across the longer side of where the photos were taken.
std::array<std::vector<std::size_t>, 2> Halves(const BlockToAdjust& block,
                                               std::vector<std::size_t> photos) {
  const auto position = [&](std::size_t i) -> const Eigen::Vector3d& {
    return block.photos[i].approximate.position_m;
  };
  Eigen::Vector3d low = position(photos[0]), high = low;
  for (const std::size_t i : photos) {
    low = low.cwiseMin(position(i));
    high = high.cwiseMax(position(i));
  }
  const Eigen::Index side = high.x() - low.x() >= high.y() - low.y() ? 0 : 1;
  std::sort(photos.begin(), photos.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(position(a)[side], a) < std::pair(position(b)[side], b);
  });
  const auto middle = photos.begin() + std::ssize(photos) / 2;
  std::array halves = {std::vector<std::size_t>(photos.begin(), middle),
                       std::vector<std::size_t>(middle, photos.end())};
  for (auto& half : halves) std::sort(half.begin(), half.end());
  return halves;
}

void Divide(const BlockToAdjust& block, const Neighbourhood& neighbourhood, std::size_t most_photos,
            std::vector<std::size_t> core, std::vector<SubBlock>* subs) {
  SubBlock sub = Around(neighbourhood, std::move(core));
  if (sub.photos.size() <= most_photos || kLeastCoreShare * sub.core.size() <= most_photos ||
      sub.core.size() < 2) {
    subs->push_back(std::move(sub));
    return;
  }
  for (auto& half : Halves(block, std::move(sub.core)))
    Divide(block, neighbourhood, most_photos, std::move(half), subs);
}

// The photos of a sub-block with what they show. Points and observations are in the whole's order.
struct Extract {
  BlockToAdjust block;
  std::vector<std::size_t> points, observations;  // indices into the whole
};

Extract ExtractOf(const BlockToAdjust& whole, const SubBlock& sub) {
  Extract extract;
  extract.block.cameras = whole.cameras;
  std::vector<std::size_t> photo_in(whole.photos.size(), kNone);
  for (const std::size_t i : sub.photos) {
    photo_in[i] = extract.block.photos.size();
    extract.block.photos.push_back(whole.photos[i]);
  }
  std::vector<std::size_t> point_in(whole.points.size(), kNone);
  for (const ImageObservation& o : whole.observations)
    if (photo_in[o.photo] != kNone) point_in[o.point] = 0;
  for (std::size_t i = 0; i < point_in.size(); ++i) {
    if (point_in[i] == kNone) continue;
    point_in[i] = extract.points.size();
    extract.points.push_back(i);
    extract.block.points.push_back(whole.points[i]);
  }
  for (std::size_t i = 0; i < whole.observations.size(); ++i) {
    ImageObservation o = whole.observations[i];
    if (photo_in[o.photo] == kNone) continue;
    o.photo = photo_in[o.photo];
    o.point = point_in[o.point];
    extract.block.observations.push_back(o);
    extract.observations.push_back(i);
  }
  return extract;
}

}  // namespace

std::vector<SubBlock> DivideBlock(const BlockToAdjust& block, std::size_t most_photos) {
  block.CheckIndices();
  std::vector<std::size_t> all(block.photos.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  std::vector<SubBlock> subs;
  if (!all.empty()) Divide(block, Neighbourhood(block), most_photos, std::move(all), &subs);
  return subs;
}

BlockResult AdjustWholeOrInSubBlocks(const BlockToAdjust& block, const BlockOptions& options) {
  if (block.photos.size() <= options.most_photos) return AdjustBlock(block, options);
  if (const auto wrong = options.Check()) throw std::invalid_argument(*wrong);
  if (options.self_calibration)
    throw std::invalid_argument("sub-blocks cannot be adjusted with self-calibration");
  const std::vector<SubBlock> subs = DivideBlock(block, options.most_photos);
  BlockOptions of_each = options;
  of_each.full_covariance = false;
  std::vector<AdjustedSubBlock> adjusted;
  for (const SubBlock& sub : subs) {
    Extract extract = ExtractOf(block, sub);
    adjusted.push_back({sub, std::move(extract.points), std::move(extract.observations),
                        AdjustBlock(extract.block, of_each)});
  }
  return JoinSubBlocks(block, options, adjusted);
}

}  // namespace orient::block

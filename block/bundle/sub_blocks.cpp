#include "block/bundle/sub_blocks.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "block/bundle/adjustment.h"
#include "block/bundle/joined_sub_blocks.h"

namespace orient::block {
namespace {

// How many times photos sharing points with those already present are added to a core. With 60 %
// and 30 % overlap, each time adds two photos along a strip and one strip across.
constexpr int kRings = 4;
// A half with more than this of the whole's photos saves little memory, and takes as long again.
constexpr double kMostOfWhole = 0.85;
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
    std::vector<bool> is_in(points_of_photo_.size(), false), seen(photos_of_point_.size(), false);
    for (const std::size_t photo : photos) {
      is_in[photo] = true;
      for (const std::size_t point : points_of_photo_[photo]) {
        if (seen[point]) continue;
        seen[point] = true;
        for (const std::size_t other : photos_of_point_[point]) is_in[other] = true;
      }
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

// Divides across the longer side of the extent of the projection centres.
std::array<std::vector<std::size_t>, 2> Halves(const BlockToAdjust& block,
                                               std::vector<std::size_t> photos) {
  // Positions that are not finite count as the origin: they could not be sorted.
  const auto position = [&](std::size_t i) -> Eigen::Vector3d {
    const Eigen::Vector3d& position_m = block.photos[i].approximate.position_m;
    return position_m.allFinite() ? position_m : Eigen::Vector3d::Zero();
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

class Division {
 public:
  Division(const BlockToAdjust& block, std::size_t most_photos)
      : block_(block), neighbourhood_(block), most_photos_(most_photos) {}

  // Adds `sub` or, if it is too large and its halves are smaller, the halves.
  void Divide(SubBlock sub) {
    if (sub.photos.size() > most_photos_ && sub.core.size() > 1) {
      auto [one, other] = Halves(block_, sub.core);
      SubBlock first = Around(neighbourhood_, std::move(one)),
               second = Around(neighbourhood_, std::move(other));
      const auto larger = static_cast<double>(std::max(first.photos.size(), second.photos.size()));
      if (larger <= kMostOfWhole * static_cast<double>(sub.photos.size())) {
        sub = {};
        Divide(std::move(first));
        Divide(std::move(second));
        return;
      }
    }
    subs_.push_back(std::move(sub));
  }
  std::vector<SubBlock> Of(std::vector<std::size_t> photos) {
    Divide(Around(neighbourhood_, std::move(photos)));
    return std::move(subs_);
  }

 private:
  const BlockToAdjust& block_;
  Neighbourhood neighbourhood_;
  std::size_t most_photos_;
  std::vector<SubBlock> subs_;
};

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

// The ground that each source's control covers.
std::map<std::string, Bounds> SourceAreas(const BlockToAdjust& block) {
  std::map<std::string, Bounds> areas;
  for (const BlockPoint& point : block.points)
    if (point.control && !point.held_out && !point.by_hand)
      areas.try_emplace(point.control->source, Bounds::OfNothing())
          .first->second.Include(point.control->ground_m.x(), point.control->ground_m.y());
  return areas;
}

}  // namespace

std::vector<SubBlock> DivideBlock(const BlockToAdjust& block, std::size_t most_photos) {
  block.CheckIndices();
  std::vector<std::size_t> all(block.photos.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  return Division(block, most_photos).Of(std::move(all));
}

BlockResult AdjustWholeOrInSubBlocks(const BlockToAdjust& block, const BlockOptions& options) {
  if (block.photos.size() <= options.most_photos) return AdjustBlock(block, options);
  if (const auto wrong = options.Check()) throw std::invalid_argument(*wrong);
  if (options.self_calibration)
    throw std::invalid_argument("sub-blocks cannot be adjusted with self-calibration");
  const std::vector<SubBlock> subs = DivideBlock(block, options.most_photos);
  if (subs.size() == 1) return AdjustBlock(block, options);
  BlockOptions of_each = options;
  of_each.full_covariance = false;
  of_each.source_areas = SourceAreas(block);
  JoinedSubBlocks joined(block);
  for (const SubBlock& sub : subs) {
    Extract extract = ExtractOf(block, sub);
    joined.Add({sub, std::move(extract.points), std::move(extract.observations),
                AdjustBlock(extract.block, of_each)});
  }
  return joined.Result(options);
}

}  // namespace orient::block

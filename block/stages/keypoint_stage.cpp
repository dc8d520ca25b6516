#include "block/stages/keypoint_stage.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <exception>
#include <numbers>

#include "block/inputs/digest.h"
#include "block/stages/jobs.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"

namespace orient::block {
namespace {

// To be raised where the method changes.
constexpr const char* kMethod = "keypoints 3";
// Longest side of the reduced photo; a 9 x 9 inch scan at 20 um is reduced by a factor of eight.
constexpr double kLongestSide_px = 1600;
constexpr int kMostKeypoints = 3000;
// Distance to the frame's border and covered areas, reduced pixels: keypoints use a neighbourhood.
constexpr double kMargin_px = 10;
// Oriented photos that a photo is compared with, and how many of them before the first try.
constexpr std::size_t kMostLenders = 48, kAtATime = 8;
// Photos whose keypoints are kept in memory: half a megabyte each.
constexpr std::size_t kInMemory = 200;
// Photos searched at a time: each one's scale space takes some half a gigabyte.
constexpr int kSearchedAtATime = 2;
// Residuals do not show errors common to all keypoints of a lender: its pose's and the DEM's.
constexpr double kCommonErrors = 5;

bool ShowsGround(const Eigen::Vector2d& photo_mm, const Camera& camera,
                 const std::vector<exterior::CoveredArea>& covered, double margin_mm) {
  if (!camera.InFrame(photo_mm, -margin_mm)) return false;
  return std::none_of(covered.begin(), covered.end(), [&](const exterior::CoveredArea& area) {
    return (photo_mm.array() >= area.from_mm.array() - margin_mm).all() &&
           (photo_mm.array() <= area.to_mm.array() + margin_mm).all();
  });
}

// The indices below `count`, each first part of them spread evenly (van der Corput 1935).
std::vector<std::size_t> SpreadEvenly(std::size_t count) {
  std::vector<std::size_t> order;
  std::vector<bool> taken(count);
  const std::size_t steps = std::bit_ceil(std::max<std::size_t>(count, 1));
  for (std::size_t k = 0; k < steps; ++k) {
    std::size_t reversed = 0;
    for (std::size_t bit = 1; bit < steps; bit *= 2)
      if ((k & bit) != 0) reversed += steps / (2 * bit);
    const std::size_t i = reversed * count / steps;
    if (i >= count || taken[i]) continue;
    taken[i] = true;
    order.push_back(i);
  }
  return order;
}

// Oriented photos: the nearest first, alternating with some from all over the block, because
// the approximation may be wrong by more than the nearest ones reach.
std::vector<std::size_t> LendersFor(std::size_t photo, const std::vector<BlockPhotoFile>& photos,
                                    const OrientationRow* approximation, std::size_t most) {
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (i == photo || !photos[i].HasPose()) continue;
    const double distance =
        approximation != nullptr
            ? (photos[i].exterior.pose->position_m - approximation->pose.position_m)
                  .head<2>()
                  .norm()
            : std::abs(static_cast<double>(i) - static_cast<double>(photo));
    by_distance.emplace_back(distance, i);
  }
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<std::size_t> anywhere = SpreadEvenly(photos.size());
  std::erase_if(anywhere, [&](std::size_t i) { return i == photo || !photos[i].HasPose(); });
  std::vector<std::size_t> lenders;
  const auto add = [&](std::size_t i) {
    if (lenders.size() < most && std::find(lenders.begin(), lenders.end(), i) == lenders.end())
      lenders.push_back(i);
  };
  for (std::size_t k = 0; k < by_distance.size() && lenders.size() < most; ++k) {
    add(by_distance[k].second);
    add(anywhere[k]);
  }
  return lenders;
}

}  // namespace

KeypointStage::OfPhoto KeypointStage::Find(const BlockPhotoFile& photo) const {
  const Camera& camera = setting_.camera.camera;
  const Raster raster = Raster::OpenScan(photo.path);
  const ScanInterior interior =
      camera.kind == CameraKind::kDigital
          ? DigitalGeometry(camera, raster)
          : FilmGeometry(setting_.camera, setting_.marks, raster,
                         InteriorResultPath(setting_.interior_directory, photo.name));
  OfPhoto found;
  found.positions = interior.positions;
  found.scan_px = {raster.Width(), raster.Height()};
  found.reduction = std::ceil(std::max(raster.Width(), raster.Height()) / kLongestSide_px);
  if (interior.positions.empty()) return found;
  ImageWindow window = raster.ReadGrey({0, 0, raster.Width(), raster.Height()}, found.reduction);
  if (interior.negative)
    for (float& value : window.image.values) value = -value;
  const Keypoints all = FindKeypoints(window.image, kMostKeypoints);
  const auto covered = CoveredAreas(setting_.camera, setting_.marks);
  std::vector<std::size_t> on_ground;
  for (std::size_t i = 0; i < all.Size(); ++i) {
    const Eigen::Vector2d pixel = window.RasterFromImage(all.pixels[i]);
    if (std::all_of(
            interior.positions.begin(), interior.positions.end(),
            [&](const exterior::FilmPosition& position) {
              const PhotoView view{camera, position.photo_from_pixel, {}, position.film_correction};
              return ShowsGround(view.PhotoFromPixel(pixel), camera, covered,
                                 kMargin_px * found.reduction * view.PixelSize());
            }))
      on_ground.push_back(i);
  }
  found.keypoints = all.Of(on_ground);
  for (Eigen::Vector2d& pixel : found.keypoints.pixels) pixel = window.RasterFromImage(pixel);
  return found;
}

void KeypointStage::Prepare(const Lenders& which, const std::vector<BlockPhotoFile>& photos) {
  std::vector<std::size_t> absent;
  for (const std::size_t i : which) {
    const auto known = std::find_if(kept_.begin(), kept_.end(),
                                    [i](const auto& photo) { return photo.first == i; });
    if (known != kept_.end())
      kept_.splice(kept_.begin(), kept_, known);
    else
      absent.push_back(i);
  }
  std::vector<OfPhoto> found(absent.size());
  tbb::task_arena arena(setting_.jobs > 0 ? std::min(setting_.jobs, kSearchedAtATime)
                                          : kSearchedAtATime);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, absent.size(), [&](std::size_t k) {
      try {
        found[k] = Find(photos[absent[k]]);
      } catch (const std::exception&) {  // one that cannot be read shows nothing
        RethrowIfMachineFault();
      }
    });
  });
  for (std::size_t k = 0; k < absent.size(); ++k)
    kept_.emplace_front(absent[k], std::make_shared<const OfPhoto>(std::move(found[k])));
  while (kept_.size() > kInMemory) kept_.pop_back();
}

std::shared_ptr<const KeypointStage::OfPhoto> KeypointStage::Of(
    std::size_t photo, const std::vector<BlockPhotoFile>& photos) {
  Prepare({photo}, photos);
  return kept_.front().second;
}

std::vector<exterior::SharedKeypoint> KeypointStage::Shared(
    const OfPhoto& photo, const OfPhoto& lender, const BlockPhotoFile& lender_file) const {
  std::vector<exterior::SharedKeypoint> shared;
  const PhotoView view = lender_file.View(setting_.camera.camera);
  for (const KeypointMatch& match : MatchKeypoints(photo.keypoints, lender.keypoints)) {
    const Eigen::Vector2d& pixel = lender.keypoints.pixels[match.second];
    if (const auto ground = view.GroundFromPixel(pixel, setting_.surface))
      shared.push_back({photo.keypoints.pixels[match.first], *ground, view.PhotoFromPixel(pixel)});
  }
  return shared;
}

std::optional<KeypointApproximation> KeypointStage::Search(
    std::size_t photo, const std::vector<BlockPhotoFile>& photos, const Lenders& lenders) {
  const std::shared_ptr<const OfPhoto> own = Of(photo, photos);
  if (own->positions.empty() || own->keypoints.Size() == 0) return std::nullopt;
  exterior::KeypointPoseOptions options;
  options.sigma_px = own->reduction;
  options.searches = static_cast<int>((lenders.size() + kAtATime - 1) / kAtATime);
  std::vector<exterior::SharedKeypoint> all;
  auto& known = shared_[photo];
  for (std::size_t begin = 0; begin < lenders.size(); begin += kAtATime) {
    const Lenders some(
        lenders.begin() + static_cast<std::ptrdiff_t>(begin),
        lenders.begin() + static_cast<std::ptrdiff_t>(std::min(begin + kAtATime, lenders.size())));
    Prepare(some, photos);
    for (const std::size_t i : some) {
      if (!known.contains(i)) known[i] = Shared(*own, *Of(i, photos), photos[i]);
      all.insert(all.end(), known[i].begin(), known[i].end());
    }
    const auto pose = exterior::PoseFromKeypoints(setting_.camera.camera, own->positions,
                                                  own->scan_px, all, options);
    if (!pose) continue;
    KeypointApproximation found{{photos[photo].name, pose->pose, {}}, pose->supporters};
    Vector6d sigma = kCommonErrors * pose->covariance.diagonal().cwiseSqrt();
    sigma.tail<3>() = sigma.tail<3>().cwiseMin(std::numbers::pi);
    // The film position, and with it kappa, is left to the photo's patches.
    if (own->positions.size() > 1) sigma[5] = std::numbers::pi;
    found.row.sigma = sigma;
    return found;
  }
  return std::nullopt;
}

Inputs KeypointStage::InputsOf(std::size_t photo, const std::vector<BlockPhotoFile>& photos,
                               const Lenders& lenders) const {
  Inputs lent;
  for (const std::size_t i : lenders) lent[photos[i].name] = DigestOfPhoto(photos[i]);
  Inputs inputs = setting_.inputs;
  inputs["method"] = kMethod;
  inputs["scan"] = DigestOfFile(photos[photo].path);
  if (setting_.camera.camera.kind == CameraKind::kFilm)
    inputs["interior"] =
        DigestOfContents(InteriorResultPath(setting_.interior_directory, photos[photo].name));
  inputs["lenders"] = DigestOf(lent);
  return inputs;
}

std::optional<KeypointApproximation> KeypointStage::Locate(
    std::size_t photo, const std::vector<BlockPhotoFile>& photos,
    const OrientationRow* approximation) {
  const Lenders lenders = LendersFor(photo, photos, approximation, kMostLenders);
  std::set<std::size_t>& asked = asked_[photo];
  if (std::all_of(lenders.begin(), lenders.end(), [&](std::size_t i) { return asked.contains(i); }))
    return std::nullopt;
  asked.insert(lenders.begin(), lenders.end());
  MakeOutputDirectory(store_.Folder());
  const Inputs inputs = InputsOf(photo, photos, lenders);
  // A photo is asked for more than once, with other lenders.
  const std::string request = photos[photo].name + "." + DigestOf(inputs);
  used_.insert(request);
  const std::string path = store_.PathOf(request);
  RunJobs(
      {{request, inputs, [&] { WriteKeypointResult(path, inputs, Search(photo, photos, lenders)); },
        [&] { ReadKeypointResult(path, photos[photo].name); }}},
      store_, {setting_.jobs});
  auto found = ReadKeypointResult(path, photos[photo].name);
  if (found)
    in_vain_.erase(photo);
  else
    in_vain_.insert(photo);
  return found;
}

void KeypointStage::RemoveUnused() const {
  for (const std::string& request : store_.Jobs())
    if (!used_.contains(request)) store_.Drop(request);
}

}  // namespace orient::block

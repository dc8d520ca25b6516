// Accuracy of tie points, and whether joint matching of all photos of a tie is better than matching
// each with the tie's owner:
//   tie_accuracy FOLDER
//
// Simulates a block of two strips of digital photos in FOLDER (kept: a second run is faster), with
// houses and trees, finds all ties with the true poses, and intersects their rays with these: root
// of v'v / (2 n - 3) of the intersections, in pixels per coordinate, with gross errors (above 1 px)
// counted separately. Prints by the number of rays: as matched with the owner; after rounds of
// joint matching (every photo's window with the mean of all others, as it should see them; Gruen &
// Baltsavias 1988 without the geometric constraint, which the adjustment has); and the difference
// of two photos matched with each other from their matches with the owner (closure).
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "block/ties/tie_matching.h"
#include "block/ties/tie_points.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/geometry/intersection.h"
#include "core/raster/raster.h"
#include "exterior/steps/match.h"
#include "tools/simulate/simulate.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr double kGross_px = 1;
constexpr int kMostRays = 6;
const block::TieOptions kTies;

void MakeBlock(const std::string& folder) {
  if (fs::exists(folder + "/truth.json")) return;
  SimulationOptions options;
  options.camera = CameraPreset::kDigital;
  options.seed = 5;
  options.gsd_m = 0.5;
  options.pixel_size_um = 80;
  options.photos = 6;
  options.strips = 2;
  options.overwrite = true;
  Simulate(options, folder);
}

struct Block {
  Camera camera;
  GroundSurface surface;
  std::vector<std::unique_ptr<Raster>> rasters;
  std::vector<std::unique_ptr<exterior::PhotoImage>> images;
  std::vector<block::TiePhoto> photos;
};

Block ReadBlock(const std::string& folder) {
  Block block{ReadCameraFile(folder + "/camera.toml").camera,
              GroundSurface::FromFile(folder + "/dem.tif", Crs::Parse("EPSG:32635", "dem")),
              {},
              {},
              {}};
  for (const OrientationRow& row : ReadOrientationTable(folder + "/truth/orientation.csv").rows) {
    block::TiePhoto to;
    to.name = row.photo;
    to.view.camera = block.camera;
    to.view.photo_from_pixel = DigitalPhotoFromPixel(block.camera);
    to.view.pose = row.pose;
    block.rasters.push_back(
        std::make_unique<Raster>(Raster::Open(folder + "/scans/" + row.photo + ".tif")));
    block.images.push_back(std::make_unique<exterior::PhotoImage>(*block.rasters.back(), false));
    to.image = block.images.back().get();
    block.photos.push_back(to);
  }
  return block;
}

// Intersection of the rays of a tie with the true poses; v'v in px^2.
std::optional<double> SquareOf(const Block& block, const block::MeasuredTie& tie) {
  const double px_mm = std::sqrt(std::abs(block.photos[0].view.photo_from_pixel.A.determinant()));
  std::vector<PhotoObservation> rays;
  for (const block::TieSighting& seen : tie.seen) {
    const PhotoView& view = block.photos[seen.photo].view;
    rays.push_back({&block.camera, view.pose, view.PhotoFromPixel(seen.pixel),
                    Eigen::Matrix2d::Identity() * px_mm * px_mm});
  }
  const auto met = IntersectPhotos(rays);
  if (!met) return std::nullopt;
  double sum = 0;
  for (const block::TieSighting& seen : tie.seen) {
    const auto pixel = block.photos[seen.photo].view.PixelFromGround(met->ground_m);
    if (!pixel) return std::nullopt;
    sum += (*pixel - seen.pixel).squaredNorm();
  }
  return sum;
}

// Matches the mean of the others' windows, as photo `to` should see them, in that photo; empty if
// not found.
std::optional<Eigen::Vector2d> MatchWithOthers(const Block& block, const block::MeasuredTie& tie,
                                               std::size_t to) {
  const block::TieSighting& here = tie.seen[to];
  const PhotoView& view = block.photos[here.photo].view;
  const auto ground = view.GroundFromPixel(here.pixel, block.surface);
  if (!ground) return std::nullopt;
  exterior::AlignedPatch mean;
  for (std::size_t i = 0; i < tie.seen.size(); ++i) {
    if (i == to) continue;
    const block::TiePhoto& from = block.photos[tie.seen[i].photo];
    const auto expected = from.view.PixelFromGround(*ground);
    if (!expected) return std::nullopt;
    exterior::AlignedPatch drawn =
        block::AlignWindow(block.photos[here.photo], from, block.surface, here.pixel,
                           tie.seen[i].pixel - *expected, kTies.template_px);
    if (mean.image.values.empty()) {
      mean = drawn;
      continue;
    }
    for (std::size_t k = 0; k < drawn.image.values.size(); ++k)
      mean.image.values[k] += drawn.image.values[k];
  }
  for (float& value : mean.image.values) {
    if (std::isnan(value)) return std::nullopt;
    value /= static_cast<float>(tie.seen.size() - 1);
  }
  exterior::PreciseOptions precise;
  precise.min_score = kTies.min_score;
  const exterior::PreciseMatch match =
      exterior::PreciseSearch(mean, *block.photos[here.photo].image, Eigen::Vector2d::Constant(3))
          .ByGrey(precise);
  if (!match.found) return std::nullopt;
  return match.pixel;
}

// Rounds of joint matching; false if a photo is lost.
bool MatchJointly(const Block& block, block::MeasuredTie* tie) {
  const double n = static_cast<double>(tie->seen.size());
  for (int round = 0; round < 2; ++round) {
    block::MeasuredTie next = *tie;
    for (std::size_t i = 0; i < tie->seen.size(); ++i) {
      const auto pixel = MatchWithOthers(block, *tie, i);
      if (!pixel) return false;
      // Relative to the mean of all, of which the photo itself is one.
      next.seen[i].pixel += (n - 1) / n * (*pixel - tie->seen[i].pixel);
    }
    *tie = next;
  }
  return true;
}

struct Tally {
  int ties = 0, gross = 0, lost = 0;
  double star = 0, joint = 0, redundancy = 0, closure = 0;
  int closures = 0;
};

// Closure between the last two rays, which were not matched with each other.
void AddClosure(const Block& block, const block::MeasuredTie& tie, Tally* tally) {
  if (tie.seen.size() < 3) return;
  block::MeasuredTie two = tie;
  two.seen.erase(two.seen.begin(), two.seen.end() - 2);
  const auto pixel = MatchWithOthers(block, two, 1);
  if (!pixel || (*pixel - two.seen[1].pixel).norm() > kGross_px) return;
  tally->closure += (*pixel - two.seen[1].pixel).squaredNorm() / 2;
  ++tally->closures;
}

void Add(const Block& block, const block::MeasuredTie& tie, Tally* tally) {
  const auto star = SquareOf(block, tie);
  const int redundancy = 2 * static_cast<int>(tie.seen.size()) - 3;
  if (!star || *star > kGross_px * kGross_px * redundancy) {
    ++tally->gross;
    return;
  }
  block::MeasuredTie jointly = tie;
  const auto joint = MatchJointly(block, &jointly) ? SquareOf(block, jointly) : std::nullopt;
  if (!joint) {
    ++tally->lost;
    return;
  }
  ++tally->ties;
  tally->redundancy += redundancy;
  tally->star += *star;
  tally->joint += *joint;
  AddClosure(block, tie, tally);
}

void Measure(const Block& block) {
  std::map<int, Tally> tallies;
  for (std::size_t owner = 0; owner < block.photos.size(); ++owner)
    for (const block::MeasuredTie& tie : block::FindTies(block.photos, owner, block.surface, kTies))
      Add(block, tie, &tallies[std::min(static_cast<int>(tie.seen.size()), kMostRays)]);
  std::printf("rays  ties gross  lost  with the owner px  jointly px  closure px\n");
  for (const auto& [rays, t] : tallies)
    std::printf("%4d %5d %5d %5d %18.3f %11.3f %11.3f\n", rays, t.ties, t.gross, t.lost,
                std::sqrt(t.star / t.redundancy), std::sqrt(t.joint / t.redundancy),
                t.closures > 0 ? std::sqrt(t.closure / t.closures) : 0.0);
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "tie_accuracy FOLDER\n");
    return 1;
  }
  try {
    orient::MakeBlock(argv[1]);
    orient::Measure(orient::ReadBlock(argv[1]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}

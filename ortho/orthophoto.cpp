#include "ortho/orthophoto.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <memory>

#include "core/base/error.h"
#include "core/base/side_by_side.h"
#include "core/geometry/rotation.h"
#include "core/terrain/footprint.h"
#include "core/terrain/view_over_ground.h"
#include "ortho/new_cog.h"
#include "ortho/rectifier.h"

namespace orient::ortho {
namespace {

struct Count {
  std::atomic<std::int64_t> seen = 0, hidden = 0;
};

std::vector<std::uint8_t> MaskOf(const std::vector<Shown>& shown, Shown which, std::uint8_t value) {
  std::vector<std::uint8_t> mask(shown.size());
  std::transform(shown.begin(), shown.end(), mask.begin(),
                 [&](Shown one) { return one == which ? value : std::uint8_t{0}; });
  return mask;
}

// The map of hidden ground; made when the first tile has some.
class HiddenMap {
 public:
  HiddenMap(std::string path, const MapGrid& grid, const Crs& crs)
      : path_(std::move(path)), grid_(grid), crs_(crs) {}

  void Write(const OrthoTile& tile) {
    Image values(tile.window.width, tile.window.height);
    std::transform(tile.shown.begin(), tile.shown.end(), values.values.begin(),
                   [](Shown one) { return one == Shown::kHidden ? 1.0f : 0.0f; });
    {
      const std::lock_guard lock(mutex_);
      constexpr int kByte = 1, kGrey = 1;  // GDT_Byte, GCI_GrayIndex
      const BandFormat byte = {1, kByte, 8, {kGrey}};
      if (!file_) file_ = std::make_unique<NewCog>(path_, byte, grid_, crs_);
    }
    file_->Write(tile.window, {values}, std::vector<std::uint8_t>(tile.shown.size(), 255));
  }
  // If nothing is hidden, the file of an earlier run is removed.
  void Finish(const std::map<std::string, std::string>& metadata, int threads) {
    std::error_code ignored;
    if (file_)
      file_->Finish(metadata, threads);
    else
      std::filesystem::remove(path_, ignored);
  }

 private:
  std::string path_;
  MapGrid grid_;
  Crs crs_;
  std::mutex mutex_;
  std::unique_ptr<NewCog> file_;
};

void DrawTiles(const Rectifier& rectifier, const MapGrid& grid, const std::string& name,
               NewCog* image, HiddenMap* hidden, Count* count, ProgressListener* listener) {
  const std::vector<PixelWindow> tiles = TilesOf(grid);
  ProgressTask progress(listener, "orthophoto of " + name, static_cast<int>(tiles.size()));
  SideBySide(tiles.size(), [&](std::size_t i) {
    const OrthoTile tile = rectifier.Draw(grid, tiles[i]);
    const auto many = [&](Shown which) {
      return std::count(tile.shown.begin(), tile.shown.end(), which);
    };
    if (many(Shown::kSeen) > 0)
      image->Write(tile.window, tile.values, MaskOf(tile.shown, Shown::kSeen, 255));
    if (many(Shown::kHidden) > 0) hidden->Write(tile);
    count->seen += many(Shown::kSeen);
    count->hidden += many(Shown::kHidden);
    progress.Advance();
  });
}

std::map<std::string, std::string> MetadataOf(const OrientedPhoto& photo,
                                              const OrthoOptions& options,
                                              const std::optional<GroundAccuracy>& accuracy) {
  std::map<std::string, std::string> metadata = options.metadata;
  metadata["ORIENT_PHOTO"] = photo.name;
  metadata["ORIENT_DEM"] = std::filesystem::path(options.dem).filename().string();
  metadata["ORIENT_GSD_M"] = fmt::format("{:.9g}", options.gsd_m);
  if (accuracy) {
    metadata["ORIENT_CE90_MEDIAN_M"] = fmt::format("{:.4g}", accuracy->median_m);
    metadata["ORIENT_CE90_WORST_M"] = fmt::format("{:.4g}", accuracy->worst_m);
  }
  const Eigen::Vector3d& at_m = photo.view.pose.position_m;
  const Eigen::Vector3d angles_deg = photo.view.pose.opk_rad.unaryExpr(
      [](double angle_rad) { return DegFromRad(NormalizeAngle(angle_rad)); });
  metadata["ORIENT_NADIR"] = fmt::format("{:.3f} {:.3f}", at_m.x(), at_m.y());
  metadata["ORIENT_POSE"] =
      fmt::format("{:.4f} {:.4f} {:.4f} {:.9f} {:.9f} {:.9f}", at_m.x(), at_m.y(), at_m.z(),
                  angles_deg.x(), angles_deg.y(), angles_deg.z());
  return metadata;
}

}  // namespace

std::string HiddenPath(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".hidden.tif").string();
}

GroundSurface SurfaceUnderPhoto(const PhotoView& view, const std::string& dem, const Crs& crs) {
  const auto read = [&](double lowest, double highest) {
    const auto bounds = FootprintBounds(view.camera, view.pose, lowest, highest);
    return GroundSurface::FromFile(dem, crs, bounds);
  };
  const GroundSurface wide = read(kLowestGround_m, kHighestGround_m);
  return read(wide.MinHeight(), wide.MaxHeight());
}

double NaturalGsd(const PhotoView& view, const GroundSurface& surface) {
  return view.GroundPixel(GroundHeightUnder(surface, view.camera, view.pose));
}

OrthoPlan PlanOrthophoto(const OrientedPhoto& photo, const OrthoOptions& options) {
  const GroundSurface surface = SurfaceUnderPhoto(photo.view, options.dem, options.crs);
  PhotoView shown = photo.view;
  shown.camera.frame_mm.array() -= 2 * options.border_mm;
  const auto bounds = ShownGround(shown, surface);
  if (!bounds)
    throw InputError(fmt::format("{}: {} shows no ground that {} has heights of", photo.scan,
                                 photo.name, options.dem));
  constexpr double kMostPixels = 1e11;
  const double pixels = (bounds->max_x - bounds->min_x) / options.gsd_m *
                        ((bounds->max_y - bounds->min_y) / options.gsd_m);
  if (!(pixels < kMostPixels))
    throw InputError(
        fmt::format("{}: its orthophoto would have {:.0e} pixels of {:g} m; give a "
                    "larger pixel size",
                    photo.scan, pixels, options.gsd_m));
  OrthoPlan plan{MapGrid::Around(*bounds, options.gsd_m), {}, {}};
  plan.with_heights = ShareWithHeights(surface, shown.camera, shown.pose);
  if (photo.covariance)
    plan.accuracy = AccuracyOf(shown, *photo.covariance, surface, options.height_sigma_m);
  for (const Eigen::Vector3d& point : Footprint(shown, surface))
    plan.outline_m.emplace_back(point.head<2>());
  return plan;
}

OrthoShares MakeOrthophoto(const OrientedPhoto& photo, const OrthoOptions& options,
                           const OrthoPlan& plan, const std::string& path,
                           ProgressListener* listener) {
  const BandRaster scan = BandRaster::Open(photo.scan);
  if (photo.negative && !scan.Format().IsUnsigned())
    throw InputError(photo.scan +
                     ": is a negative whose values are not unsigned ones of 8 or 16 "
                     "bits, so that their range is not known; convert it with gdal_translate "
                     "-ot UInt16 -scale MIN MAX 0 65535");
  const GroundSurface surface = SurfaceUnderPhoto(photo.view, options.dem, options.crs);
  const Rectifier rectifier(photo.view, surface, scan,
                            {options.border_mm, photo.marks, photo.negative});
  NewCog image(path, scan.Format(), plan.grid, options.crs);
  HiddenMap hidden(HiddenPath(path), plan.grid, options.crs);
  Count count;
  OnThreads(options.threads, [&] {
    DrawTiles(rectifier, plan.grid, photo.name, &image, &hidden, &count, listener);
  });
  if (count.seen == 0)
    throw InputError(
        fmt::format("{}: at a pixel of {:g} m, and without {:g} mm of the frame's border, {} shows "
                    "nothing of {}",
                    photo.scan, options.gsd_m, options.border_mm, photo.name, options.dem));
  auto metadata = MetadataOf(photo, options, plan.accuracy);
  metadata[kWithHeights] = fmt::format("{:.4g}", plan.with_heights);
  metadata[kHasHidden] = count.hidden > 0 ? "yes" : "no";
  // The image comes last: a continued run takes it as the sign that everything is there.
  hidden.Finish(metadata, options.threads);
  image.Finish(metadata, options.threads);
  const double all = static_cast<double>(plan.grid.width) * plan.grid.height;
  return {static_cast<double>(count.seen) / all, static_cast<double>(count.hidden) / all};
}

}  // namespace orient::ortho

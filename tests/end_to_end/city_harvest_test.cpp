// What a harvest accepts on a simulated city whose roofs and crowns are known, and how honest its
// ground points' covariances are where orientation and DEM err by known amounts.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <iostream>
#include <map>

#include "core/terrain/photo_view.h"
#include "patchdb/harvest/further_views.h"
#include "tests/end_to_end/simulated_city.h"

namespace orient {
namespace {

using namespace simulation;  // NOLINT: the city is made of its parts

// How far orientations and DEM may be wrong: as little as in the files.
const std::vector<std::string> kPrecise = {"--dem-sigma-m", "0.15"};

struct Share {
  int patches = 0, standing = 0;
  std::array<int, 5> by_height = {};  // up to 1, 2, 4, 8 m, higher
  double Percent() const { return 100.0 * standing / std::max(patches, 1); }
};

Share StandingAmong(const City& city, const Harvested& harvested, int least_views) {
  Share share;
  for (const patchdb::Patch& patch : harvested.patches) {
    if (patch.views < least_views) continue;
    ++share.patches;
    const double height = city.HeightShown(patch, harvested.sources.at(patch.source_id));
    if (!(height > kStanding)) continue;
    ++share.standing;
    ++share.by_height[height < 1 ? 0 : height < 2 ? 1 : height < 4 ? 2 : height < 8 ? 3 : 4];
  }
  return share;
}

class SlowCityHarvest : public testing::Test {
 protected:
  static void SetUpTestSuite() { city_ = std::make_unique<City>(); }
  static void TearDownTestSuite() { city_.reset(); }
  static std::unique_ptr<City> city_;
};
std::unique_ptr<City> SlowCityHarvest::city_;

TEST_F(SlowCityHarvest, OverlappingPhotosRefuseRoofsAndCrowns) {
  const auto patches = city_->HarvestPhotos("photo_*.tif", "true.csv", "dem.tif", kPrecise);
  const Share all = StandingAmong(*city_, patches, 1), twice = StandingAmong(*city_, patches, 2);
  const auto blind =
      city_->HarvestPhotos("photo_*.tif", "true.csv", "dem.tif", {"--further-views", "0"});
  const Share before = StandingAmong(*city_, blind, 1);
  std::cout << "without views " << before.Percent() << " % of " << before.patches << ", all "
            << all.Percent() << " % of " << all.patches << ", seen twice " << twice.Percent()
            << " % of " << twice.patches << "; by height up to 1, 2, 4, 8 m and higher";
  for (const int count : twice.by_height) std::cout << " " << count;
  for (int views = 3; views <= 5; ++views) {
    const Share more = StandingAmong(*city_, patches, views);
    std::cout << "; in " << views << " and more " << more.Percent() << " % of " << more.patches;
  }
  std::cout << "\n";
  EXPECT_GT(before.Percent(), 10);  // else the city is no test
  EXPECT_GT(twice.patches, 500);
  // Not the 2 % that a surface model brings: a roof that resembles something near the place where
  // the ground would lie in the other photo is taken for it. Measured: 9.5 %, of 63 % candidates.
  EXPECT_LE(twice.Percent(), 11);
}

TEST_F(SlowCityHarvest, ASurfaceModelRefusesThemInSinglePhotosAndOrthophotos) {
  const std::vector<std::string> dsm = {"--dsm", city_->folder / "dsm.tif"};
  const Share photo =
      StandingAmong(*city_, city_->HarvestPhotos("photo_01.tif", "true.csv", "dem.tif", dsm), 1);
  const Share block =
      StandingAmong(*city_, city_->HarvestPhotos("photo_*.tif", "true.csv", "dem.tif", dsm), 1);
  const Share ortho = StandingAmong(
      *city_,
      city_->Harvest({"harvest-ortho", "--ortho", city_->folder / "ortho.tif", "--dem",
                      city_->folder / "dem.tif", "--dsm", city_->folder / "dsm.tif"}),
      1);
  std::cout << "with a DSM: one photo " << photo.Percent() << " % of " << photo.patches
            << ", all photos " << block.Percent() << " % of " << block.patches << ", orthophoto "
            << ortho.Percent() << " % of " << ortho.patches << "\n";
  EXPECT_GT(photo.patches, 50);
  EXPECT_GT(ortho.patches, 100);
  EXPECT_LE(photo.Percent(), 2);
  EXPECT_LE(block.Percent(), 2);
  EXPECT_LE(ortho.Percent(), 2);
}

// A photo as the harvest knew it: with the orientation of its table.
struct OwnPhoto {
  Raster raster;
  std::unique_ptr<patchdb::SourceView> view;
};

std::map<std::string, OwnPhoto> OwnPhotos(const City& city, const OrientationTable& table,
                                          const GroundSurface& surface) {
  const Camera& camera = city.camera.file.camera;
  std::map<std::string, OwnPhoto> photos;
  for (const PlannedPhoto& photo : city.photos) {
    const PhotoView view{camera, DigitalPhotoFromPixel(camera), table.Find(photo.name)->pose};
    photos.emplace(photo.name,
                   OwnPhoto{Raster::Open(city.folder / (photo.name + ".tif")),
                            patchdb::MakePhotoSource(view, std::nullopt, 0.5, surface)});
  }
  return photos;
}

// Where the ground point that a chip's middle shows truly lies: the chip is sought in the photo
// that it was cut from, and the true ray of that place followed.
std::optional<Eigen::Vector3d> TruthOf(const City& city, const patchdb::Patch& patch,
                                       const OwnPhoto& own, const std::string& name) {
  patchdb::MatchOptions options;
  options.template_px = 31;  // the patch's heights reach no further than the chip
  options.radius_px = 10;    // of the orientation's error
  options.min_score = 0.9;
  options.min_score_gap = 0;
  const auto shown = patchdb::FindIn({&own.raster, own.view.get(), nullptr, 0}, patch, options);
  if (!shown) return std::nullopt;
  const Camera& camera = city.camera.file.camera;
  const auto ray = *GroundRayFromPhoto(camera, city.Photo(name)->pose,
                                       DigitalPhotoFromPixel(camera) * shown->pixel);
  return MeetGround(
      city.terrain, ray.origin_m,
      {-ray.direction.x() / ray.direction.z(), -ray.direction.y() / ray.direction.z()}, 250);
}

TEST_F(SlowCityHarvest, GroundPointsAreAsPreciseAsTheySay) {
  constexpr double kPosition_m = 0.15, kAngle_rad = 1e-4, kHeight_m = 0.5;
  struct Sum {
    double squares = 0;
    int count = 0;
  };
  std::array<Sum, 4> by_views;  // three and more are one
  double sum = 0, largest = 0;
  int count = 0, blunders = 0, lost = 0;
  for (unsigned draw = 1; draw <= 6; ++draw) {
    city_->WriteTable("wrong.csv", kPosition_m, kAngle_rad, draw);
    city_->WriteHeights("wrong.tif", kDemCell, false, kHeight_m, draw);
    const GroundSurface surface = GroundSurface::FromFile(city_->folder / "wrong.tif", city_->crs);
    const auto own = OwnPhotos(*city_, ReadOrientationTable(city_->folder / "wrong.csv"), surface);
    const auto [patches, sources] = city_->HarvestPhotos(
        "photo_*.tif", "wrong.csv", "wrong.tif",
        {"--max-per-photo", "150", "--dsm", city_->folder / "dsm.tif", "--max-lean-px", "8"});
    for (const patchdb::Patch& patch : patches) {
      const std::string& source = sources.at(patch.source_id);
      const auto truth = TruthOf(*city_, patch, own.at(source), source);
      lost += truth ? 0 : 1;
      if (!truth) continue;
      const Eigen::Vector3d error = patch.ground_m - *truth;
      const double squared = error.dot(patch.covariance_m2.inverse() * error);
      sum += squared;
      largest = std::max(largest, squared);
      blunders += squared > 40 ? 1 : 0;  // 1 in 10^8
      if (squared > 30)
        std::cout << "draw " << draw << ", patch " << patch.id << " of " << source << ", "
                  << patch.views << " views: off " << error.transpose() << " m, sigmas "
                  << patch.covariance_m2.diagonal().cwiseSqrt().transpose() << ", chi-square "
                  << squared << ", standing " << city_->HeightShown(patch, source) << " m, lean "
                  << patch.lean_px.value_or(-1) << " px, quality " << patch.quality.value_or(-1)
                  << "\n";
      Sum& of = by_views[static_cast<std::size_t>(std::min(patch.views, 3))];
      of.squares += squared;
      of.count += 3;
      count += 3;
    }
  }
  const double rms = std::sqrt(sum / count);
  std::cout << "normalised errors " << rms << ", largest chi-square " << largest << ", "
            << count / 3 << " patches, blunders " << blunders << ", not found in their own photo "
            << lost << "\n";
  for (std::size_t views = 1; views < by_views.size(); ++views)
    std::cout << by_views[views].count / 3 << " patches of " << views
              << (views == 3 ? " and more" : "") << " views: normalised errors "
              << std::sqrt(by_views[views].squares / std::max(by_views[views].count, 1)) << "\n";
  EXPECT_GT(count, 1500);
  EXPECT_LE(lost, count / 300);
  EXPECT_GT(rms, 0.8);
  EXPECT_LT(rms, 1.25);
  EXPECT_EQ(blunders, 0);
}

}  // namespace
}  // namespace orient

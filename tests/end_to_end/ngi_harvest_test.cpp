// Patches harvested from the four real NGI photos and from their orthophotos, drawn back into every
// other photo that sees them, at the published orientation.
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <iostream>
#include <map>
#include <set>

#include "block/inputs/photo_interior.h"
#include "exterior/steps/match.h"
#include "patchdb/harvest/patch_quality.h"
#include "patchdb/store/patch_database.h"
#include "tests/support/ngi.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr std::array<const char*, 4> kPhotos = {"0182", "0184", "0251", "0253"};
constexpr double kRadiusPx = 8;  // far enough for a blunder to be seen as one

struct DrawnBack {
  int seen = 0, matched = 0, within_half = 0, good = 0, good_beyond_three = 0;
  // Of patches that their source's own photo shows, too: as they stand, and from where it has them.
  int own = 0, own_within_half = 0, mended_within_half = 0;
  int several = 0, several_within_half = 0;  // of patches that several sources show
  double SeveralPercent() const { return 100.0 * several_within_half / std::max(several, 1); }
  double HalfPercent() const { return 100.0 * within_half / std::max(matched, 1); }
  double OwnPercent() const { return 100.0 * own_within_half / std::max(own, 1); }
  double MendedPercent() const { return 100.0 * mended_within_half / std::max(own, 1); }
};

struct SeenPhoto {
  std::string name;  // of its source, photo or orthophoto
  Raster raster;
  PhotoView view;
};

class SlowNgiHarvest : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = SharedData("ngi");
    if (!folder) GTEST_SKIP() << "real data absent (ORIENT_SHARED_DATA): ngi";
    ngi_ = std::make_unique<Ngi>(*folder);
    Run({"patchdb", "create", database_, "--crs", ngi_->CrsFile()});
  }

  static void Run(const std::vector<std::string>& words) {
    const ProgramRun done = RunOrient(words);
    ASSERT_EQ(done.exit_code, 0) << done.err;
    std::cout << done.out;
  }

  // With their orthophotos' names where those are the sources.
  std::vector<SeenPhoto> Photos(bool orthophotos) const {
    std::vector<SeenPhoto> photos;
    for (const char* number : kPhotos) {
      const std::string path = ngi_->Photo(number);
      const std::string source = orthophotos ? ngi_->Orthophoto(number) : path;
      photos.push_back({source.substr(source.rfind('/') + 1), Raster::Open(path),
                        PhotoView{ngi_->camera.camera, DigitalPhotoFromPixel(ngi_->camera.camera),
                                  ngi_->Published(number).pose}});
    }
    return photos;
  }

  void HarvestOrthophotos(const std::vector<std::string>& more) {
    std::vector<std::string> words = {
        "patchdb", "harvest-ortho",          database_, "--further-views", "4",
        "--dem",   ngi_->folder + "/dem.tif"};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--ortho", ngi_->folder + "/orthos/*.tif"});
    Run(words);
  }

  DrawnBack DrawBack(bool orthophotos) const {
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(database_, patchdb::PatchDatabase::Mode::kRead);
    std::map<std::int64_t, std::string> names;
    for (const patchdb::PatchSource& source : database.Sources()) names[source.id] = source.name;
    const auto photos = Photos(orthophotos);
    const auto patches = database.ListPatches(0, 100000);
    DrawnBack result;
    std::map<std::int64_t, Eigen::Vector3d> places;
    for (const SeenPhoto& photo : photos) {
      const exterior::PhotoImage image(photo.raster, false);
      for (const patchdb::Patch& patch : patches)
        if (names[patch.source_id] == photo.name)
          if (const auto place = PlaceInOwnPhoto(patch, photo, image)) places[patch.id] = *place;
    }
    for (const SeenPhoto& photo : photos) {
      const exterior::PhotoImage image(photo.raster, false);
      for (const patchdb::Patch& patch : patches)
        if (names[patch.source_id] != photo.name)
          Draw(patch, photo, image, places.contains(patch.id) ? &places[patch.id] : nullptr,
               &result);
    }
    return result;
  }

  // Where the photo that the source was made from has what the chip shows: its ray on the DEM.
  std::optional<Eigen::Vector3d> PlaceInOwnPhoto(const patchdb::Patch& patch,
                                                 const SeenPhoto& photo,
                                                 const exterior::PhotoImage& image) const {
    const auto match = Find(patch, photo, image);
    if (!match || !match->found) return std::nullopt;
    return photo.view.GroundFromPixel(match->pixel, ngi_->surface);
  }

  // Empty where the photo does not show the patch.
  static std::optional<exterior::PreciseMatch> Find(const patchdb::Patch& patch,
                                                    const SeenPhoto& photo,
                                                    const exterior::PhotoImage& image) {
    constexpr double kInside = 40;
    const auto pixel = photo.view.PixelFromGround(patch.ground_m);
    if (!pixel || pixel->x() < kInside || pixel->y() < kInside ||
        pixel->x() > image.Width() - kInside || pixel->y() > image.Height() - kInside)
      return std::nullopt;
    const auto aligned = exterior::AlignPatch(photo.view, patch, 1, 21, 61);
    if (!aligned) return std::nullopt;
    return exterior::PreciseSearch(*aligned, image, Eigen::Vector2d::Constant(kRadiusPx))
        .ByGrey({});
  }

  // `own_place`: PlaceInOwnPhoto, where there is one.
  static void Draw(const patchdb::Patch& patch, const SeenPhoto& photo,
                   const exterior::PhotoImage& image, const Eigen::Vector3d* own_place,
                   DrawnBack* result) {
    const auto match = Find(patch, photo, image);
    if (!match) return;
    ++result->seen;
    if (!match->found) return;
    ++result->matched;
    const double off = (match->pixel - *photo.view.PixelFromGround(patch.ground_m)).norm();
    result->within_half += off <= 0.5 ? 1 : 0;
    result->several += patch.views > 1 ? 1 : 0;
    result->several_within_half += patch.views > 1 && off <= 0.5 ? 1 : 0;
    const auto mended =
        own_place == nullptr ? std::nullopt : photo.view.PixelFromGround(*own_place);
    if (mended) {
      ++result->own;
      result->own_within_half += off <= 0.5 ? 1 : 0;
      result->mended_within_half += (match->pixel - *mended).norm() <= 0.5 ? 1 : 0;
    }
    const bool good = patch.quality.value_or(0) >= patchdb::kGoodQuality;
    result->good += good ? 1 : 0;
    result->good_beyond_three += good && off > 3 ? 1 : 0;
  }

  // Cells of 1 km of which the photos show at least half, chip and all, and those with a patch.
  void CountCells(int* covered, int* filled) const {
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(database_, patchdb::PatchDatabase::Mode::kRead);
    const Bounds extent = database.Info().extent;
    std::set<std::pair<int, int>> with_patch;
    const auto cell_of = [](double metres) { return static_cast<int>(std::floor(metres / 1000)); };
    for (const patchdb::Patch& patch : database.ListPatches(0, 100000))
      with_patch.insert({cell_of(patch.ground_m.x()), cell_of(patch.ground_m.y())});
    const auto photos = Photos(false);
    *covered = *filled = 0;
    for (int row = cell_of(extent.min_y) - 1; row <= cell_of(extent.max_y) + 1; ++row)
      for (int col = cell_of(extent.min_x) - 1; col <= cell_of(extent.max_x) + 1; ++col) {
        int seen = 0;
        for (int y = 50; y < 1000; y += 100)
          for (int x = 50; x < 1000; x += 100) seen += Seen(photos, col * 1000 + x, row * 1000 + y);
        if (seen < 50) continue;
        ++*covered;
        *filled += with_patch.contains({col, row}) ? 1 : 0;
      }
  }

  int Seen(const std::vector<SeenPhoto>& photos, double x, double y) const {
    const auto height = ngi_->surface.HeightAt(x, y);
    if (!height) return 0;
    constexpr double kInside = 31;
    return std::any_of(photos.begin(), photos.end(), [&](const SeenPhoto& photo) {
      const auto pixel = photo.view.PixelFromGround({x, y, *height});
      return pixel && pixel->minCoeff() > kInside && pixel->x() < photo.raster.Width() - kInside &&
             pixel->y() < photo.raster.Height() - kInside;
    });
  }

  static void Print(const char* what, const DrawnBack& back) {
    std::cout << what << ": drawn " << back.seen << " times, matched " << back.matched
              << ", within 0.5 px " << back.HalfPercent() << " %, of " << back.good
              << " good ones beyond 3 px " << back.good_beyond_three << "; of " << back.own
              << " found in the source's own photo, too, " << back.OwnPercent() << " %, and "
              << back.MendedPercent() << " % from where that one has them; of " << back.several
              << " of patches that several sources show " << back.SeveralPercent() << " %\n";
  }

  TemporaryFolder folder_;
  std::string database_ = folder_ / "ngi.gpkg";
  std::unique_ptr<Ngi> ngi_;
};

TEST_F(SlowNgiHarvest, PatchesOfPhotosLieWhereTheOtherPhotosShowThem) {
  Run({"patchdb", "harvest", database_, "--camera", ngi_->folder + "/camera.toml", "--orientation",
       ngi_->folder + "/published_orientation.csv", "--dem", ngi_->folder + "/dem.tif",
       "--further-views", "4", ngi_->folder + "/photos/*.tif"});
  const DrawnBack back = DrawBack(false);
  Print("photos", back);
  EXPECT_GE(back.matched, 400);
  EXPECT_GE(back.HalfPercent(), 90);
  EXPECT_EQ(back.good_beyond_three, 0);
  int covered = 0, filled = 0;
  CountCells(&covered, &filled);
  std::cout << filled << " of " << covered << " cells of 1 km have a patch\n";
  EXPECT_GT(covered, 50);
  EXPECT_EQ(filled, covered);
}

TEST_F(SlowNgiHarvest, PatchesOfOrthophotosLieWhereTheOtherPhotosShowThem) {
  HarvestOrthophotos({});
  const DrawnBack back = DrawBack(true);
  Print("orthophotos", back);
  EXPECT_GE(back.matched, 400);
  // The orthophotos were made with other heights than this DEM, which the adjustment of all
  // orthophotos of a place finds. Measured: 95 %, as many as from where their own photos have them.
  EXPECT_GE(back.HalfPercent(), 90);
  EXPECT_GE(back.MendedPercent(), 90);
  EXPECT_EQ(back.good_beyond_three, 0);
}

// The user may know better than a tenth of the DEM's cell how wrong the orthophotos' heights are.
TEST_F(SlowNgiHarvest, OrthophotosWhoseHeightsAreTrustedLessAreIntersectedMore) {
  for (const char* sigma_m : {"5", "10"}) {
    std::filesystem::remove(database_);
    Run({"patchdb", "create", database_, "--crs", ngi_->CrsFile()});
    HarvestOrthophotos({"--dem-sigma-m", sigma_m});
    const DrawnBack back = DrawBack(true);
    Print("orthophotos", back);
    EXPECT_GE(back.matched, 400);
    EXPECT_GE(back.HalfPercent(), 60);
    EXPECT_EQ(back.good_beyond_three, 0);
  }
}

}  // namespace
}  // namespace orient

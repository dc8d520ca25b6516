#include "ortho/seamlines.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>
#include <rapidcheck.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "tests/support/expect_error.h"
#include "tests/support/generators.h"
#include "tests/support/shared_data.h"

namespace orient::ortho {
namespace {

using Eigen::Vector2d;

SeamPhoto Square(const std::string& name, const Vector2d& nadir, double half) {
  std::vector<Vector2d> outline;
  for (const Vector2d& corner :
       {Vector2d(-1, -1), Vector2d(1, -1), Vector2d(1, 1), Vector2d(-1, 1), Vector2d(-1, -1)})
    outline.emplace_back(nadir + half * corner);
  return {name, nadir, outline};
}

bool Shows(const SeamPhoto& photo, double half, const Vector2d& at) {
  return (at - photo.nadir_m).cwiseAbs().maxCoeff() < half;
}

const Crs kCrs = Crs::Parse("EPSG:32635", "test");

TEST(Seamlines, GiveEveryPlaceToThePhotoOfTheNearestNadirThatShowsIt) {
  EXPECT_TRUE(rc::check("at every pixel", [] {
    constexpr double kHalf = 300;
    std::vector<SeamPhoto> photos;
    const int count = *rc::gen::inRange(1, 7);
    for (int i = 0; i < count; ++i)
      photos.push_back(
          Square("p" + std::to_string(i), {*InRange(0, 800), *InRange(0, 800)}, kHalf));
    const Seamlines seamlines = Seamlines::ByNearestNadir(photos);
    const MapGrid grid = MapGrid::Around({-300, -300, 1100, 1100}, 20);
    const std::vector<int> labels = seamlines.PhotoAt(grid, {0, 0, grid.width, grid.height});
    for (int row = 0, i = 0; row < grid.height; ++row)
      for (int col = 0; col < grid.width; ++col, ++i) {
        const Vector2d at = grid.GroundFromPixel(col + 0.5, row + 0.5);
        std::string nearest;
        double best = 1e300;
        for (const SeamPhoto& photo : photos)
          if (Shows(photo, kHalf, at) && (at - photo.nadir_m).norm() < best)
            best = (at - photo.nadir_m).norm(), nearest = photo.name;
        const int label = labels[static_cast<std::size_t>(i)];
        RC_ASSERT((label < 0 ? "" : seamlines.Photos()[static_cast<std::size_t>(label)]) ==
                  nearest);
      }
  }));
}

TEST(Seamlines, OfTwoPhotosFromOnePlaceTheFirstIsTaken) {
  const auto seamlines =
      Seamlines::ByNearestNadir({Square("a", {0, 0}, 100), Square("b", {0, 0}, 100)});
  EXPECT_EQ(seamlines.Photos(), std::vector<std::string>{"a"});
}

TEST(Seamlines, ComeBackFromTheirFile) {
  const TemporaryFolder folder;
  const auto written = Seamlines::ByNearestNadir(
      {Square("with blank", {0, 0}, 100), Square("Müller's \"2\"", {120, 30}, 100)});
  written.Write(folder / "seamlines.gpkg", kCrs);
  const auto read = Seamlines::FromFile(folder / "seamlines.gpkg", kCrs);
  EXPECT_EQ(read.Photos(), written.Photos());
  const MapGrid grid = MapGrid::Around({-150, -150, 250, 250}, 1);
  const PixelWindow part{30, 40, 300, 250};
  EXPECT_EQ(read.PhotoAt(grid, part), written.PhotoAt(grid, part));
  const std::string once = ReadFile(folder / "seamlines.gpkg");
  written.Write(folder / "seamlines.gpkg", kCrs);
  EXPECT_EQ(ReadFile(folder / "seamlines.gpkg"), once) << "no day of writing";
}

TEST(Seamlines, FileSaysWhatItWasMadeFrom) {
  const TemporaryFolder folder;
  const Seamlines lines = Seamlines::ByNearestNadir({Square("4711", {50, 50}, 50)});
  const std::string path = folder / "seamlines.gpkg";
  lines.Write(path, kCrs, {{"orient_ortho", "{\"program\":\"orient 1\"}"}});
  const std::string once = ReadFile(path);
  lines.Write(path, kCrs, {{"orient_ortho", "{\"program\":\"orient 1\"}"}});
  EXPECT_EQ(ReadFile(path), once);
  const GDALDatasetUniquePtr file = OpenVectorDataset(path);
  ASSERT_TRUE(file);
  EXPECT_STREQ(file->GetMetadataItem("orient_ortho"), "{\"program\":\"orient 1\"}");
  EXPECT_EQ(Seamlines::FromFile(path, kCrs).Photos().size(), 1u);
}

// As somebody draws them by hand: one polygon over others, other fields, in GeoJSON.
TEST(Seamlines, OfPolygonsThatOverlapTheFirstCounts) {
  const TemporaryFolder folder;
  const auto square = [](const std::string& photo, int to) {
    const std::string s = std::to_string(to);
    return R"({"type": "Feature", "properties": {"note": 1, "photo": ")" + photo +
           R"("}, "geometry": {"type": "Polygon", "coordinates": [[[500000, 5000000], [50000)" + s +
           ", 5000000], [50000" + s + ", 500000" + s + "], [500000, 500000" + s +
           "], [500000, 5000000]]]}}";
  };
  const std::string path = folder / "edited.geojson";
  WriteFileAtomically(path,
                      R"({"type": "FeatureCollection", "name": "seamlines", "crs": {"type": "name",
      "properties": {"name": "urn:ogc:def:crs:EPSG::32635"}}, "features": [)" +
                          square("small", 2) + ", " + square("large", 4) + "]}");
  const auto seamlines = Seamlines::FromFile(path, kCrs);
  const MapGrid grid = MapGrid::Around({500000, 5000000, 500005, 5000001}, 1);
  EXPECT_EQ(seamlines.PhotoAt(grid, {0, 0, 5, 1}), (std::vector<int>{0, 0, 1, 1, -1}));
  ExpectError<InputError>([&] { Seamlines::FromFile(path, Crs::Parse("EPSG:32636", "test")); },
                          {"edited.geojson", "another CRS"});
}

TEST(Seamlines, AFileWithoutThemIsRefused) {
  const TemporaryFolder folder;
  ExpectError<InputError>([&] { Seamlines::FromFile(folder / "none.gpkg", kCrs); }, {"none.gpkg"});
  const std::string path = folder / "other.geojson";
  WriteFileAtomically(path, R"({"type": "FeatureCollection", "name": "areas", "features": []})");
  ExpectError<InputError>([&] { Seamlines::FromFile(path, kCrs); },
                          {"other.geojson", "no layer \"seamlines\""});
}

// GeoPackage has curves; GeoJSON has none.
std::string FileOf(const TemporaryFolder& folder, const std::string& name, const char* wkt) {
  const std::string path = folder / name;
  GDALDatasetUniquePtr file(GetGDALDriverManager()->GetDriverByName("GPKG")->Create(
      path.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  OGRSpatialReference reference;
  reference.importFromEPSG(32635);
  OGRLayer* layer = file->CreateLayer("seamlines", &reference, wkbUnknown, nullptr);
  OGRFieldDefn column("photo", OFTString);
  EXPECT_EQ(layer->CreateField(&column), OGRERR_NONE);
  OGRFeature feature(layer->GetLayerDefn());
  feature.SetField("photo", "4711");
  OGRGeometry* geometry = nullptr;
  EXPECT_EQ(OGRGeometryFactory::createFromWkt(wkt, nullptr, &geometry), OGRERR_NONE);
  feature.SetGeometryDirectly(geometry);
  EXPECT_EQ(layer->CreateFeature(&feature), OGRERR_NONE);
  return path;
}

TEST(Seamlines, OfArcsAreDrawnAndOfLinesRefused) {
  RegisterGdalDrivers();
  const TemporaryFolder folder;
  const std::string circle = FileOf(
      folder, "circle.gpkg",
      "CURVEPOLYGON(CIRCULARSTRING(500000 5000002,500002 5000004,500004 5000002,500002 5000000,"
      "500000 5000002))");
  const MapGrid grid = MapGrid::Around({500000, 5000000, 500004, 5000004}, 1);
  const std::vector<int> labels = Seamlines::FromFile(circle, kCrs).PhotoAt(grid, {0, 0, 4, 4});
  EXPECT_EQ(labels[5], 0) << "in the circle";
  EXPECT_EQ(labels[0], -1) << "in the square's corner";
  const std::string line = FileOf(folder, "line.gpkg", "LINESTRING(500000 5000000,500004 5000004)");
  ExpectError<InputError>([&] { Seamlines::FromFile(line, kCrs); },
                          {"line.gpkg", "4711", "LINESTRING", "polygon"});
}

}  // namespace
}  // namespace orient::ortho

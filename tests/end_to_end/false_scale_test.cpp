// A block in a CRS whose scale heights do not share is refused before any photo.
#include <gtest/gtest.h>

#include "core/files/orientation_table.h"
#include "core/terrain/crs.h"
#include "tests/end_to_end/spoilt_block.h"
#include "tests/support/run_orient.h"

namespace orient {
namespace {

constexpr char kWebMercator[] = "EPSG:3857";

TEST_F(BadInput, PhotosInWebMercatorAreRefusedAndAFittingCrsIsNamed) {
  const Crs mercator = Crs::Parse(kWebMercator, "test");
  const CoordinateTransform transform(mercator, Crs::Parse("EPSG:32635", "test"));
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  for (OrientationRow& row : table.rows)
    row.pose.position_m.head<2>() = transform(row.pose.position_m.head<2>()).value();
  table.crs = mercator;
  WriteOrientationTable(Path("approx.csv"), table);
  Write("approx.prj", kWebMercator);
  std::filesystem::remove(Path("patches.gpkg"));
  ASSERT_EQ(RunOrient({"patchdb", "create", Path("patches.gpkg"), "--crs", kWebMercator}).exit_code,
            0);
  const std::vector<std::string> parts = {"Pseudo-Mercator", "scale", "heights", "poses would be",
                                          "EPSG:32635"};
  ExpectRefused(Exterior({Path("scans/new_1_1.tif")}), 2, parts);
  Edit("block.toml", "EPSG:32635", kWebMercator);
  ExpectRefused(Block(), 2, parts);
}

TEST_F(BadInput, MeasurementsInWebMercatorAreRefused) {
  std::filesystem::create_directory(Path("said"));
  Write("said/points.csv",
        "point,x,y,z,sigma_x,sigma_y,sigma_z,role\n"
        "1,3016000,5942000,500,0.1,0.1,0.1,control\n");
  Write("said/image_points.csv", "photo,point,x_mm,y_mm,sigma\na,1,1,1,0.01\n");
  Write("measured.toml",
        "crs = \"EPSG:3857\"\ncamera = \"camera.toml\"\nmeasurements = \"said\"\n"
        "[output]\ndirectory = \"measured\"\n");
  ExpectRefused(RunOrient({"block", Path("measured.toml")}), 2, {"Pseudo-Mercator", "EPSG:32635"});
}

}  // namespace
}  // namespace orient

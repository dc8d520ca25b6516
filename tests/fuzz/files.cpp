// Files written by users: TOML files, tables, coordinate reference systems.
#include <array>
#include <filesystem>

#include "block/inputs/approximations.h"
#include "block/inputs/mark_shapes.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/measurements/measurements.h"
#include "interior/marks/mark_drawing.h"
#include "tests/fuzz/reader.h"
#include "tools/commands/patchdb/control_table.h"

namespace orient::fuzz {
namespace {

const Crs& BlockCrs() {
  static const Crs crs = Crs::Parse("EPSG:32635", "the fuzzer");
  return crs;
}

// An accepted file is written and read again with the same content; its marks can be rendered.
const Register kCameraFile("camera_file", [](Input input) {
  const CameraFile camera = ReadCameraFile(FileWith("camera.toml", Text(input)));
  const std::string text = CameraFileText(camera, Folder());
  const CameraFile again = ReadCameraFile(FileWith("again.toml", text));
  Require(CameraFileText(again, Folder()) == text, "camera file: " + text);
  const Eigen::Matrix2d pixel_from_mm = Eigen::Vector2d(10, -10).asDiagonal();
  for (const auto& [name, shape] : block::LoadMarkShapes(camera))
    interior::RenderMark(shape, pixel_from_mm);
});

const Register kBlockFile("block_file", [](Input input) {
  for (const char* name : {"dem.tif", "patches.gpkg", "camera.toml", "a/1.tif", "a/2.tif"})
    FileWith(name, "");
  ReadBlockFile(FileWith("block.toml", Text(input)));
});

void RequireNumbers(const OrientationTable& table, bool heights) {
  for (const OrientationRow& row : table.rows)
    Require(row.pose.AsVector().head(heights ? 6 : 2).allFinite() && !row.photo.empty(),
            "a row of photo '" + row.photo + "'");
}

// The second part is the .prj beside the table.
const Register kOrientationTable("orientation_table", [](Input input) {
  const auto parts = Parts(input);
  const std::string path = FileWith("table.csv", parts[0]);
  FileWith("table.prj", parts.size() > 1 ? parts[1] : BlockCrs().Wkt1());
  const OrientationTable table = ReadOrientationTable(path, OpenCells::kAngles);
  RequireNumbers(table, true);
  const std::string written = Folder() + "/again.csv";
  WriteOrientationTable(written, table);
  const OrientationTable again = ReadOrientationTable(written);
  Require(again.rows.size() == table.rows.size(), "a table has as many rows again");
});

// The parts are the four files of a folder.
const Register kMeasurements("measurements", [](Input input) {
  const auto parts = Parts(input);
  const std::array files = {kMarksFile, kImagePointsFile, kPointsFile, kDecisionsFile};
  for (std::size_t i = 0; i < files.size(); ++i)
    FileWith(std::string("said/") + files.at(i), i < parts.size() ? parts[i] : "");
  for (std::size_t i = parts.size(); i < files.size(); ++i)
    std::filesystem::remove(Folder() + "/said/" + files.at(i));
  const Measurements read = ReadMeasurements(Folder() + "/said");
  WriteMarks(Folder() + "/said", read.marks);
  WriteImagePoints(Folder() + "/said", read.image_points);
  WritePoints(Folder() + "/said", read.points);
  WriteDecisions(Folder() + "/said", read.decisions);
  const Measurements again = ReadMeasurements(Folder() + "/said");
  Require(again.marks.size() == read.marks.size() &&
              again.image_points.size() == read.image_points.size() &&
              again.points.size() == read.points.size() &&
              again.decisions.size() == read.decisions.size(),
          "measurements are as many again");
  for (const MarkMeasurement& mark : read.marks)
    Require(TextOfMarks(again, mark.photo) == TextOfMarks(read, mark.photo),
            "marks are the same again");
});

const Register kFlightIndex("flight_index", [](Input input) {
  const std::string path = MemoryFileWith("flight.geojson", input);
  RequireNumbers(block::ReadApproximations(path, BlockCrs(), block::Heights::kMayBeAbsent), false);
});

const Register kControlTable("control_table", [](Input input) {
  for (const ControlTablePoint& point : ReadControlTable(FileWith("control.csv", Text(input))))
    Require(point.point.ground_m.allFinite() && !point.measured.empty(), point.point.id);
});

const Register kCrs("crs", [](Input input) {
  const Crs crs = Crs::Parse(std::string(Text(input)), "the fuzzer");
  crs.Name();
  crs.Epsg();
  crs.Wkt1();
  Require(Crs::Parse(crs.Wkt(), "again").SameAs(crs), "a CRS is itself: " + crs.Wkt());
  Accepted([&] { return CoordinateTransform(BlockCrs(), crs)({500000, 5000000}); });
});

}  // namespace
}  // namespace orient::fuzz

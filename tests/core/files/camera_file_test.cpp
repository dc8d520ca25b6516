#include "core/files/camera_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/core/files/camera_texts.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kExact = 1e-12;

void ExpectRefused(const std::string& text, std::initializer_list<std::string> parts) {
  ExpectError<InputError>([&] { ReadText(text); }, parts);
}

void ExpectRefusedFilm(const std::string& from, const std::string& to,
                       std::initializer_list<std::string> parts) {
  ExpectRefused(Replaced(kFilm, from, to), parts);
}

TEST(CameraFile, TheExampleOfTheConventionsReads) {
  const CameraFile file = ReadText(kFilm);
  EXPECT_EQ(file.camera.name, "Wild RC10, 15 UAG 1234");
  EXPECT_EQ(file.camera.kind, CameraKind::kFilm);
  EXPECT_EQ(file.camera.principal_distance_mm, 153.29);
  EXPECT_EQ(file.camera.principal_point_mm, Eigen::Vector2d(0.012, -0.004));
  EXPECT_EQ(file.camera.frame_centre_mm, Eigen::Vector2d(0.1, 0));
  EXPECT_FALSE(file.camera.image_px);
  const auto& brown = std::get<BrownDistortion>(file.camera.lens);
  EXPECT_EQ(brown.k[0], 1.2e-8);
  EXPECT_EQ(brown.p[0], 1e-7);
  ASSERT_EQ(file.fiducials.size(), 4u);
  EXPECT_EQ(file.fiducials[0].position_mm, Eigen::Vector2d(-106.007, 106.004));
  ASSERT_TRUE(file.fiducials[0].symbol);
  EXPECT_EQ(file.fiducials[0].symbol->kind, SymbolKind::kLines);
  EXPECT_FALSE(file.fiducials[0].symbol->at_mm);
  EXPECT_EQ(file.fiducials[1].symbol->at_mm, Eigen::Vector2d(1, 2));
  EXPECT_FALSE(file.fiducials[2].symbol);
}

TEST(CameraFile, DrawingsKeepTheLengthsOfTheFile) {
  const MarkDrawing mark = ReadText(kFilm).marks.at("corner");
  ASSERT_EQ(mark.elements.size(), 3u);
  const auto& cross = std::get<CrossElement>(mark.elements[0]);
  EXPECT_EQ(cross.length_mm, 2.0);
  EXPECT_EQ(cross.width_mm, 0.06);
  EXPECT_EQ(cross.gap_mm, 0.3);
  EXPECT_NEAR(cross.angle_rad, RadFromDeg(45), kExact);
  EXPECT_EQ(std::get<DotElement>(mark.elements[1]).diameter_mm, 0.12);
  EXPECT_EQ(std::get<CircleElement>(mark.elements[2]).width_mm, 0.08);
  EXPECT_EQ(mark.background, MarkBackground::kDark);
  EXPECT_FALSE(mark.image);
}

// The same camera with other elements in its drawing.
std::string FilmDrawnWith(const std::string& elements) {
  const size_t from = kFilm.find("elements = [");
  return kFilm.substr(0, from) + "elements = [\n" + elements + "\n]\n";
}

const std::string kEveryShape = R"(
  { shape = "cross", length_mm = 4.0, width_mm = 0.1, at_mm = [0.5, -0.25], brightness = 0.65 },
  { shape = "dot", diameter_mm = 0.5, at_mm = [1, 2], brightness = -1 },
  { shape = "circle", diameter_mm = 2.0, width_mm = 0.1, at_mm = [-1, 2], brightness = 0.0 },
  { shape = "line", from_mm = [0.5, 0], to_mm = [2, 0.25], width_mm = 0.125 },
  { shape = "wedge", base_mm = 1.5, depth_mm = 2.0, angle_deg = 90, at_mm = [0, 3] },
  { shape = "checker", size_mm = 3.0, angle_deg = 45.0, brightness = 0.5 },
  { shape = "polygon", points_mm = [[0, 0], [2.5, 0], [2.5, 1.25]], brightness = -0.5 },
  { shape = "polygon", points_mm = [[-2, 0], [0, 1.5], [2, 0]], open = true },)";

TEST(CameraFile, EveryShapeKeepsItsNumbersThroughARoundtrip) {
  const TemporaryFolder folder;
  WriteCameraFile(folder / "again.toml", ReadText(FilmDrawnWith(kEveryShape)));
  const auto elements = ReadCameraFile(folder / "again.toml").marks.at("corner").elements;
  ASSERT_EQ(elements.size(), 8u);
  const auto& cross = std::get<CrossElement>(elements[0]);
  EXPECT_EQ(cross.at_mm, Eigen::Vector2d(0.5, -0.25));
  EXPECT_EQ(cross.brightness, 0.65);
  const auto& dot = std::get<DotElement>(elements[1]);
  EXPECT_EQ(dot.at_mm, Eigen::Vector2d(1, 2));
  EXPECT_EQ(dot.brightness, -1);
  const auto& circle = std::get<CircleElement>(elements[2]);
  EXPECT_EQ(circle.at_mm, Eigen::Vector2d(-1, 2));
  EXPECT_EQ(circle.brightness, 0);
  const auto& line = std::get<LineElement>(elements[3]);
  EXPECT_EQ(line.from_mm, Eigen::Vector2d(0.5, 0));
  EXPECT_EQ(line.to_mm, Eigen::Vector2d(2, 0.25));
  EXPECT_EQ(line.width_mm, 0.125);
  EXPECT_EQ(line.brightness, 1);
  const auto& wedge = std::get<WedgeElement>(elements[4]);
  EXPECT_EQ(wedge.base_mm, 1.5);
  EXPECT_EQ(wedge.depth_mm, 2.0);
  EXPECT_NEAR(wedge.angle_rad, RadFromDeg(90), kExact);
  EXPECT_EQ(wedge.at_mm, Eigen::Vector2d(0, 3));
  const auto& checker = std::get<CheckerElement>(elements[5]);
  EXPECT_EQ(checker.size_mm, 3.0);
  EXPECT_NEAR(checker.angle_rad, RadFromDeg(45), kExact);
  EXPECT_EQ(checker.brightness, 0.5);
  const auto& polygon = std::get<PolygonElement>(elements[6]);
  ASSERT_EQ(polygon.points_mm.size(), 3u);
  EXPECT_EQ(polygon.points_mm[2], Eigen::Vector2d(2.5, 1.25));
  EXPECT_EQ(polygon.brightness, -0.5);
  EXPECT_FALSE(polygon.open);
  EXPECT_TRUE(std::get<PolygonElement>(elements[7]).open);
}

TEST(CameraFile, ImpossibleElementsAreRefusedByTheirKey) {
  const auto refuse = [](const std::string& element, std::initializer_list<std::string> parts) {
    ExpectRefused(FilmDrawnWith(element), parts);
  };
  refuse("{ shape = \"dot\", diameter_mm = 1, brightness = 2 }",
         {"elements[0].brightness", "between -1"});
  refuse("{ shape = \"dot\", diameter_mm = 1, brightness = 0.0 }",
         {"marks.corner.elements", "brightness 0"});
  refuse("{ shape = \"dot\", diameter_mm = 1, at_mm = [12, 0] }",
         {"corner.elements", "at most 20"});
  refuse("{ shape = \"line\", from_mm = [1, 1], to_mm = [1, 1], width_mm = 0.1 }",
         {"elements[0].to_mm", "length"});
  refuse("{ shape = \"line\", from_mm = [1, 1], width_mm = 0.1 }", {"elements[0]", "to_mm"});
  refuse("{ shape = \"wedge\", base_mm = 1, depth_mm = 0 }", {"elements[0].depth_mm", "positive"});
  refuse("{ shape = \"wedge\", base_mm = 1, dept_mm = 1 }",
         {"elements[0].dept_mm", "did you mean depth_mm?"});
  refuse("{ shape = \"checker\", diameter_mm = 3 }", {"elements[0].diameter_mm"});
  refuse("{ shape = \"polygon\", points_mm = [[0, 0], [1, 0]] }",
         {"elements[0].points_mm", "three points"});
  refuse("{ shape = \"polygon\", points_mm = [[0, 0], [1, 0], 7] }",
         {"elements[0].points_mm", "[[x, y]"});
  refuse("{ shape = \"polygon\", points_mm = [[0, 0], [1, 1], [1, 0], [0, 1]] }",
         {"elements[0].points_mm", "crosses itself"});
  refuse(
      "{ shape = \"polygon\", open = true, points_mm = [[-1, -1], [-2, 0], [0, 2], [2, 0], [1, "
      "-1]] }",
      {"elements[0].points_mm", "crosses itself"});
  refuse("{ shape = \"polygon\", points_mm = [[0, 0], [1, 1], [2, 2]] }",
         {"elements[0].points_mm", "no area"});
  refuse("{ shape = \"polygon\", points_mm = [[0, 0], [0, 0], [2, 2]] }",
         {"elements[0].points_mm", "twice"});
}

TEST(CameraFile, ADigitalCameraHasItsImageSize) {
  const CameraFile file = ReadText(kDigital);
  EXPECT_EQ(file.camera.kind, CameraKind::kDigital);
  EXPECT_EQ(file.camera.image_px, Eigen::Vector2i(640, 1152));
  EXPECT_TRUE(std::holds_alternative<std::monostate>(file.camera.lens));
}

TEST(CameraFile, ARadialTableReads) {
  const CameraFile file =
      ReadText(kDigital +
               "[distortion]\nmodel = \"radial_table\"\nradius_mm = [0, 20, 40]\n"
               "dr_um = [0.0, 1.2, -0.8]\n");
  const auto& table = std::get<RadialTable>(file.camera.lens);
  EXPECT_EQ(table.radius_mm, (std::vector<double>{0, 20, 40}));
  EXPECT_EQ(table.dr_um, (std::vector<double>{0, 1.2, -0.8}));
}

TEST(CameraFile, AMarkImageLiesRelativeToTheCameraFile) {
  const TemporaryFolder folder;
  const size_t drawing = kFilm.find("elements = [");
  const std::string text = kFilm.substr(0, drawing) +
                           "image = \"marks/notch.png\"\npixel_size_mm = 0.025\n"
                           "centre_px = [150.5, 151.5]\nbackground = \"image\"\n";
  WriteFileAtomically(folder / "camera.toml", text);
  ExpectError<InputError>([&] { ReadCameraFile(folder / "camera.toml"); },
                          {"marks.corner.image", "marks/notch.png", "does not exist"});
  std::filesystem::create_directory(folder / "marks");
  WriteFileAtomically(folder / "marks/notch.png", "");
  const MarkDrawing mark = ReadCameraFile(folder / "camera.toml").marks.at("corner");
  ASSERT_TRUE(mark.image);
  EXPECT_EQ(mark.image->path, folder / "marks/notch.png");
  EXPECT_EQ(mark.image->centre_px, Eigen::Vector2d(150.5, 151.5));
  EXPECT_EQ(mark.background, MarkBackground::kImage);
}

TEST(CameraFile, AnUnknownKeyIsNamedWithItsLineAndTheNearestKnownOne) {
  ExpectRefusedFilm(
      "principal_distance_mm", "principle_distance_mm",
      {"camera.toml, line 3: principle_distance_mm", "did you mean principal_distance_mm?"});
  ExpectRefusedFilm("position_mm = [-106.007", "positon_mm = [-106.007",
                    {"line 15: fiducials[0].positon_mm", "did you mean position_mm?"});
  ExpectRefusedFilm("gap_mm", "gab_mm",
                    {"marks.corner.elements[0].gab_mm", "did you mean gap_mm?"});
  ExpectRefusedFilm("diameter_mm = 0.12", "diameter_mm = 0.12, width_mm = 1",
                    {"marks.corner.elements[1].width_mm"});
  ExpectRefusedFilm("p = [1e-7, 0.0]", "radius_mm = [0]", {"distortion.radius_mm"});
  ExpectRefusedFilm("frame_centre_mm", "weather", {"line 6: weather", "known here: name, kind"});
}

TEST(CameraFile, WrongTypesAreNamedWithTheirValue) {
  ExpectRefusedFilm("153.29", "\"153.29\"", {"principal_distance_mm", "a number", "\"153.29\""});
  ExpectRefusedFilm("[212.0, 212.0]", "212.0", {"frame_mm", "list of numbers"});
  ExpectRefusedFilm("[212.0, 212.0]", "[212.0]", {"frame_mm", "two numbers"});
  ExpectRefusedFilm("[212.0, 212.0]", "[212.0, true]", {"frame_mm", "numbers"});
  ExpectRefusedFilm("id = \"1\"", "id = 1", {"fiducials[0].id", "text in quotes"});
  ExpectRefusedFilm("count = 1", "count = 1.5", {"fiducials[0].symbol.count", "whole number"});
  ExpectRefusedFilm("153.29", "nan", {"principal_distance_mm", "a number"});
  ExpectRefused("fiducials = 7\n" + kDigital, {"fiducials", "list of tables"});
  ExpectRefused("marks = 7\n" + kDigital, {"marks", "table"});
}

TEST(CameraFile, MissingKeysAreNamed) {
  for (const std::string key :
       {"name", "kind", "principal_distance_mm", "principal_point_mm", "frame_mm"}) {
    const size_t at = kDigital.find(key + " =");
    std::string text = kDigital;
    text.erase(at, text.find('\n', at) + 1 - at);
    ExpectRefused(text, {"lacks the key " + key});
  }
}

TEST(CameraFile, TextThatIsNotTomlIsNamedWithItsPlace) {
  ExpectRefused("name = \"x\"\nkind = film\n", {"camera.toml, line 2", "not valid TOML"});
  ExpectError<InputError>([] { ReadCameraFile("no/camera.toml"); }, {"no/camera.toml"});
}

TEST(CameraFile, ImpossibleGeometryIsRefused) {
  ExpectRefusedFilm("153.29", "-153.29", {"principal_distance_mm", "-153.29", "positive"});
  ExpectRefusedFilm("[212.0, 212.0]", "[212.0, 0.0]", {"frame_mm", "empty"});
  ExpectRefusedFilm("[0.012, -0.004]", "[150.0, 0.0]", {"principal_point_mm", "outside"});
  ExpectRefusedFilm("\"film\"", "\"negative\"", {"kind", "film or digital"});
}

TEST(CameraFile, APrincipalDistanceInAnotherUnitIsRefused) {
  ExpectRefusedFilm("153.29", "0.15329", {"principal_distance_mm", "0.15329 mm", "millimetres"});
  ExpectRefusedFilm("153.29", "153290", {"principal_distance_mm", "153290", "millimetres"});
  ExpectRefusedFilm("153.29", "1e-300", {"principal_distance_mm", "millimetres"});
}

TEST(CameraFile, ImageSizeAndFrameMustAgree) {
  ExpectRefused(Replaced(kDigital, "image_px = [640, 1152]\n", ""), {"image_px"});
  ExpectRefused(Replaced(kDigital, "[640, 1152]", "[1152, 640]"), {"image_px", "frame_mm"});
  ExpectRefused(Replaced(kDigital, "[640, 1152]", "[640, 1140]"), {"image_px", "frame_mm"});
  EXPECT_NO_THROW(ReadText(Replaced(kDigital, "[640, 1152]", "[640, 1148]"))) << "0.3 % is allowed";
  ExpectRefused(Replaced(kDigital, "[640, 1152]", "[640.5, 1152]"), {"image_px", "whole"});
  ExpectRefused("image_px = [640, 1152]\n" + kFilm, {"image_px", "digital"});
}

TEST(CameraFile, ImpossibleFiducialsAreRefused) {
  ExpectRefusedFilm("mark = \"corner\"", "mark = \"cornre\"", {"fiducials[0].mark", "not drawn"});
  ExpectRefusedFilm("id = \"2\"", "id = \"1\"", {"fiducials[1].id", "\"1\""});
  ExpectRefusedFilm("[106.0, 106.0]", "[-106.0, 106.0]", {"fiducials[1].position_mm", "\"1\""});
  ExpectRefusedFilm("[106.0, 106.0]", "[106000, 106000]",
                    {"fiducials[1].position_mm", "outside the frame"});
  ExpectRefusedFilm("at_mm = [1.0, 2.0]", "at_mm = [100.0, 2.0]", {"fiducials[1].symbol.at_mm"});
  ExpectRefusedFilm("count = 1", "count = 0", {"fiducials[0].symbol.count"});
  ExpectRefused(kDigital + kFilm.substr(kFilm.find("[[fiducials]]")), {"fiducials", "digital"});
  std::string two = kFilm;
  two.erase(two.find("[[fiducials]]\nid = \"3\""),
            two.find("[marks.corner]") - two.find("[[fiducials]]\nid = \"3\""));
  ExpectRefused(two, {"fiducials", "fewer than the three"});
}

TEST(CameraFile, FiducialsOnOneLineAreRefused) {
  std::string text = Replaced(kFilm, "[-106.007, 106.004]", "[-106.0, -106.01]");
  text = Replaced(text, "[106, -106]", "[0.0, 0.3]");
  ExpectRefused(Replaced(text, "[-106.0, -106.0]", "[50.0, 50.0]"), {"fiducials", "one line"});
}

TEST(CameraFile, ImpossibleDrawingsAreRefused) {
  ExpectRefusedFilm("diameter_mm = 1.6", "diameter_mm = 1600", {"marks.corner", "1600", "at most"});
  ExpectRefusedFilm("gap_mm = 0.3", "gap_mm = 2.3", {"elements[0].gap_mm"});
  ExpectRefusedFilm("width_mm = 0.06", "width_mm = -1", {"elements[0].width_mm", "positive"});
  ExpectRefusedFilm("width_mm = 0.08", "width_mm = 1.8", {"elements[2].width_mm"});
  ExpectRefusedFilm("shape = \"dot\"", "shape = \"star\"", {"elements[1].shape", "star"});
  ExpectRefusedFilm("background = \"dark\"", "background = \"black\"", {"background", "black"});
  ExpectRefused(kDigital + "[marks.empty]\n", {"marks.empty", "elements or an image"});
  ExpectRefused(kDigital + "[marks.m]\ncentre_px = [1, 1]\n", {"marks.m", "without an image"});
}

TEST(CameraFile, ImpossibleDistortionIsRefused) {
  const auto table = [](const std::string& radius, const std::string& dr) {
    return kDigital + "[distortion]\nmodel = \"radial_table\"\nradius_mm = " + radius +
           "\ndr_um = " + dr + "\n";
  };
  ExpectRefused(table("[0, 40, 20]", "[0, 1, 2]"), {"distortion.radius_mm", "increase"});
  ExpectRefused(table("[0, 20, 20]", "[0, 1, 2]"), {"distortion.radius_mm", "increase"});
  ExpectRefused(table("[10, 20]", "[0, 1]"), {"distortion.radius_mm", "start at 0"});
  ExpectRefused(table("[0, 20]", "[0, 1, 2]"), {"distortion.dr_um", "3 values"});
  ExpectRefusedFilm("k = [1.2e-8, 0.0, 0.0]", "k = [1, 2, 3, 4]", {"distortion.k", "4 values"});
  ExpectRefusedFilm("\"brown\"", "\"fisheye\"", {"distortion.model", "fisheye"});
  ExpectRefusedFilm("k = [1.2e-8, 0.0, 0.0]", "k = [0.012, 0.0, 0.0]", {"distortion", "per mm^2"});
}

TEST(CameraFile, ImpossibleBordersAreRefused) {
  const auto border = [](const std::string& shows, const std::string& from, const std::string& to) {
    return kFilm + "[[border]]\nshows = \"" + shows + "\"\nfrom_mm = " + from + "\nto_mm = " + to +
           "\n";
  };
  ExpectRefused(border("words", "[0, 0]", "[5, 5]"), {"border", "shows", "words"});
  ExpectRefused(border("text", "[0, 0]", "[5, 0.5]"), {"border", "to_mm", "1 mm"});
  ExpectRefused(border("text", "[0, 0]", "[5, 5000]"), {"border", "far outside"});
  ExpectRefusedFilm("kind = \"film\"", "kind = \"film\"\ndata_strip = \"north\"",
                    {"data_strip", "north", "left"});
}

TEST(CameraFile, TheNgiCameraReads) {
  ORIENT_REQUIRE_SHARED_DATA(path, "ngi/camera.toml");
  const CameraFile file = ReadCameraFile(path);
  EXPECT_EQ(file.camera.kind, CameraKind::kDigital);
  EXPECT_EQ(file.camera.principal_distance_mm, 120.0);
  EXPECT_EQ(file.camera.image_px, Eigen::Vector2i(640, 1152));
}

}  // namespace
}  // namespace orient

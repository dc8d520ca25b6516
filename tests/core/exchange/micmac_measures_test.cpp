#include "core/exchange/micmac_measures.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/geometry/transform2d.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

using Eigen::Vector2d;

// The text of the next element of that name; empty where there is none. Moves `at` behind it.
std::string NextElement(const std::string& xml, const std::string& name, size_t* at) {
  const std::string open = "<" + name + ">", close = "</" + name + ">";
  const size_t from = xml.find(open, *at);
  const size_t to = xml.find(close, from);
  if (from == std::string::npos || to == std::string::npos) return "";
  *at = to + close.size();
  return xml.substr(from + open.size(), to - from - open.size());
}

// A reader of its own: name and coordinates of every point in the order of the file.
std::vector<MicmacPoint> PointsIn(const std::string& xml) {
  std::vector<MicmacPoint> points;
  size_t at = 0;
  while (true) {
    const std::string point = NextElement(xml, "OneMesureAF1I", &at);
    if (point.empty()) return points;
    size_t in_point = 0;
    const std::string name = NextElement(point, "NamePt", &in_point);
    std::istringstream place(NextElement(point, "PtIm", &in_point));
    double x = 0, y = 0;
    EXPECT_TRUE(place >> x >> y) << point;
    points.push_back({name, {x, y}});
  }
}

struct Example {
  std::vector<Fiducial> fiducials;
  InteriorResult result;
};

// Eight marks on a turned, negative, not quite regular film, 2 um of noise; one mark is missing.
Example MeasuredPhoto() {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.08);
  Example example;
  Affine2d pixel_from_photo;
  pixel_from_photo.A << 0.9, 39.99, 40.01, -0.8;  // turned by 90 degrees
  pixel_from_photo.t << 4600.3, 4580.9;
  std::vector<PointPair2d> pairs;
  const std::vector<Vector2d> places = {{-106, -106}, {106.01, 106}, {-106, 106.02}, {106, -106},
                                        {-110, 0},    {110, 0.01},   {0, 110},       {0, -110}};
  for (const Vector2d& place : places) {
    example.fiducials.push_back({std::to_string(pairs.size() + 1), place, "m", std::nullopt});
    MarkResult mark;
    mark.id = example.fiducials.back().id;
    mark.state = MarkState::kUsed;
    mark.pixel = pixel_from_photo * place + Vector2d(noise(random), noise(random));
    example.result.marks.push_back(mark);
    pairs.push_back({*mark.pixel, place});
  }
  pairs.erase(pairs.begin() + 4);
  example.result.marks[4] = {};
  example.result.marks[4].id = "5";
  example.result.photo_from_pixel = FitAffine(pairs)->transform;
  return example;
}

TEST(MicmacMeasures, TheAffineThatMicmacFitsToBothFilesIsOurs) {
  const Example example = MeasuredPhoto();
  TemporaryFolder folder;
  WriteMicmacCamera(folder.Path(), example.fiducials);
  WriteMicmacImage(folder.Path(), "/scans/47 11.tif", example.result);
  const std::string camera = ReadFile(folder / "Ori-InterneScan/MeasuresCamera.xml");
  const std::string image = ReadFile(folder / "Ori-InterneScan/MeasuresIm-47 11.tif.xml");
  // As cAppliOneReechMarqFid: pairs of one name, an affine from camera mm to scan pixels.
  std::vector<PointPair2d> pairs;
  for (const MicmacPoint& mm : PointsIn(camera))
    for (const MicmacPoint& px : PointsIn(image))
      if (mm.name == px.name) pairs.push_back({mm.position, px.position});
  ASSERT_EQ(pairs.size(), 7U);
  const Affine2d micmac_pixel_from_mm = FitAffine(pairs)->transform;
  // Through their conventions and back: integer pixel centres, y down from the uppermost mark.
  const Vector2d corner(-110, 110);
  for (const Vector2d& photo : {Vector2d(0, 0), Vector2d(100, -90), Vector2d(-80, 105)}) {
    const Vector2d theirs(photo.x() - corner.x(), corner.y() - photo.y());
    const Vector2d pixel = micmac_pixel_from_mm * theirs + Vector2d(0.5, 0.5);
    // Theirs minimises in the scan, ours in the camera: the same up to the square of the noise.
    EXPECT_LT((*example.result.photo_from_pixel * pixel - photo).norm(), 1e-4) << "mm";
  }
}

TEST(MicmacMeasures, NamesAndStructureAreMicmacs) {
  const std::string xml = MicmacMeasures("a&b.tif", {{"P<1>", {1.5, -2}}});
  EXPECT_EQ(xml,
            "<?xml version=\"1.0\" ?>\n<MesureAppuiFlottant1Im>\n  <NameIm>a&amp;b.tif</NameIm>\n"
            "  <OneMesureAF1I>\n    <NamePt>P&lt;1&gt;</NamePt>\n"
            "    <PtIm>1.500000 -2.000000</PtIm>\n  </OneMesureAF1I>\n"
            "</MesureAppuiFlottant1Im>\n");
}

TEST(MicmacMeasures, APhotoWithoutTransformHasNoFileAndLosesAnOldOne) {
  Example example = MeasuredPhoto();
  TemporaryFolder folder;
  WriteMicmacImage(folder.Path(), "a.tif", example.result);
  example.result.photo_from_pixel.reset();
  WriteMicmacImage(folder.Path(), "a.tif", example.result);
  EXPECT_ANY_THROW(ReadFile(folder / "Ori-InterneScan/MeasuresIm-a.tif.xml"));
}

}  // namespace
}  // namespace orient

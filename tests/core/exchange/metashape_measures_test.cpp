#include "core/exchange/metashape_measures.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/core/exchange/texts.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

std::string Chunk(const std::string& cameras, const std::string& markers,
                  const std::string& locations, const std::string& more = "") {
  return "<chunk><cameras>" + cameras + "</cameras>\n<markers>" + markers +
         "</markers>\n<frames><frame id=\"0\"><markers>\n" + locations +
         "</markers></frame></frames>\n" + more + "</chunk>\n";
}

std::string Location(const std::string& attributes) {
  return "<marker marker_id=\"0\"><location camera_id=\"0\" " + attributes + "/></marker>\n";
}

const std::string kCamera = R"(<camera id="0" label="4711.tif"/>)";
const std::string kMarker = R"(<marker id="0" label="gcp 1"/>)";

class MetashapeMarkers : public testing::Test {
 protected:
  void Read(const std::string& chunks) {
    all_ = {};
    std::ofstream(folder_ / "markers.xml")
        << "<document version=\"1.5.0\">" + chunks + "</document>";
    AddMetashapeMarkers(folder_ / "markers.xml", {0.25, 0.05}, &all_);
  }
  void ExpectRefused(const std::string& chunks, std::initializer_list<std::string> parts) {
    ExpectError<InputError>([&] { Read(chunks); }, parts);
  }
  std::string Notes() const { return NotesOf(all_); }

  TemporaryFolder folder_;
  GatheredMeasurements all_;
};

TEST_F(MetashapeMarkers, OfTwoChunksKeepTheirOwnNames) {
  Read(Chunk(R"(<camera id="0" label="a.tif"/>)", R"(<marker id="0" label="north"/>)",
             Location(R"(pinned="1" x="1.5" y="2.5")")) +
       Chunk(R"(<camera id="0" label="b.tif"/>)", R"(<marker id="0" label="south"/>)",
             Location(R"(pinned="1" x="3.5" y="4.5")")));
  const auto& seen = all_.All().image_points;
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(seen[0].photo + seen[0].point, "anorth");
  EXPECT_EQ(*seen[0].pixel, Eigen::Vector2d(1.5, 2.5));
  EXPECT_EQ(seen[1].photo + seen[1].point, "bsouth");
}

TEST_F(MetashapeMarkers, OfTwoChunksMayRepeatButNotContradictOneAnother) {
  const std::string given =
      R"(<marker id="0" label="p"><reference x="1000" y="2000" z="3"/></marker>)";
  const std::string other =
      R"(<marker id="9" label="p"><reference x="1000" y="2001" z="3"/></marker>)";
  Read(Chunk(kCamera, given, "") + Chunk(kCamera, given, ""));
  EXPECT_EQ(all_.All().points.size(), 1u);
  ExpectRefused(Chunk(kCamera, given, "") + Chunk(kCamera, other, ""),
                {"line 7", "point p is given a second time", "line 2"});
}

TEST_F(MetashapeMarkers, AnUnpinnedLocationIsNoMeasurementAndIsCounted) {
  Read(Chunk(kCamera, kMarker, Location(R"(pinned="0" x="1" y="2")")) +
       Chunk(kCamera, kMarker, Location(R"(pinned="false" x="1" y="2")")));
  EXPECT_TRUE(all_.All().image_points.empty());
  EXPECT_NE(Notes().find("nobody measured them), left out: 2"), std::string::npos) << Notes();
}

TEST_F(MetashapeMarkers, ALocationThatIsNotValidNeedsNoCoordinates) {
  Read(Chunk(kCamera, kMarker, Location(R"(pinned="0" valid="0")")));
  EXPECT_TRUE(all_.All().image_points.empty());
  EXPECT_NE(Notes().find("not valid in Metashape, left out: 1"), std::string::npos);
}

TEST_F(MetashapeMarkers, ALocationOfAnotherProgramThatSaysNothingOfPinsIsAMeasurement) {
  Read(Chunk(kCamera, kMarker, Location(R"(x="1" y="2")")));
  EXPECT_EQ(all_.All().image_points.size(), 1u);
  EXPECT_TRUE(all_.Notes().empty());
  ExpectRefused(Chunk(kCamera, kMarker, Location(R"(pinned="maybe" x="1" y="2")")),
                {"line 4", "pinned is \"maybe\""});
}

TEST_F(MetashapeMarkers, LabelsLoseFoldersAndEndingsOfImagesOnly) {
  Read(Chunk(R"(<camera id="0" label="0182.v2"/>)", kMarker, Location(R"(x="1" y="2")")));
  EXPECT_EQ(all_.All().image_points[0].photo, "0182.v2");
  Read(
      Chunk(R"(<camera id="0" label="roll 7/0182.v2.TIF"/>)", kMarker, Location(R"(x="1" y="2")")));
  EXPECT_EQ(all_.All().image_points[0].photo, "0182.v2");
}

TEST_F(MetashapeMarkers, OfGeographicSystemsAreRefused) {
  ExpectRefused(
      Chunk(kCamera, R"(<marker id="0" label="p"><reference x="15.4" y="47.1" z="3"/></marker>)",
            "", "<reference>GEOGCS[\"WGS 84\",DATUM[]]</reference>"),
      {"line 2", "GEOGCS", "Convert"});
  ExpectRefused(
      Chunk(kCamera, R"(<marker id="0" label="p"><reference x="15.4" y="47.1" z="3"/></marker>)",
            "", "<reference>COMPD_CS[\"WGS 84 + EGM96\",GEOGCS[\"WGS 84\",DATUM[]]]</reference>"),
      {"line 2", "Convert"});
  ExpectRefused(
      Chunk(kCamera, R"(<marker id="0" label="p"><reference x="15.4" y="47.1" z="3"/></marker>)",
            "", "<reference>EPSG::4258</reference>"),
      {"line 2", "Convert"});
}

TEST_F(MetashapeMarkers, StatedAccuraciesAreTaken) {
  Read(
      Chunk(kCamera,
            R"(<marker id="0" label="p"><reference x="1" y="2" z="3" sxy="0.02" sz="0.04"/></marker>
<marker id="1" label="q"><reference x="1" y="2" z="3" sxyz="0.5" enabled="false"/></marker>)",
            ""));
  EXPECT_EQ(all_.All().points[0].sigma_m, Eigen::Vector3d(0.02, 0.02, 0.04));
  EXPECT_EQ(all_.All().points[1].sigma_m, Eigen::Vector3d(0.5, 0.5, 0.5));
  EXPECT_EQ(all_.All().points[1].role, PointRole::kCheck);
}

TEST_F(MetashapeMarkers, WithIdsThatNothingHasOrTwoHaveAreRefused) {
  ExpectRefused(Chunk(kCamera, "", Location(R"(x="1" y="2")")), {"line 4", "no marker", "0"});
  ExpectRefused(Chunk("", kMarker, Location(R"(x="1" y="2")")), {"line 4", "no camera", "0"});
  ExpectRefused(Chunk(kCamera + kCamera, kMarker, ""), {"line 1", "another camera's"});
}

TEST_F(MetashapeMarkers, OfTwoCamerasOrFramesOfOneNameAreRefused) {
  ExpectRefused(
      Chunk(kCamera + R"(<camera id="1" label="b/4711.tif"/>)",
            kMarker + R"(<marker id="1" label="2"/>)",
            Location(R"(x="1" y="2")") +
                R"(<marker marker_id="1"><location camera_id="1" x="1" y="2"/></marker>)"),
      {"line 5", "two cameras", "4711"});
  ExpectRefused(Chunk(kCamera, kMarker,
                      Location(R"(x="1" y="2")") + "</markers></frame><frame id=\"1\"><markers>" +
                          Location(R"(x="3" y="2")")),
                {"line 5", "several frames"});
}

}  // namespace
}  // namespace orient

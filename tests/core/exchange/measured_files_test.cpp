#include "core/exchange/measured_files.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

class MeasuredFiles : public testing::Test {
 protected:
  Measurements Read(const std::string& text, MeasuredFormat format) const {
    std::ofstream(folder_ / "file") << text;
    GatheredMeasurements all;
    AddMeasuredFile(folder_ / "file", format, {0.25, 0.05}, &all);
    return all.All();
  }
  TemporaryFolder folder_;
};

TEST_F(MeasuredFiles, MetashapesMarkersWithControlAndCheckPoints) {
  const Measurements all = Read(R"(<document version="1.5.0"><chunk>
<cameras><camera id="4" label="4711.tif"/></cameras>
<markers><marker id="0" label="gcp 1"><reference x="10" y="20" z="30" sx="0.01" enabled="1"/></marker>
<marker id="1" label="chk"><reference x="1" y="2" z="3" enabled="0"/></marker>
<marker id="2" label="tie"/></markers>
<frames><frame id="0"><markers><marker marker_id="0"><location camera_id="4" pinned="1" x="100.5" y="200"/>
</marker></markers></frame></frames></chunk></document>)",
                                MeasuredFormat::kMetashape);
  ASSERT_EQ(all.points.size(), 2u);
  EXPECT_EQ(all.points[0].name, "gcp 1");
  EXPECT_EQ(all.points[0].ground_m, Eigen::Vector3d(10, 20, 30));
  EXPECT_EQ(all.points[0].sigma_m, Eigen::Vector3d(0.01, 0.05, 0.05));
  EXPECT_EQ(all.points[0].role, PointRole::kControl);
  EXPECT_EQ(all.points[1].role, PointRole::kCheck);
  ASSERT_EQ(all.image_points.size(), 1u);
  EXPECT_EQ(all.image_points[0].photo, "4711");
  EXPECT_EQ(*all.image_points[0].pixel, Eigen::Vector2d(100.5, 200));
  EXPECT_EQ(all.image_points[0].sigma, 0.25);
}

TEST_F(MeasuredFiles, AMetashapeProjectionOfNoMarkerIsAnError) {
  ExpectError<InputError>(
      [&] {
        Read(R"(<document><cameras><camera id="1" label="a"/></cameras>
<marker marker_id="7"><location camera_id="1" x="1" y="1"/></marker></document>)",
             MeasuredFormat::kMetashape);
      },
      {"marker_id", "line 2"});
}

TEST_F(MeasuredFiles, MicmacsPixelsHaveIntegerCentres) {
  const Measurements all = Read(R"(<SetOfMesureAppuisFlottants><MesureAppuiFlottant1Im>
<NameIm>OIS-Reech_4711.tif</NameIm><OneMesureAF1I><NamePt>P1</NamePt><PtIm>99.5 200</PtIm>
</OneMesureAF1I></MesureAppuiFlottant1Im></SetOfMesureAppuisFlottants>)",
                                MeasuredFormat::kMicmac);
  ASSERT_EQ(all.image_points.size(), 1u);
  EXPECT_EQ(all.image_points[0].photo, "OIS-Reech_4711");
  EXPECT_EQ(*all.image_points[0].pixel, Eigen::Vector2d(100, 200.5));
  const Measurements ground = Read(R"(<DicoAppuisFlottant><OneAppuisDAF><Pt>1 2 3</Pt>
<NamePt>P1</NamePt><Incertitude>0.1 0.1 0.2</Incertitude></OneAppuisDAF><OneAppuisDAF><Pt>4 5 6</Pt>
<NamePt>P2</NamePt><Incertitude>-1 -1 -1</Incertitude></OneAppuisDAF></DicoAppuisFlottant>)",
                                   MeasuredFormat::kMicmac);
  ASSERT_EQ(ground.points.size(), 2u);
  EXPECT_EQ(ground.points[0].sigma_m.z(), 0.2);
  EXPECT_EQ(ground.points[1].role, PointRole::kCheck);
}

TEST_F(MeasuredFiles, PatbsImageCoordinatesAreMicrometres) {
  const Measurements all =
      Read("  11 153000.0\n  1001  34214.8  -77830.8 1\n  -99\n 12\n 1001 -5000 1 1\n -99\n",
           MeasuredFormat::kPatb);
  ASSERT_EQ(all.image_points.size(), 2u);
  EXPECT_EQ(all.image_points[0].photo, "11");
  EXPECT_NEAR(all.image_points[0].photo_mm->x(), 34.2148, 1e-12);
  EXPECT_EQ(all.image_points[1].photo, "12");
  EXPECT_FALSE(all.image_points[0].pixel);
  const Measurements ground = Read("1001 500000.5 5000000 123 1\n-99\n", MeasuredFormat::kPatb);
  ASSERT_EQ(ground.points.size(), 1u);
  EXPECT_EQ(ground.points[0].ground_m.x(), 500000.5);
}

TEST_F(MeasuredFiles, BingosImageCoordinatesAreMillimetres) {
  const Measurements all =
      Read("11 rc30\n1001 34.2148 -77.8308\n-99\nCONT 1001 1 2 3\n", MeasuredFormat::kBingo);
  ASSERT_EQ(all.image_points.size(), 1u);
  EXPECT_EQ(*all.image_points[0].photo_mm, Eigen::Vector2d(34.2148, -77.8308));
  ASSERT_EQ(all.points.size(), 1u);
}

TEST_F(MeasuredFiles, APhotoWithoutAnEndAndABrokenNumberAreNamed) {
  ExpectError<InputError>([&] { Read("11 rc30\n1001 1 2\n", MeasuredFormat::kBingo); },
                          {"line 2", "photo 11", "-99"});
  ExpectError<InputError>([&] { Read("11 rc30\n1001 1 x\n-99\n", MeasuredFormat::kBingo); },
                          {"line 2", "\"x\""});
}

TEST_F(MeasuredFiles, MicmacsMarksOfTheCameraAreNoImage) {
  ExpectError<InputError>(
      [&] {
        Read(R"(<MesureAppuiFlottant1Im>
<NameIm>Glob</NameIm><OneMesureAF1I><NamePt>P1</NamePt><PtIm>0 226</PtIm></OneMesureAF1I>
</MesureAppuiFlottant1Im>)",
             MeasuredFormat::kMicmac);
      },
      {"line 2", "\"Glob\"", "MeasuresIm"});
}

TEST_F(MeasuredFiles, AMicmacPointUsedInPartIsRefused) {
  ExpectError<InputError>(
      [&] {
        Read(R"(<DicoAppuisFlottant><OneAppuisDAF><Pt>1 2 3</Pt>
<NamePt>P1</NamePt><Incertitude>0.1 0.1 -1</Incertitude></OneAppuisDAF></DicoAppuisFlottant>)",
             MeasuredFormat::kMicmac);
      },
      {"line 2", "0.1 0.1 -1"});
}

TEST_F(MeasuredFiles, AFileOfNothingIsAnErrorThatSaysWhatWasLeftOut) {
  ExpectError<InputError>([&] { Read("<Other/>", MeasuredFormat::kMicmac); },
                          {"holds no measured point", "micmac"});
  ExpectError<InputError>([&] { Read("1001 5e5 5e6\n-99\n", MeasuredFormat::kPatb); },
                          {"holds no measured point", "without a height", "1001"});
}

TEST(MeasuredFormatFromName, KnowsProgramsAndTables) {
  EXPECT_EQ(MeasuredFormatFromName("csv"), MeasuredFormat::kCsv);
  EXPECT_EQ(MeasuredFormatFromName("bingo"), MeasuredFormat::kBingo);
  EXPECT_FALSE(MeasuredFormatFromName("excel"));
}

}  // namespace
}  // namespace orient

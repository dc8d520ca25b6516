#include "core/files/orientation_table.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// Half of the last written decimal: 0.1 mm and 1e-9 degrees.
constexpr double kWrittenMetres = 0.5e-4 + 1e-9;
constexpr double kWrittenRadians = 0.5e-9 * std::numbers::pi / 180 + 1e-15;

OrientationTable ReadText(const std::string& text, OpenCells open = OpenCells::kNone) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "opk.csv", text);
  return ReadOrientationTable(folder / "opk.csv", open);
}

void ExpectRefused(const std::string& text, std::initializer_list<std::string> parts) {
  ExpectError<InputError>([&] { ReadText(text); }, parts);
}

const std::string kHeader = "filename,x,y,z,omega,phi,kappa\n";

TEST(OrientationTable, Nominal) {
  const OrientationTable table =
      ReadText(kHeader + "4711,500123.4,5000321,1823.9,0.12,-0.3,91.2\n");
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0].photo, "4711");
  EXPECT_EQ(table.rows[0].pose.position_m, Eigen::Vector3d(500123.4, 5000321, 1823.9));
  EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad.x(), RadFromDeg(0.12));
  EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad.y(), RadFromDeg(-0.3));
  EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad.z(), RadFromDeg(91.2));
  EXPECT_FALSE(table.rows[0].sigma);
  EXPECT_FALSE(table.crs) << "there is no .prj beside it";
}

TEST(OrientationTable, TextAsPeopleAndSpreadsheetsWriteIt) {
  const OrientationTable table = ReadText(
      "\xEF\xBB\xBF# flown in 1961\r\n"
      "filename , x,y,z,omega,phi,kappa\r\n"
      "\r\n"
      " \"a, \"\"b\"\"\" , 1, +2 ,3,0,0, 180\r\n"
      "c,1e3,2,3,0,0,-180");
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[0].photo, "a, \"b\"");
  EXPECT_EQ(table.rows[0].pose.position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(table.rows[1].photo, "c");
  EXPECT_EQ(table.rows[1].pose.position_m.x(), 1000);
  EXPECT_DOUBLE_EQ(table.rows[1].pose.opk_rad.z(), std::numbers::pi) << "angles are in (-180, 180]";
}

TEST(OrientationTable, ACarriageReturnAloneEndsALineToo) {
  const OrientationTable table =
      ReadText("filename,x,y,z,omega,phi,kappa\ra,1,2,3,0,0,0\r\rb,4,5,6,0,0,0\r");
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[1].photo, "b");
  EXPECT_EQ(table.rows[1].pose.position_m, Eigen::Vector3d(4, 5, 6));
}

TEST(OrientationTable, Utf16IsRefusedByItsName) {
  std::string wide;
  for (const char c : kHeader) wide.append({c, '\0'});
  ExpectRefused(wide, {"UTF-16", "UTF-8"});
  ExpectRefused("\xFF\xFE" + wide, {"UTF-16", "UTF-8"});
}

TEST(OrientationTable, ColumnsAreFoundByNameInAnyOrderBesideOthers) {
  const OrientationTable table =
      ReadText("kappa,phi,omega,time,z,y,x,filename\n3,2,1,noon,30,20,10,p\n");
  EXPECT_EQ(table.rows.at(0).photo, "p");
  EXPECT_EQ(table.rows[0].pose.position_m, Eigen::Vector3d(10, 20, 30));
  EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad.x(), RadFromDeg(1));
  EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad.z(), RadFromDeg(3));
}

TEST(OrientationTable, HeadersOfOtherProgramsAreUnderstood) {
  for (const std::string text :
       {"#Label,X/Easting,Y/Northing,Z/Altitude,Omega,Phi,Kappa\np.tif,10,20,30,1,2,3\n",
        "# flown \"low\", in 1961\nName;X;Y;Z;O;P;K;Camera\np;10;20;30;1;2;3;RC10\n",
        "ImageId\tID\tEasting\tNorthing\tHeight\tOmega[deg]\tPhi [deg]\tKappa (deg)\n"
        "\tp\t10\t20\t30\t1\t2\t3\n",
        "FILENAME,X [m],Y [m],Z [m],OMEGA,PHI,KAPPA,id\nfolder/p.JPG,10,20,30,1,2,3,7\n"}) {
    const OrientationTable table = ReadText(text);
    ASSERT_EQ(table.rows.size(), 1u) << text;
    EXPECT_EQ(table.rows[0].photo, "p") << text;
    EXPECT_EQ(table.rows[0].pose.position_m, Eigen::Vector3d(10, 20, 30)) << text;
    EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad.z(), RadFromDeg(3)) << text;
  }
}

// Rx(omega) Ry(phi) Rz(kappa) in degrees in both, as here; Metashape's matrix is not read.
TEST(OrientationTable, CamerasExportedByMetashapeAreRead) {
  const std::string header =
      "# Cameras (2)\n# PhotoID, X, Y, Z, Omega, Phi, Kappa, r11, r12, r13, r21, r22, r23, r31, "
      "r32, "
      "r33\n";
  const std::string matrix_rows = "\t1\t0\t0\t0\t1\t0\t0\t0\t1\n";
  for (const bool commas : {false, true}) {
    std::string text = header;
    text += "strip 2, no. 7\t500123.25\t5000321.5\t1823.75\t1\t-2\t91";
    text += matrix_rows;
    text += "4712.tif\t500823\t5000321\t1824\t0\t0\t90";
    text += matrix_rows;
    if (commas) {
      text.replace(text.find("2, no"), 2, "2");
      std::replace(text.begin(), text.end(), '\t', ',');
    }
    const OrientationTable table = ReadText(text);
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_EQ(table.rows[0].photo, commas ? "strip 2 no. 7" : "strip 2, no. 7");
    EXPECT_EQ(table.rows[0].pose.position_m, Eigen::Vector3d(500123.25, 5000321.5, 1823.75));
    EXPECT_EQ(table.rows[0].pose.opk_rad,
              Eigen::Vector3d(RadFromDeg(1), RadFromDeg(-2), RadFromDeg(91)));
    EXPECT_EQ(table.rows[1].photo, "4712");
  }
  ExpectRefused(header + "a\t1\t2\t3\t0\t0\n", {"line 3", "the header 16"});
}

TEST(OrientationTable, CameraParametersOfPix4dAreRead) {
  const std::string header = "imageName X Y Z Omega Phi Kappa \n";
  const OrientationTable table = ReadText(
      header +
      "DSC_0157.JPG 332081.126 3488911.819856  4093.688402 -2.946680 3.053212 119.804001\r\n"
      "DSC_0158.JPG 332181.126 3488911.819856 4093.688402 0 0 0\n");
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[0].photo, "DSC_0157");
  EXPECT_EQ(table.rows[0].pose.position_m,
            Eigen::Vector3d(332081.126, 3488911.819856, 4093.688402));
  EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad.z(), RadFromDeg(119.804001));
  ExpectRefused(header + "DSC 0157.JPG 1 2 3 0 0 0\n", {"line 2", "8 cells", "7", "tabs"});
}

TEST(OrientationTable, OtherUnitsAndTwoColumnsOfOneMeaningAreRefused) {
  ExpectRefused("filename,x,y,z,omega[gon],phi[gon],kappa[gon]\np,1,2,3,0,0,0\n",
                {"no column \"omega\"", "omega[gon]", "degrees"});
  ExpectRefused("filename,x/longitude,y/latitude,z,omega,phi,kappa\np,1,2,3,0,0,0\n",
                {"no column \"x\""});
  ExpectRefused("filename,x,Easting,y,z,omega,phi,kappa\np,1,1,2,3,0,0,0\n", {"\"x\"", "twice"});
}

void ExpectRefusedOfApproximations(const std::string& text, OpenCells open,
                                   std::initializer_list<std::string> parts) {
  ExpectError<InputError>([&] { ReadText(text, open); }, parts);
}

TEST(OrientationTable, EmptyAnglesOfAnApproximationAreUnknown) {
  const OrientationTable table =
      ReadText(kHeader + "a,1,2,3,1,2,\nb,1,2,3,,,\nc,1,2,3,,,90\n", OpenCells::kAngles);
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_FALSE(table.rows[0].attitude_known);
  EXPECT_EQ(table.rows[0].pose.opk_rad, Eigen::Vector3d(RadFromDeg(1), RadFromDeg(2), 0));
  EXPECT_FALSE(table.rows[1].attitude_known);
  EXPECT_EQ(table.rows[1].pose.opk_rad, Eigen::Vector3d::Zero());
  EXPECT_TRUE(table.rows[2].attitude_known);
  EXPECT_EQ(table.rows[2].pose.opk_rad, Eigen::Vector3d(0, 0, RadFromDeg(90)));
  ExpectRefused(kHeader + "a,1,2,3,1,2,\n", {"line 2", "kappa is \"\""});
}

TEST(OrientationTable, SigmasOfEmptyCellsAreThoseOfUnknownValues) {
  const OrientationTable table = ReadText(
      "filename,x,y,z,omega,phi,kappa,sigma_x,sigma_y,sigma_z,sigma_omega,sigma_phi,sigma_kappa\n"
      "a,1,2,,,,,0.1,0.2,,,,2\nb,1,2,,,,9,20,30,,1,1,2\n",
      OpenCells::kAnglesAndHeights);
  Vector6d sigma;
  sigma << 0.1, 0.2, 10, RadFromDeg(3), RadFromDeg(3), std::numbers::pi;
  EXPECT_EQ(table.rows.at(0).sigma, sigma);
  sigma << 20, 30, 30, RadFromDeg(1), RadFromDeg(1), RadFromDeg(2);
  EXPECT_EQ(table.rows.at(1).sigma, sigma);
  ExpectRefusedOfApproximations("filename,x,y,z,sigma_x,sigma_y,sigma_z\na,1,2,3,1e-300,0.2,1\n",
                                OpenCells::kAngles, {"line 2", "sigma_x", "1e-300"});
  ExpectRefusedOfApproximations("filename,x,y,z,sigma_x,sigma_y,sigma_z\na,1,2,3,0.1,0.2,\n",
                                OpenCells::kAngles, {"line 2", "sigma_z"});
}

TEST(OrientationTable, AnEmptyHeightNeedsTheFlyingHeight) {
  const std::string text = "filename,x,y,z\na,1,2,3\nb,1,2,\n";
  EXPECT_TRUE(
      std::isnan(ReadText(text, OpenCells::kAnglesAndHeights).rows.at(1).pose.position_m.z()));
  ExpectRefusedOfApproximations(text, OpenCells::kAngles, {"line 3", "z is empty", "[flight]"});
  ExpectRefused(kHeader + "b,1,2,,0,0,0\n", {"line 2", "z is \"\""});
}

TEST(OrientationTable, ARowWithoutPositionIsNone) {
  const OrientationTable table =
      ReadText("filename,x,y,z\na,1,2,3\nb,,,\nc,1,,3\n", OpenCells::kAngles);
  EXPECT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.without_position, (std::vector<std::string>{"b", "c"}));
  ExpectRefused(kHeader + "b,,2,3,0,0,0\n", {"line 2", "x is \"\""});
}

TEST(OrientationTable, ATableWithoutHeightsIsReadWithAnyDelimiter) {
  for (const char* text : {"filename;x;y\na;1;2\n", "#Label,X,Y\na,1,2\n"})
    EXPECT_EQ(ReadText(text, OpenCells::kAnglesAndHeights).rows.at(0).pose.position_m.y(), 2);
}

TEST(OrientationTable, HeightsInAnotherUnitAreNoMissingOnes) {
  for (const OpenCells open : {OpenCells::kNone, OpenCells::kAngles, OpenCells::kAnglesAndHeights})
    ExpectRefusedOfApproximations("filename,x,y,z [ft],omega,phi,kappa\na,1,2,3,0,0,0\n", open,
                                  {"line 1", "\"z [ft]\"", "metres"});
}

TEST(OrientationTable, LongitudesAreReferredToVectorFiles) {
  ExpectRefusedOfApproximations("filename,lon,lat,height\na,1,2,3\n", OpenCells::kAngles,
                                {"line 1", "longitude", "GeoJSON", "GeoPackage"});
}

TEST(OrientationTable, ColumnsOfAnglesThatAreNotReadAreNamed) {
  const auto ignored = [](const std::string& columns) {
    const auto count = std::count(columns.begin(), columns.end(), ',');
    std::string text = "filename,x,y,z" + columns + "\na,1,2,3";
    for (std::ptrdiff_t i = 0; i < count; ++i) text += ",4";
    return ReadText(text + "\n", OpenCells::kAngles).ignored_angles;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(ignored(",Omega [gon],Phi_rad,Kappa(rad)"),
            (Names{"Omega [gon]", "Phi_rad", "Kappa(rad)"}));
  EXPECT_EQ(ignored(",yaw,Pitch,roll,heading_deg"), (Names{"yaw", "Pitch", "roll", "heading_deg"}));
  EXPECT_EQ(ignored(",photographer,time"), Names{});
  EXPECT_EQ(ignored(",roll"), Names{}) << "the film's number";
  EXPECT_EQ(ignored(",omega,phi,kappa,yaw"), Names{}) << "nothing is missed";
}

TEST(OrientationTable, OnlyAnImagesEndingIsNoPartOfItsName) {
  const OrientationTable table =
      ReadText(kHeader + "4711.a,1,2,3,0,0,0\n17.5,1,2,3,0,0,0\nb c.TIFF,1,2,3,0,0,0\n");
  EXPECT_EQ(table.rows.at(0).photo, "4711.a");
  EXPECT_EQ(table.rows.at(1).photo, "17.5");
  EXPECT_EQ(table.rows.at(2).photo, "b c");
}

TEST(OrientationTable, SigmasAreReadWhereTheyAre) {
  const OrientationTable table = ReadText(
      "filename,x,y,z,omega,phi,kappa,sigma_x,sigma_y,sigma_z,sigma_omega,sigma_phi,sigma_kappa\n"
      "a,1,2,3,0,0,0,0.1,0.2,0.3,1,2,3\nb,1,2,3,0,0,0,,,,,,\n");
  ASSERT_TRUE(table.rows.at(0).sigma);
  EXPECT_EQ((*table.rows[0].sigma)[1], 0.2);
  EXPECT_DOUBLE_EQ((*table.rows[0].sigma)[5], RadFromDeg(3));
  EXPECT_FALSE(table.rows.at(1).sigma);
}

TEST(OrientationTable, FindGivesTheRowOrNull) {
  const OrientationTable table = ReadText(kHeader + "a,1,2,3,0,0,0\nb,4,5,6,0,0,0\n");
  ASSERT_NE(table.Find("b"), nullptr);
  EXPECT_EQ(table.Find("b")->pose.position_m.x(), 4);
  EXPECT_EQ(table.Find("c"), nullptr);
}

TEST(OrientationTable, ABrokenLineIsNamedWithLineColumnAndValue) {
  ExpectRefused(kHeader + "a,1,2,3,0,0,0\nb,1,2,x3,0,0,0\n", {"line 3, column 7", "z is \"x3\""});
  ExpectRefused(kHeader + "# note\r\n\r\na,1,2,3,0,0,0\r\nb,1,2,3,0, ,0\r\n",
                {"line 5, column 11", "phi is \"\""});
  ExpectRefused(kHeader + "a,1,2,3,0,0\n", {"line 2", "6 cells", "7"});
  ExpectRefused(kHeader + "a,1,2,3,0,0,0,9\n", {"line 2", "8 cells"});
  ExpectRefused(kHeader + "a,1;5,2,3,0,0,0\n", {"line 2, column 3", "1;5"});
  ExpectRefused(kHeader + "a,nan,2,3,0,0,0\n", {"line 2", "nan"});
  ExpectRefused(kHeader + "a,1,2,3,0,0,1e999\n", {"line 2", "1e999"});
  ExpectRefused(kHeader + "a,1,2,3,0,0,400\n", {"line 2", "kappa", "degrees"});
  ExpectRefused(kHeader + ",1,2,3,0,0,0\n", {"line 2", "no name"});
  ExpectRefused(kHeader + "\"a,1,2,3,0,0,0\n", {"line 2, column 1", "never closed"});
  ExpectRefused(kHeader + "\"a\"b,1,2,3,0,0,0\n", {"line 2, column 1", "quote"});
}

TEST(OrientationTable, APhotoNamedTwiceIsAnError) {
  ExpectRefused(kHeader + "a,1,2,3,0,0,0\na,1,2,3,0,0,1\n", {"line 3", "\"a\"", "second time"});
}

TEST(OrientationTable, AHeaderThatLacksOrRepeatsAColumnIsAnError) {
  ExpectRefused("", {"empty"});
  ExpectRefused("filename,x,y,z,omega,phi\na,1,2,3,0,0\n", {"kappa"});
  ExpectRefused("filename,x,y,z,omega,phi,kappa,x\n", {"\"x\"", "twice"});
  ExpectRefused("filename,x,y,z,omega,phi,kappa,sigma_x\n", {"sigma"});
  ExpectRefused("filename,x,y,z,omega,phi,kappa,sigma_x,sigma_y,sigma_z\n", {"sigma"});
  ExpectRefused("a,1,2,3,0,0,0\n", {"line 1", "filename"});
}

TEST(OrientationTable, SigmasMustBeFitForWeights) {
  ExpectRefused(
      "filename,x,y,z,omega,phi,kappa,sigma_x,sigma_y,sigma_z,sigma_omega,sigma_phi,sigma_kappa\n"
      "a,1,2,3,0,0,0,0.1,0,0.3,1,2,3\n",
      {"line 2", "sigma_y", "must lie between"});
  ExpectRefused(
      "filename,x,y,z,omega,phi,kappa,sigma_x,sigma_y,sigma_z,sigma_omega,sigma_phi,sigma_kappa\n"
      "a,1,2,3,0,0,0,0.1,1e308,0.3,1,2,3\n",
      {"line 2", "sigma_y", "must lie between"});
}

TEST(OrientationTable, ANameThatASpreadsheetTakesForAFormulaComesBack) {
  const TemporaryFolder folder;
  WriteOrientationTable(folder / "t.csv", {{{"=1+1", Pose{}, std::nullopt}}, std::nullopt});
  EXPECT_NE(ReadFile(folder / "t.csv").find("'=1+1,"), std::string::npos);
  EXPECT_EQ(ReadOrientationTable(folder / "t.csv").rows[0].photo, "=1+1");
}

RC_GTEST_PROP(OrientationTable, RoundtripKeepsTheWrittenDigits, ()) {
  const auto metre = [](int range) { return *rc::gen::inRange(-range, range) / 7.0; };
  OrientationTable table;
  OrientationRow row;
  row.photo = "p\"1\", #x";
  row.pose.position_m = {metre(10000000), metre(70000000), metre(100000)};
  for (int i = 0; i < 3; ++i) row.pose.opk_rad[i] = *rc::gen::inRange(-3141592, 3141592) * 1e-6;
  if (*rc::gen::arbitrary<bool>()) row.sigma = Vector6d::Constant(0.001234);
  table.rows = {row, {"plain", Pose{}, std::nullopt}};

  const TemporaryFolder folder;
  WriteOrientationTable(folder / "t.csv", table);
  const OrientationTable read = ReadOrientationTable(folder / "t.csv");
  RC_ASSERT(read.rows.size() == 2u);
  RC_ASSERT(read.rows[0].photo == row.photo);
  RC_ASSERT((read.rows[0].pose.position_m - row.pose.position_m).cwiseAbs().maxCoeff() <
            kWrittenMetres);
  RC_ASSERT((read.rows[0].pose.opk_rad - row.pose.opk_rad).cwiseAbs().maxCoeff() < kWrittenRadians);
  RC_ASSERT(read.rows[0].sigma.has_value() == row.sigma.has_value());
  RC_ASSERT(!read.rows[1].sigma.has_value());
}

TEST(OrientationTable, TheHeaderIsWhatOrthorectifiersRead) {
  const TemporaryFolder folder;
  WriteOrientationTable(folder / "t.csv", {{{"a", Pose{}, std::nullopt}}, std::nullopt});
  EXPECT_EQ(ReadFile(folder / "t.csv"),
            "filename,x,y,z,omega,phi,kappa\n"
            "a,0.0000,0.0000,0.0000,0.000000000,0.000000000,0.000000000\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "t.prj"));
}

TEST(OrientationTable, TheCrsTravelsInThePrjBesideTheTable) {
  const TemporaryFolder folder;
  const Crs crs = Crs::Parse("EPSG:32635", "test");
  WriteOrientationTable(folder / "t.csv", {{{"a", Pose{}, std::nullopt}}, crs});
  const OrientationTable read = ReadOrientationTable(folder / "t.csv");
  ASSERT_TRUE(read.crs);
  EXPECT_TRUE(read.crs->SameAs(crs));
}

TEST(OrientationTable, APoseThatIsNotFiniteIsNeverWritten) {
  const TemporaryFolder folder;
  OrientationRow row{"a", Pose{}, std::nullopt};
  row.pose.position_m.z() = std::numeric_limits<double>::infinity();
  EXPECT_THROW(WriteOrientationTable(folder / "t.csv", {{row}, std::nullopt}),
               std::invalid_argument);
}

TEST(OrientationTable, PhotoNamesAreFileNamesWithoutFolderAndExtension) {
  EXPECT_EQ(PhotoName("dir/4711.tif"), "4711");
  EXPECT_EQ(PhotoName("/vsizip/a.zip/3324c_05.0182_RGB.tif"), "3324c_05.0182_RGB");
  EXPECT_EQ(PhotoName("4711"), "4711");
}

TEST(OrientationTable, ThePublishedNgiOrientationReads) {
  ORIENT_REQUIRE_SHARED_DATA(path, "ngi/published_orientation.csv");
  const OrientationTable table = ReadOrientationTable(path);
  ASSERT_EQ(table.rows.size(), 4u);
  const OrientationRow* row = table.Find("3324c_2015_1004_06_0253_RGB");
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->pose.position_m, Eigen::Vector3d(-55081.773, -3731564.362, 5243.466));
  EXPECT_DOUBLE_EQ(row->pose.opk_rad.y(), RadFromDeg(-0.415));
  ASSERT_TRUE(table.crs) << "the .prj beside it holds a PROJ string";
}

TEST(OrientationTable, LongitudesAreRefusedWithAWordWhateverSeparatesThem) {
  for (const char separator : {',', ';', '\t'}) {
    std::string text = "filename,lon,lat,height\np,25.1,57.2,1500\n";
    std::replace(text.begin(), text.end(), ',', separator);
    ExpectRefusedOfApproximations(text, OpenCells::kAngles,
                                  {"no column \"x\"", "longitude and latitude", "GeoPackage"});
  }
  ExpectRefused("filename;east;north;omega;phi;kappa\np;1;2;0;0;0\n", {"no column \"z\""});
}

}  // namespace
}  // namespace orient
